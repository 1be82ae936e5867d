//! What was learnt over repetitions, in a file: a correction a tick, with the reference that it is
//! for.

use std::fmt::Write as _;
use std::path::{Path, PathBuf};

use clap::Args;
use recording::{Choice, TOOL};
use tuning::learning::{Learner, Next, Pass};

use crate::Error;
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

    /// A learner that begins with what was learnt before, up to a frequency (Hz).
    ///
    /// # Errors
    /// The file is none, or is for another reference.
    pub fn learner(&self, reference: &Reference, corner_hz: f64) -> Result<Learner, Error> {
        let correction = match &self.correction {
            Some(file) => read(file, reference)?,
            None => vec![0.0; reference.ticks()],
        };
        Ok(Learner::from(correction, reference.rate_hz().recip(), corner_hz))
    }
}

/// The error of a pass at the ticks of its reference. Unit: mm; straight between the samples.
pub fn errors_mm(samples: &[Sample], reference: &Reference) -> Vec<f64> {
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

/// Takes a pass, and says what it came to.
pub fn take(learner: &mut Learner, samples: &[Sample], reference: &Reference) -> Next {
    let next = learner.learn(&errors_mm(samples, reference));
    if let Some(pass) = learner.passes().last() {
        let number = learner.passes().len();
        let end = if next == Next::Ended { "; the error has grown: the best pass stays" } else { "" };
        say!("pass {number:<3} RMSE {:.4} mm, largest {:.3} mm{end}", pass.rmse, pass.largest);
    }
    next
}

/// The file of what was learnt.
pub fn to_csv(learner: &Learner, reference: &Reference) -> String {
    let rmse = |pass: Option<&Pass>| pass.map_or(f64::NAN, |pass| pass.rmse);
    let best = learner.passes().iter().min_by(|a, b| a.rmse.total_cmp(&b.rmse));
    let mut text = format!(
        "# learnt by {TOOL} in {} passes: RMSE {:.4} mm before, {:.4} mm at best\ntime_s,{REFERENCE},{CORRECTION}\n",
        learner.passes().len(),
        rmse(learner.passes().first()),
        rmse(best),
    );
    let times = || (0..reference.ticks()).map(|tick| tick as f64 / reference.rate_hz());
    for ((time_s, value), correction) in times().zip(reference.values(times())).zip(learner.best()) {
        // Writing to a string does not fail.
        let _ = writeln!(text, "{time_s:.6},{value:.6},{correction:.6}");
    }
    text
}

/// The passes, for programs.
pub fn passes_json(learner: &Learner) -> serde_json::Value {
    let pass = |pass: &Pass| serde_json::json!({ "rmse_mm": pass.rmse, "max_error_mm": pass.largest });
    learner.passes().iter().map(pass).collect()
}

/// What was learnt for this reference.
fn read(file: &Path, reference: &Reference) -> Result<Vec<f64>, Error> {
    let choice = Choice::default();
    let table = choice.table(file)?;
    let rate_hz = reference.rate_hz();
    let learnt_for = Reference::of(&table, REFERENCE, choice.clone(), rate_hz)?;
    let correction = Reference::of(&table, CORRECTION, choice, rate_hz)?;
    let times = || (0..reference.ticks()).map(|tick| tick as f64 / rate_hz);
    let other = times()
        .zip(reference.values(times()).zip(learnt_for.values(times())))
        .find(|(_, (wanted, learnt))| (wanted - learnt).abs() > SAME_MM);
    if let Some((time_s, (wanted, learnt))) = other {
        return Err(Error::Usage(format!(
            "{}: learnt for another reference: at {time_s:.3} s that had {learnt:.3} mm, this one has {wanted:.3} mm",
            file.display()
        )));
    }
    Ok(correction.values(times()).collect())
}
