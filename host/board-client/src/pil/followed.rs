//! Whether a muscle has followed its reference; where it has not, what the run shows of why.

use serde_json::Value;

use super::lock_step::{Run, Sample};
use super::results::figures;
use recording::numbers::{range, root_mean_square};

/// A run has followed its reference up to an RMSE of this share of the reference's range: as much
/// as a model may be off that drives a valve ([`recording::worth::DEPLOYABLE`]). The same share of
/// a signal's range counts as much in the reasons below.
const MUCH: f64 = recording::worth::DEPLOYABLE;

/// What is said of a run that has not followed its reference; `limits` are the lowest and the
/// highest command in bar. None of one that has, or whose reference does not move.
pub fn complaint(run: &Run, limits: (f32, f32)) -> Option<String> {
    let of = |value: fn(&Sample) -> f64| -> Vec<f64> { run.samples.iter().map(value).collect() };
    let span = |value: fn(&Sample) -> f64| {
        let (lowest, highest) = range(&of(value));
        highest - lowest
    };
    let rms = |value: fn(&Sample) -> f64| root_mean_square(&of(value));
    let (rmse_mm, reference_mm) = (figures(run).rmse, span(|sample| sample.reference_mm));
    if run.samples.is_empty() || rmse_mm <= MUCH * reference_mm || reference_mm == 0.0 {
        return None;
    }
    let mut reasons = Vec::new();
    let (lowest, highest) = (f64::from(limits.0), f64::from(limits.1));
    // A code of the valve is far below a hundredth of its range.
    let near = 0.01 * (highest - lowest);
    for (limit, name, is_there) in [
        (highest, "upper", &(|bar| bar >= highest - near) as &dyn Fn(f64) -> bool),
        (lowest, "lower", &|bar| bar <= lowest + near),
    ] {
        let share = of(|sample| sample.command_bar.into()).into_iter().filter(|bar| is_there(*bar)).count()
            as f64
            / run.samples.len() as f64;
        if share > MUCH {
            reasons.push(format!(
                "The command was at its {name} limit, {limit} bar, for {:.0} % of the time: is the reference within reach?",
                100.0 * share
            ));
        }
    }
    let moved_mm = span(|sample| sample.measured.contraction_mm);
    if moved_mm < MUCH * reference_mm {
        reasons.push(format!(
            "The contraction moved by {moved_mm:.2} mm only: is the sensor connected, the muscle fixed at both ends?"
        ));
    }
    let command_bar = span(|sample| sample.command_bar.into());
    let lack_bar = rms(|sample| f64::from(sample.command_bar) - sample.measured.pressure_bar);
    if command_bar > 0.0 && lack_bar > MUCH * command_bar {
        reasons.push(format!(
            "The pressure was {lack_bar:.2} bar (RMS) off the command: supply, leaks, or a reference faster than the valve?"
        ));
    }
    let feedforward_bar = span(|sample| sample.feedforward_bar.into());
    let feedback_bar = rms(|sample| sample.feedback_bar.into());
    if feedforward_bar > 0.0 && feedback_bar > MUCH * feedforward_bar {
        reasons.push(format!(
            "The feedback put {feedback_bar:.2} bar (RMS) on the feed-forward: is the model that of this muscle?"
        ));
    }
    if reasons.is_empty() {
        reasons.push(
            "The model, or the gains, may not be those of this muscle: a run with feed-forward only tells which.".to_owned(),
        );
    }
    Some(format!(
        "the muscle did not follow: RMSE {rmse_mm:.2} mm is {:.0} % of the reference's range, {reference_mm:.2} mm. {}",
        100.0 * rmse_mm / reference_mm,
        reasons.join(" ")
    ))
}

/// Says whether a run has followed in its figures for programs, and for people on standard error
/// where it has not.
pub fn tell(name: &str, run: &Run, limits: (f32, f32), json: &mut Value) {
    let complaint = complaint(run, limits);
    if let Some(complaint) = &complaint {
        eprintln!("{name}: {complaint}");
    }
    json[name]["followed"] = complaint.is_none().into();
    json[name]["not_followed_because"] = complaint.into();
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::pil::lock_step::Measurement;
    use model_core::Surroundings;

    /// A run of 200 ticks over a reference from 0 to 60 mm and back, of what `answer` makes of
    /// reference and tick.
    fn run(answer: impl Fn(f64) -> (f64, f64, f64, f64)) -> Run {
        let sample = |tick: u32| {
            let reference_mm = 60.0 * (1.0 - (f64::from(tick) / 100.0 - 1.0).abs());
            let (contraction_mm, pressure_bar, feedforward_bar, feedback_bar) = answer(reference_mm);
            Sample {
                time_s: 1e-3 * f64::from(tick),
                reference_mm,
                measured: Measurement { pressure_bar, contraction_mm, surroundings: Surroundings::default() },
                command_bar: (feedforward_bar + feedback_bar) as f32,
                feedforward_bar: feedforward_bar as f32,
                feedback_bar: feedback_bar as f32,
            }
        };
        Run { samples: (0..200).map(sample).collect(), overruns: 0 }
    }

    fn complaint_of(answer: impl Fn(f64) -> (f64, f64, f64, f64)) -> String {
        complaint(&run(answer), (0.0, 6.0)).unwrap_or_default()
    }

    #[test]
    fn a_muscle_that_follows_is_not_complained_of() {
        assert_eq!(complaint_of(|mm| (mm + 3.0, mm / 20.0, mm / 20.0, 0.0)), "");
    }

    #[test]
    fn a_muscle_that_does_not_follow_is_told_with_what_the_run_shows() {
        let says = |complaint: String, what: &str| assert!(complaint.contains(what), "{complaint}");
        says(
            complaint_of(|mm| (0.5 * mm, mm / 20.0, mm / 20.0, 0.0)),
            "29 % of the reference's range, 60.00 mm",
        );
        says(complaint_of(|_| (0.0, 3.0, 3.0, 0.0)), "The contraction moved by 0.00 mm only");
        says(complaint_of(|mm| (0.5 * mm, 0.0, mm / 20.0, 0.0)), "bar (RMS) off the command");
        says(
            complaint_of(|mm| (0.5 * mm, mm / 10.0, mm / 20.0, mm / 20.0)),
            "is the model that of this muscle?",
        );
        says(complaint_of(|mm| (0.5 * mm, mm.min(6.0), mm.min(6.0), 0.0)), "upper limit, 6 bar, for");
    }
}
