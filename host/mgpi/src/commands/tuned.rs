//! The feedback that was tuned for a model, for the commands that bring it to a board.

use std::path::Path;

use board_client::bus::settings::GAINS;
use recording::model_file::ModelFile;
use recording::model_file::control::Tuning;
use tuning::judge;
use tuning::margins::Margins;
use tuning::response::{Feedback, Growth};
use wire::BoardParameters;
use wire::registers::Id;

/// Largest sensitivity above which a loop is near the edge: the upper end of what is usual (Åström
/// and Hägglund, Advanced PID Control, 2006, section 4.6). Unit: 1.
const EDGE: f64 = 2.0;

/// Whether a model's file (`file`) has a feedback for a board of this period (s). Says what it
/// promises, or why it is not used.
pub fn is_tuned(file: &Path, model: &ModelFile, period_s: f64) -> bool {
    let Some(tuning) = &model.tuning else { return false };
    let is_for = tuning.is_for(period_s);
    if is_for {
        say!("{}: tuned, {}", file.display(), words(tuning));
    } else {
        eprintln!(
            "warning: {}: tuned for a tick of {} s, and the board's has {period_s} s: the tuning is not used. mgpi tune \
             --rate-hz {} makes one",
            file.display(),
            tuning.period_s,
            (1.0 / period_s).round()
        );
    }
    is_for
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

/// The feedback of a board.
pub fn feedback(parameters: &BoardParameters) -> Feedback {
    let BoardParameters { pid, observer, .. } = parameters;
    Feedback {
        kp: pid.kp.into(),
        ki: pid.ki.into(),
        kd: pid.kd.into(),
        filter_s: pid.derivative_filter_s.into(),
        observer: (observer.slope > 0.0)
            .then(|| Growth { slope: observer.slope.into(), reach: observer.reach.into() }),
    }
}

/// Says how near the edge gains are that options give (`asked`), for the controller that they are
/// in.
pub fn warn(file: &Path, model: &ModelFile, parameters: &BoardParameters, asked: &[(Id, f32)]) {
    if !asked.iter().any(|(id, _)| GAINS.contains(id)) {
        return;
    }
    let Ok(margins) = judge(model, &feedback(parameters), parameters.period_s.into()) else { return };
    let Margins { maximum_sensitivity, gain, phase_deg, is_stable } = margins;
    let words = format!(
        "largest sensitivity {maximum_sensitivity:.2}, gain margin {gain:.1}, phase margin {phase_deg:.0} degrees on the \
         worst slope that model and recording leave open"
    );
    let file = file.display();
    if !is_stable {
        eprintln!(
            "warning: {file}: with these gains the loop may swing: it is not stable everywhere. Where it is worst, the gain \
             is {:.1} times what it may be; mgpi tune finds gains that are safe",
            1.0 / gain
        );
    } else if maximum_sensitivity > EDGE {
        eprintln!(
            "warning: {file}: these gains are near the edge: {words}; at most {EDGE} is usual, 1.0 is no feedback"
        );
    } else {
        say!("{file}: these gains: {words}");
    }
}
