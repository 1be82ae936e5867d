//! A recording diagnosed, with the model that is written: what `mgpi diagnose` does, and `diagnose`
//! of the Python package.

use std::path::PathBuf;
use std::time::Instant;

use model_core::ParameterError;
use thiserror::Error;

use crate::extend::heldout::on_another;
use crate::extend::{Extended, Extension, HeldOutGain, Operator, Written, rows};
use crate::{Columns, Diagnosis, DiagnosisError, diagnose_and_extend};
use identification::HostModel;
use recording::lateness::{self, NotSimulated};
use recording::model_file::control::Recorded;
use recording::model_file::{HeldOut, Identification, ModelFile};
use recording::table::{DataError, Table};
use recording::unit::Unit;
use recording::{Choice, Recording, Rest, Source};

/// A recording with the columns that a diagnosis looks at.
#[derive(Clone, Debug)]
pub struct Examined {
    /// Its columns, a noisy input smoothed.
    pub columns: Columns,
    /// The recording, its input as that of the columns.
    pub recording: Recording,
    /// The files that it comes from: several, where it is several recordings of one muscle.
    pub sources: Vec<Source>,
}

/// A diagnosis, with the model that is written and what it gains.
#[derive(Clone, Debug)]
pub struct Diagnosed {
    /// The diagnosis.
    pub diagnosis: Diagnosis,
    /// The model extended by what is named.
    pub extended: Extended,
    /// What that gains on what took no part in it.
    pub gain: HeldOutGain,
    /// The model that is written.
    pub written: Written,
    /// What was diagnosed.
    pub examined: Examined,
    /// Another recording that the gain was counted on, if there was one.
    pub other: Option<Recording>,
    /// How long it took. Unit: s.
    pub seconds: f64,
}

/// Why a recording is not diagnosed.
#[derive(Debug, Error)]
pub enum NotDiagnosed {
    /// Nothing can be said of it.
    #[error(transparent)]
    Diagnosis(#[from] DiagnosisError),
    /// No model of it runs through a recording.
    #[error("{}: the model does not run through the recording", .0.display())]
    NotSimulated(PathBuf),
}

impl Columns {
    /// What the recording shows of time and noise beside a model, for the control of its muscle.
    ///
    /// # Errors
    /// See [`NotSimulated`].
    pub fn recorded(&self, model: &ModelFile) -> Result<Recorded, NotSimulated> {
        let columns = self.as_measured();
        let seen = lateness::Recording {
            rows: rows(&columns),
            scored: &columns.scored,
            output: &columns.output,
            command: columns.command.as_deref(),
        };
        lateness::recorded(model, &seen)
    }
}

impl Examined {
    /// The columns of a table: `load_n`, `temperature_c` and, beside a pressure, the command are
    /// used where they are there.
    ///
    /// # Errors
    /// The table is no recording ([`Recording::of`]).
    pub fn of(table: &Table, choice: &Choice) -> Result<Self, DataError> {
        let mut recording = Recording::of(table, choice)?;
        let mut notes = Vec::new();
        let mut column = |name: &str, unit: Unit| match recording.drive.beside(table, name, unit) {
            Ok(found) => found.map(|found| {
                notes.extend(found.note);
                found.values
            }),
            Err(why) => {
                notes.push(format!("{name} is not used: {why}"));
                None
            }
        };
        let (load_n, temperature_c) = (column("load_n", Unit::N), column("temperature_c", Unit::CELSIUS));
        let input_is_command = recording.drive.input.channel.name.starts_with("command");
        let input_unit = recording.drive.input.channel.unit;
        let command = if input_is_command {
            None
        } else {
            column(&format!("command_{}", input_unit.suffix()), input_unit)
        };
        recording.drive.notes.extend(notes);
        let Recording { drive, output, left_out } = &recording;
        let columns = Columns {
            command,
            load_n,
            temperature_c,
            time_s: drive.time_s.clone(),
            input: drive.input.values.clone(),
            input_unit: drive.input.channel.unit,
            output_unit: output.channel.unit,
            input_is_command,
            output: output.values.clone(),
            scored: drive.scored.clone(),
            past_unknown_until_s: left_out.past_unknown_until_s(),
            drop_outs: left_out.drop_outs.clone(),
            smoothing: None,
            measured_input: None,
        }
        .with_smooth_input();
        recording.drive.input.values.clone_from(&columns.input);
        let sources = vec![recording.source()];
        Ok(Self { columns, recording, sources })
    }

    /// Several recordings of one muscle as one, the muscle let down and left at rest between them ([`Rest`]). A column
    /// beside input and output is used if all have it. Time goes on: a drift or a warm-up acts in the rests too.
    ///
    /// # Errors
    /// The list is empty, or the recordings do not go together ([`Recording::joined`]).
    pub fn joined(mut parts: Vec<Self>) -> Result<Self, DataError> {
        if parts.len() == 1
            && let Some(one) = parts.pop()
        {
            return Ok(one);
        }
        let recordings: Vec<Recording> = parts.iter().map(|part| part.recording.clone()).collect();
        let rest = Rest::between(&recordings);
        let recording = Recording::joined_at_rest(&recordings, rest)?;
        let of_all = |of: fn(&Columns) -> Option<&Vec<f64>>, lowest: Option<f64>| -> Option<Vec<f64>> {
            let mut columns = parts.iter().map(|part| of(&part.columns));
            let mut all = columns.next().flatten()?.clone();
            for column in columns {
                let rests = all.len();
                Rest::append(&mut all, column?);
                lowest.into_iter().for_each(|lowest| all[rests..rests + 2].fill(lowest));
            }
            Some(all)
        };
        let Recording { drive, output, .. } = &recording;
        let smoothings = || parts.iter().filter_map(|part| part.columns.smoothing);
        let noisiest = smoothings().max_by(|one, other| one.noise.total_cmp(&other.noise));
        let columns = Columns {
            time_s: drive.time_s.clone(),
            input: drive.input.values.clone(),
            command: of_all(|columns| columns.command.as_ref(), Some(rest.input)),
            output: output.values.clone(),
            scored: drive.scored.clone(),
            load_n: of_all(|columns| columns.load_n.as_ref(), None),
            temperature_c: of_all(|columns| columns.temperature_c.as_ref(), None),
            past_unknown_until_s: recording.left_out.past_unknown_until_s(),
            smoothing: noisiest,
            measured_input: noisiest.and(of_all(measured_input, Some(rest.input))),
            drop_outs: recording.left_out.drop_outs.clone(),
            ..parts[0].columns
        };
        let sources = recordings.iter().map(Recording::source).collect();
        Ok(Self { columns, recording, sources })
    }

    /// Diagnoses it. `given`: an operator model to go on from. `other`: what the gain is counted on
    /// in the place of its own last third. `progress` is called with a share of the work and what
    /// is being done.
    ///
    /// # Errors
    /// See [`NotDiagnosed`].
    pub fn diagnosed(
        self,
        given: Option<&Operator>,
        other: Option<Self>,
        progress: &(dyn Fn(f64, &str) + Sync),
    ) -> Result<Diagnosed, NotDiagnosed> {
        let Self { columns, recording, .. } = &self;
        let begin = Instant::now();
        let (diagnosis, extended) = diagnose_and_extend(columns, given, progress)?;
        let seconds = begin.elapsed().as_secs_f64();
        let others = other.as_ref().map(|other| &other.columns);
        let gain = others.map_or(Some(extended.heldout), |columns| on_another(columns, &extended));
        let measured = others.map(Columns::as_measured);
        let written = extended.written(&columns.as_measured(), measured.as_deref());
        let run_through = &other.as_ref().map_or(recording, |other| &other.recording).drive.file;
        let (gain, written) =
            gain.zip(written).ok_or_else(|| NotDiagnosed::NotSimulated(run_through.clone()))?;
        let other = other.map(|other| other.recording);
        Ok(Diagnosed { diagnosis, extended, gain, written, examined: self, other, seconds })
    }
}

/// The input as it was measured.
fn measured_input(columns: &Columns) -> Option<&Vec<f64>> {
    Some(columns.measured_input.as_ref().unwrap_or(&columns.input))
}

impl Diagnosed {
    /// The model that is written, as its file has it; what it gains may be told by another
    /// recording.
    ///
    /// # Errors
    /// The parameters are those of no model.
    pub fn model(&self) -> Result<ModelFile, ParameterError> {
        let Self { written, examined: Examined { recording, sources, .. }, other, .. } = self;
        let Extension { parameters, density, extensions, .. } = &written.model.of_muscle();
        let heldout = Some(HeldOut {
            recording: other.as_ref().unwrap_or(recording).source(),
            from_s: written.gain.from_s,
            by_recording: false,
            figures: written.gain.after,
        });
        let identification = Identification::of(
            recording,
            &written.simulated,
            heldout,
            written.starts,
            written.termination.to_string(),
            Vec::new(),
        );
        let identification = match &sources[..] {
            [first, further @ ..] => {
                Identification { recording: first.clone(), further: further.to_vec(), ..identification }
            }
            [] => identification,
        };
        Ok(ModelFile {
            input: recording.drive.input.channel.clone(),
            output: recording.output.channel.clone(),
            density: *density,
            parameters: parameters.clone(),
            extensions: extensions.clone(),
            model: HostModel::try_new(parameters)?,
            identification: Some(identification),
            recorded: None,
            tuning: None,
        }
        .with_usual_lead_limit())
    }
}
