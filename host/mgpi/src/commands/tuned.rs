//! The feedback of a model on a board, for the commands that configure one: what its file has, or
//! what is tuned for it now; and whether gains that a user gives are safe.

use std::path::Path;

use board_client::bus::settings::GAINS;
use recording::model_file::ModelFile;
use recording::model_file::control::Tuning;
use tuning::response::Feedback;
use tuning::{SENSITIVITY, judge, tune};
use wire::BoardParameters;
use wire::registers::Id;

use crate::Error;

/// A tuning is for another period where that differs by more than this share.
const SAME_PERIOD: f64 = 0.01;
/// Above this largest sensitivity a loop is near the edge: a tenth beyond what a tuning may have. A
/// gain that is 1.8 times as large makes it swing. Unit: 1.
const EDGE: f64 = 2.2;

/// The feedback for a model from `file`, in a board's units, at a period (s). Where none is safe,
/// none at all, if a user gives (`asked`) gains.
///
/// # Errors
/// None is safe, and no gain is given.
pub fn feedback(file: &Path, model: &ModelFile, period_s: f64, asked: &[(Id, f32)]) -> Result<Tuning, Error> {
    if let Some(tuning) = &model.tuning
        && (tuning.period_s / period_s - 1.0).abs() < SAME_PERIOD
    {
        say!("{}: feedback as it was tuned, {}", file.display(), words(tuning));
        return Ok(tuning.clone());
    }
    match tune(model, period_s) {
        Ok(tuned) => {
            say!("{}: feedback tuned for it, {}", file.display(), words(&tuned.tuning));
            tuned.assumptions.iter().for_each(|assumed| say!("{}: {assumed}", file.display()));
            Ok(tuned.tuning)
        }
        Err(why) if gives_gains(asked) => {
            eprintln!("warning: {}: nothing is known of these gains: {why}", file.display());
            Ok(Tuning::off(period_s))
        }
        Err(why) => Err(Error::Usage(format!(
            "{}: no feedback is tuned for it: {why}\n  --kp, --ki or --observer-per-s give gains that nobody has \
             checked",
            file.display()
        ))),
    }
}

/// What a tuning promises, in a line.
pub fn words(tuning: &Tuning) -> String {
    let Tuning { maximum_sensitivity, gain_margin, phase_margin_deg, bandwidth_hz: (least, most), .. } =
        tuning;
    format!(
        "largest sensitivity {maximum_sensitivity:.2}, gain margin {gain_margin:.1}, phase margin {phase_margin_deg:.0} \
         degrees on every slope, bandwidth {least:.2} to {most:.2} Hz, limited by {}",
        tuning.limited_by
    )
}

fn gives_gains(asked: &[(Id, f32)]) -> bool {
    asked.iter().any(|(id, _)| GAINS.contains(id))
}

/// Warns of gains that are near the edge or beyond it.
pub fn warn(file: &Path, model: &ModelFile, parameters: &BoardParameters, asked: &[(Id, f32)]) {
    if !gives_gains(asked) {
        return;
    }
    let (pid, rate_per_s) = (&parameters.pid, f64::from(parameters.observer.rate_per_s));
    let feedback = Feedback {
        kp: pid.kp.into(),
        // With an observer, that is in the integral's place.
        ki: if rate_per_s > 0.0 { 0.0 } else { pid.ki.into() },
        kd: pid.kd.into(),
        filter_s: pid.derivative_filter_s.into(),
        rate_per_s,
    };
    let Ok(margins) = judge(model, &feedback, f64::from(parameters.period_s)) else { return };
    let sensitivity = margins.maximum_sensitivity;
    let file = file.display();
    if !margins.is_stable() {
        eprintln!(
            "warning: {file}: with these gains the loop is not stable everywhere: on the worst slope its gain is \
             {:.1} times what it may be. mgpi tune finds gains that are",
            1.0 / margins.gain
        );
    } else if sensitivity > EDGE {
        eprintln!(
            "warning: {file}: these gains are near the edge: largest sensitivity {sensitivity:.1} (a tuning has at most \
             {SENSITIVITY}), gain margin {:.1}, phase margin {:.0} degrees",
            margins.gain, margins.phase_deg
        );
    } else {
        say!(
            "{file}: these gains: largest sensitivity {sensitivity:.2}, gain margin {:.1}, phase margin {:.0} degrees",
            margins.gain,
            margins.phase_deg
        );
    }
}
