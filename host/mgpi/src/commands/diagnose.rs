//! `mgpi diagnose`: what a simulation gets wrong about a recording, and why.

use std::path::{Path, PathBuf};
use std::time::Instant;

use clap::Args;
use indicatif::{ProgressBar, ProgressStyle};

use super::search::Columns as Chosen;
use super::{diagnosed_json, diagnosed_summary, recorded};
use crate::Error;
use crate::output::Outputs;
use diagnosis::extend::heldout::on_another;
use diagnosis::extend::{Extension, Operator, Written};
use diagnosis::{Columns, diagnose_and_extend};
use identification::HostModel;
use recording::TOOL;
use recording::model_file::{HeldOut, Identification, ModelFile};
use recording::worth::Limit;
use recording::{Choice, Recording};
use report::diagnosed;

/// Shows what a simulation gets wrong about a recording, and names the cause.
#[derive(Args, Debug)]
pub struct Arguments {
    /// The recording; load_n, temperature_c and, beside pressure_bar, command_bar are used where
    /// they are there
    #[arg(value_name = "REC.csv")]
    recording: PathBuf,
    /// Also write the model, extended by the named causes where that is better, for simulate, pil
    /// and the board
    #[arg(short = 'o', value_name = "EXTENDED.toml")]
    model_file: Option<PathBuf>,
    /// An operator model to begin with; one of too poor a form, or of another muscle, is said to be
    /// that
    #[arg(long, value_name = "MODEL.toml")]
    model: Option<PathBuf>,
    /// Another recording of the same muscle that the gain is counted on [default: the last third of
    /// the rows]
    #[arg(long, value_name = "REC2.csv")]
    validate: Option<PathBuf>,
    /// Also write a page that shows it: one HTML file
    #[arg(long, value_name = "REPORT.html")]
    report: Option<PathBuf>,
    /// Also write the diagnosis as JSON
    #[arg(long, value_name = "DIAGNOSIS.json")]
    json: Option<PathBuf>,
    #[command(flatten)]
    columns: Chosen,
    /// Overwrite existing outputs
    #[arg(long)]
    force: bool,
}

/// Diagnoses.
///
/// # Errors
/// The recording is not what it should be or too short, or an output cannot be written.
pub fn run(arguments: &Arguments) -> Result<(), Error> {
    let Arguments { recording: file, model_file, model, validate, report, json, .. } = arguments;
    let inputs: Vec<&Path> = [file].into_iter().chain(validate).chain(model).map(PathBuf::as_path).collect();
    let mut outputs = Outputs::claim(model_file.iter().chain(report).chain(json), &inputs, arguments.force)?;
    let given = model.as_ref().map(|model| ModelFile::read(model)).transpose()?;
    let choice = match &given {
        Some(given) => arguments.columns.choice().like(&given.input, &given.output),
        None => arguments.columns.choice(),
    };
    let (columns, recording) = read(file, &choice)?;
    let given = given.map(|file| Operator { parameters: file.parameters, density: file.density });
    let other =
        validate.as_ref().map(|file| read(file, &arguments.columns.choice_of(&recording))).transpose()?;
    let begin = Instant::now();
    let (diagnosis, extended) = with_bar(|progress| diagnose_and_extend(&columns, given.as_ref(), progress))
        .map_err(|source| Error::Diagnosis { file: file.clone(), source })?;
    let seconds = begin.elapsed().as_secs_f64();
    let others = other.as_ref().map(|(columns, _)| columns);
    let gain = others.map_or(Some(extended.heldout), |columns| on_another(columns, &extended));
    let measured = others.map(Columns::as_measured);
    let written = extended.written(&columns.as_measured(), measured.as_deref());
    let (gain, written) = gain
        .zip(written)
        .ok_or_else(|| Error::NotSimulated(validate.clone().unwrap_or_else(|| file.clone())))?;
    if let Some(model_file) = model_file {
        let other = other.as_ref().map(|(_, other)| other);
        let mut file = to_file(&recording, &written, other)?;
        file.recorded = recorded::of_columns(&file, &columns.as_measured());
        outputs.stage(model_file, file.to_toml().as_bytes())?;
    }
    if let Some(report) = report {
        let gained = diagnosed::Gained {
            extended: &extended,
            gain: &gain,
            written: &written,
            other: validate.as_ref().map(|file| file.display().to_string()),
        };
        outputs
            .stage(report, diagnosed::to_html(&diagnosis, &columns, &recording, Some(&gained)).as_bytes())?;
    }
    let found = (&extended, &gain, &written);
    if let Some(json) = json {
        let text = format!("{:#}\n", diagnosed_json::to_json(&diagnosis, found, &recording, seconds));
        outputs.stage(json, text.as_bytes())?;
    }
    outputs.commit()?;
    diagnosed_summary::print((file, model_file.as_deref()), (&diagnosis, &recording), found, seconds);
    Ok(())
}

/// The file of the model that is written; what it gains may be told by another recording.
fn to_file(recording: &Recording, written: &Written, other: Option<&Recording>) -> Result<ModelFile, Error> {
    let Extension { parameters, density, extensions } = &written.model;
    let heldout = Some(HeldOut {
        recording: other.unwrap_or(recording).source(),
        from_s: other.is_none().then_some(written.gain.from_s),
        figures: written.gain.after,
    });
    let training = recording.figures(&written.simulated);
    Ok(ModelFile {
        input: recording.drive.input.channel.clone(),
        output: recording.output.channel.clone(),
        density: *density,
        parameters: parameters.clone(),
        extensions: extensions.clone(),
        model: HostModel::try_new(parameters)?,
        identification: Some(Identification {
            tool: TOOL.to_owned(),
            recording: recording.source(),
            scored_rows: recording.drive.scored.iter().filter(|&&scored| scored).count(),
            stroke: recording.stroke(),
            limit: Limit::of(recording, &training, heldout.as_ref().map(|heldout| &heldout.figures)),
            training,
            heldout,
            starts: written.starts,
            termination: written.termination.to_string(),
            standard_errors: Vec::new(),
        }),
        recorded: None,
        tuning: None,
    }
    .with_usual_lead_limit())
}

/// The columns of a recording that a diagnosis looks at, a noisy input smoothed, and the recording
/// that they are from.
///
/// # Errors
/// The recording is not what it should be.
pub fn read(file: &Path, choice: &Choice) -> Result<(Columns, Recording), Error> {
    let table = choice.table(file)?;
    let mut recording = Recording::of(&table, choice)?;
    let columns = Columns::of(&table, &mut recording);
    recording.drive.announce();
    Ok((columns, recording))
}

/// Works with a bar that shows how far it is, and with what.
fn with_bar<T>(work: impl FnOnce(&(dyn Fn(f64, &str) + Sync)) -> T) -> T {
    const PARTS: f64 = 1000.0;
    let style = ProgressStyle::with_template("diagnosing {wide_bar} {percent} % {msg}");
    let bar =
        ProgressBar::new(PARTS as u64).with_style(style.unwrap_or_else(|_| ProgressStyle::default_bar()));
    let result = work(&|share, what| {
        bar.set_position((PARTS * share) as u64);
        bar.set_message(what.to_owned());
    });
    bar.finish_and_clear();
    result
}
