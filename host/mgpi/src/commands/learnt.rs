//! What was learnt over repetitions, in a file: a correction a tick, with the reference that it is
//! for.

use std::fmt::Write as _;
use std::path::{Path, PathBuf};

use clap::Args;
use model_core::Mode;
use recording::model_file::ModelFile;
use recording::{Choice, TOOL};
use tuning::learning::{Learner, Next, Pass};
use tuning::response::Feedback;
use wire::BoardParameters;

use super::tuned;
use crate::Error;
use crate::output::Outputs;
use board_client::pil::lock_step::Sample;
use board_client::pil::reference::Reference;

/// The column of what a board is given beside the reference.
const CORRECTION: &str = "correction_mm";
/// The column of the reference in the same file.
const REFERENCE: &str = "reference_mm";
/// References that differ by no more are the same: the last digit that is written. Unit: mm.
const SAME_MM: f64 = 1e-3;

/// Repetitions, and what is learnt from them.
#[derive(Args, Clone, Debug)]
#[command(next_help_heading = "Repetitions")]
pub struct Learning {
    /// How often the reference is tracked
    #[arg(long, default_value_t = 1, value_name = "N", value_parser = clap::value_parser!(u16).range(1..=1000))]
    repeat: u16,
    /// Learn from pass to pass what to give the board beside the reference, and write that
    #[arg(long, value_name = "LEARNT.csv")]
    pub learn: Option<PathBuf>,
    /// Begin with what was learnt before for the same reference
    #[arg(long, value_name = "LEARNT.csv")]
    pub correction: Option<PathBuf>,
}

impl Learning {
    /// How often the reference is tracked.
    ///
    /// # Errors
    /// One pass teaches nothing that another could use.
    pub fn passes(&self) -> Result<u16, Error> {
        match (&self.learn, self.repeat) {
            (Some(_), 1) => Err(Error::Usage(
                "--learn needs --repeat N, at least 2: what one pass teaches the next one uses".to_owned(),
            )),
            (_, repeat) => Ok(repeat),
        }
    }

    /// A lesson on this reference, which begins with what was learnt before. `corner_hz`: up to
    /// where errors are learnt from, Hz.
    ///
    /// # Errors
    /// The file is none, or is for another reference.
    pub fn lesson(
        &self,
        reference: Reference,
        corner_hz: f64,
        range_mm: (f64, f64),
    ) -> Result<Lesson, Error> {
        let correction = match &self.correction {
            Some(file) => read(file, &reference)?,
            None => vec![0.0; reference.ticks()],
        };
        let learner = Learner::from(correction, reference.rate_hz().recip(), corner_hz);
        Ok(Lesson { learner, reference, range_mm, to: self.learn.clone(), has_ended: false })
    }
}

/// Up to where errors may be learnt from that a board makes with this model. Unit: Hz.
///
/// # Errors
/// Nothing is known of the model, or the loop is not stable or not known well enough at any
/// frequency.
pub fn corner_hz(
    file: &Path,
    model: &ModelFile,
    parameters: &BoardParameters,
    mode: Mode,
) -> Result<f64, Error> {
    let refused =
        |why: &str| Error::Usage(format!("{}: nothing can be learnt with it: {why}", file.display()));
    let feedback = match mode {
        Mode::FeedforwardOnly => Feedback::default(),
        _ => tuned::feedback(parameters),
    };
    if mode == Mode::FeedbackOnly {
        return Err(refused("what is learnt is given to the inverse, and feedback alone has none"));
    }
    let corner_hz = tuning::learning_hz(model, &feedback, parameters.period_s.into())
        .map_err(|problem| refused(&problem.to_string()))?;
    if corner_hz == 0.0 {
        return Err(refused(
            "its slopes and times are not known well enough for an error that repeats to shrink at any frequency",
        ));
    }
    Ok(corner_hz)
}

/// A reference that is tracked again and again, and what is learnt of it.
#[derive(Debug)]
pub struct Lesson {
    learner: Learner,
    reference: Reference,
    /// What the model reaches: nothing beyond is asked for to mend an error. Unit: mm.
    range_mm: (f64, f64),
    /// Where what is learnt goes; None where only what was learnt before is played back.
    to: Option<PathBuf>,
    has_ended: bool,
}

impl Lesson {
    /// The reference with what the board is given beside it in the next pass.
    pub fn given(&self) -> Reference {
        self.reference.corrected(self.learner.correction())
    }

    /// Whether the error has grown, and the best pass stays.
    pub fn has_ended(&self) -> bool {
        self.has_ended
    }

    /// Takes a pass, and says what it came to. Nothing is learnt where that is not asked for.
    pub fn take(&mut self, samples: &[Sample]) {
        let errors = errors_mm(samples, &self.reference);
        let next = match &self.to {
            Some(_) => self.learner.learn(&errors),
            None => self.learner.note(&errors),
        };
        let (low, high) = self.range_mm;
        let wanted: Vec<f64> = self.reference.values(times(&self.reference)).collect();
        self.learner
            .limit(|tick, added| added.clamp((low - wanted[tick]).min(0.0), (high - wanted[tick]).max(0.0)));
        self.has_ended = next == Next::Ended;
        if let Some(pass) = self.learner.passes().last() {
            let number = self.learner.passes().len();
            let end = if self.has_ended { "; the error has grown: the best pass stays" } else { "" };
            say!("pass {number:<3} RMSE {:.4} mm, largest {:.3} mm{end}", pass.rmse, pass.largest);
        }
    }

    /// Stages the file of what was learnt.
    ///
    /// # Errors
    /// It cannot be written.
    pub fn stage(&self, outputs: &mut Outputs) -> Result<(), Error> {
        if let Some(file) = &self.to {
            outputs.stage(file, self.to_csv().as_bytes())?;
        }
        Ok(())
    }

    /// After a pass that was broken off: what the passes before it have taught is written. Whoever
    /// calls this has another error to tell, so a file that cannot be written is only said.
    pub fn keep(&self, mut outputs: Outputs) {
        let Some(file) = self.to.as_ref().filter(|_| !self.learner.passes().is_empty()) else { return };
        match self.stage(&mut outputs).and_then(|()| Ok(outputs.commit()?)) {
            Ok(()) => eprintln!(
                "what was learnt in {} whole passes is kept in {}",
                self.learner.passes().len(),
                file.display()
            ),
            Err(problem) => eprintln!("what was learnt is lost: {problem}"),
        }
    }

    /// The passes, for programs.
    pub fn passes_json(&self) -> serde_json::Value {
        let pass = |pass: &Pass| serde_json::json!({ "rmse_mm": pass.rmse, "max_error_mm": pass.largest });
        self.learner.passes().iter().map(pass).collect()
    }

    fn to_csv(&self) -> String {
        let Self { learner, reference, .. } = self;
        let rmse = |pass: Option<&Pass>| pass.map_or(f64::NAN, |pass| pass.rmse);
        let best = learner.passes().iter().min_by(|a, b| a.rmse.total_cmp(&b.rmse));
        let mut text = format!(
            "# learnt by {TOOL} in {} passes: RMSE {:.4} mm at first, {:.4} mm at best\ntime_s,{REFERENCE},{CORRECTION}\n",
            learner.passes().len(),
            rmse(learner.passes().first()),
            rmse(best),
        );
        let values = reference.values(times(reference));
        for ((time_s, value), correction) in times(reference).zip(values).zip(learner.best()) {
            // Writing to a string does not fail.
            let _ = writeln!(text, "{time_s:.6},{value:.6},{correction:.6}");
        }
        text
    }
}

/// The times of a reference's ticks after its first. Unit: s.
fn times(reference: &Reference) -> impl Iterator<Item = f64> {
    let rate_hz = reference.rate_hz();
    (0..reference.ticks()).map(move |tick| tick as f64 / rate_hz)
}

/// The error of a pass at the ticks of its reference. Unit: mm; straight between the samples.
fn errors_mm(samples: &[Sample], reference: &Reference) -> Vec<f64> {
    let Some(first) = samples.first() else { return Vec::new() };
    let begin_s = first.time_s;
    let error = |sample: &Sample| sample.reference_mm - sample.measured.contraction_mm;
    let mut row = 0;
    (0..reference.ticks())
        .map(|tick| {
            let time_s = begin_s + tick as f64 / reference.rate_hz();
            while row + 2 < samples.len() && samples[row + 1].time_s <= time_s {
                row += 1;
            }
            let from = &samples[row];
            let Some(to) = samples.get(row + 1) else { return error(from) };
            let share = ((time_s - from.time_s) / (to.time_s - from.time_s)).clamp(0.0, 1.0);
            error(from) + share * (error(to) - error(from))
        })
        .collect()
}

/// What was learnt for this reference.
fn read(file: &Path, reference: &Reference) -> Result<Vec<f64>, Error> {
    let choice = Choice::default();
    let table = choice.table(file)?;
    let rate_hz = reference.rate_hz();
    let learnt_for = Reference::of(&table, REFERENCE, choice.clone(), rate_hz)?;
    let correction = Reference::of(&table, CORRECTION, choice, rate_hz)?;
    let other = times(reference)
        .zip(reference.values(times(reference)).zip(learnt_for.values(times(reference))))
        .find(|(_, (wanted, learnt))| (wanted - learnt).abs() > SAME_MM);
    if let Some((time_s, (wanted, learnt))) = other {
        return Err(Error::Usage(format!(
            "{}: learnt for another reference: at {time_s:.3} s that had {learnt:.3} mm, this one has {wanted:.3} mm",
            file.display()
        )));
    }
    Ok(correction.values(times(reference)).collect())
}
