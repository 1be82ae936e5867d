//! The zero of the sensor jumps once.

use super::kind::{About, Fits, Kind, Law, Stage};
use super::needs::{Judge, Judged};
use crate::carrier::Carrier;
use crate::chance::{FOUND, standard_errors};
use crate::effect::{Effect, Form, Parameter};
use crate::extend::jump::Jump;
use crate::fitted::{Doubt, Fitted, Parameters};
use crate::plan::part::Part;
use crate::signals::Signals;
use crate::simulated::Simulated;
use crate::smoothing::end_of_line;
use recording::numbers::root_mean_square;

/// How near the ends of the recording no jump is looked for, as a share of its duration: a jump at the beginning is one with the
/// unknown memory of the muscle. A choice.
const END: f64 = 0.05;
/// Times between these that are tried first: a choice. As many jumps are counted as asked for, since they have little to do with each other.
const TIMES: usize = 40;
/// Beside the most promising time, and beside the one that is it then, so many more on either side, until they are samples: those of
/// a grid that is finer by one more than that.
const BESIDE: i32 = 4;

/// The mean of this time, or at least so many rows, before the jump is compared with the mean behind it: it shows nearly all of a jump and
/// next to nothing of a slow change. Choices; no error level is calibrated for them. Unit: s; rows.
const AT_ONCE_S: f64 = 1.0;
const AT_ONCE_ROWS: usize = 10;
/// The means have to differ by at least this share of the height: half way between a jump (1) and a slow change (0). A choice.
const SUDDEN: f64 = 0.5;

/// The cause.
pub struct ZeroStep;

/// A step at this time, of several so far apart. Unit: s.
fn step(time_s: f64, apart_s: f64) -> Effect {
    Effect::new(Form::Step, [Parameter::new(time_s, time_s, time_s, apart_s)])
}

/// `height`: output unit.
fn named(Jump { time_s, height }: Jump) -> Parameters {
    vec![("height_mm", height), ("time_s", time_s)]
}

/// What the mean changes by from just before a time to just behind it; None where there are no rows on one side. `time_s`, `values`: of
/// rows, in order.
fn change_at(time_s: &[f64], values: &[f64], at_s: f64) -> Option<f64> {
    let behind = time_s.partition_point(|&time_s| time_s < at_s);
    let first =
        time_s.partition_point(|&time_s| time_s < at_s - AT_ONCE_S).min(behind.saturating_sub(AT_ONCE_ROWS));
    let end = time_s
        .partition_point(|&time_s| time_s < at_s + AT_ONCE_S)
        .max(behind + AT_ONCE_ROWS)
        .min(values.len());
    let mean =
        |values: &[f64]| (!values.is_empty()).then(|| values.iter().sum::<f64>() / values.len() as f64);
    Some(mean(&values[behind..end])? - mean(&values[first..behind])?)
}

/// What a series jumps by from one row to the next: the distance there of the straight lines through [`AT_ONCE_ROWS`] before and as many
/// behind. `row`: the first behind.
fn jump_at(values: &[f64], row: usize) -> Option<f64> {
    let near_end = |nearest_first: &mut dyn Iterator<Item = &f64>| {
        let sums = |(sum, moment): (f64, f64), (place, value): (usize, &f64)| {
            (sum + value, moment + place as f64 * value)
        };
        let (sum, moment) = nearest_first.enumerate().fold((0.0, 0.0), sums);
        end_of_line(AT_ONCE_ROWS as f64, sum, moment)
    };
    let before = values.get(row.checked_sub(AT_ONCE_ROWS)?..row)?;
    let behind = values.get(row..row + AT_ONCE_ROWS)?;
    Some(near_end(&mut behind.iter()) - near_end(&mut before.iter().rev()))
}

/// Whether a series with a jump of this height before a row jumps there by more than anywhere else, and than the largest of these would by
/// chance. Straight lines leave out what a model gets wrong of the motion, which comes as quickly as that goes.
fn stands_out(values: &[f64], row: usize, height: f64) -> bool {
    let others: Vec<f64> =
        (0..values.len()).step_by(AT_ONCE_ROWS).filter_map(|other| jump_at(values, other)).collect();
    let by_chance = standard_errors(FOUND, others.len(), 1) * root_mean_square(&others);
    // From one part of an excitation to the next a model gets other things wrong: that is rare, and far larger than the rest.
    let least = others.iter().fold(by_chance, |least, other| least.max(other.abs()));
    jump_at(values, row).is_some_and(|jump| (height + jump).abs() > least)
}

fn jump(fitted: &Fitted<'_>) -> Jump {
    Jump { time_s: fitted.parameter(0), height: fitted.weight(0) }
}

impl Kind for ZeroStep {
    fn about(&self) -> &'static About {
        &About {
            name: "zero_step",
            meaning: "The zero of the sensor jumps once",
            law: Law::Progress,
            stage: Stage::Output,
            fits: Fits::Excited,
            taken_for: &["drift", "warm_up"],
            told_from: &[
                ("drift", "play the same swings again behind the jump: a drift goes on there"),
                ("warm_up", "play the same swings again behind the jump: what settles settles further there"),
            ],
            parts: &[Part::Again],
            note: Some("fasten the sensor before the next recording: this one shows that it has moved"),
            ..About::PLAIN
        }
    }

    fn needs(&self, judge: &Judge<'_>) -> Judged {
        judge.repeats()
    }

    fn hypotheses(&self) -> usize {
        TIMES
    }

    fn starts(&self, signals: &Signals) -> Vec<Effect> {
        let first_s = signals.time_s.first().copied().unwrap_or(0.0) + END * signals.duration_s();
        let apart_s = (1.0 - 2.0 * END) * signals.duration_s() / (TIMES - 1) as f64;
        (0..TIMES).map(|place| step(first_s + place as f64 * apart_s, apart_s)).collect()
    }

    fn nearer(&self, signals: &Signals, start: &Effect) -> Vec<Effect> {
        let Some(time) = start.parameters.first().filter(|time| time.step > signals.step_s) else {
            return Vec::new();
        };
        let apart_s = time.step / f64::from(BESIDE + 1);
        (-BESIDE..=BESIDE).map(|place| step(time.value + f64::from(place) * apart_s, apart_s)).collect()
    }

    fn parameters(&self, fitted: &Fitted<'_>) -> Parameters {
        named(jump(fitted))
    }

    /// What comes slowly is no jump; one that is no larger than what changes as suddenly elsewhere does not show by itself.
    fn doubt(&self, fitted: &Fitted<'_>, _longest_hold_s: f64) -> Option<Doubt> {
        let Jump { time_s: at_s, height } = jump(fitted);
        let (signals, residual) = (fitted.signals, fitted.residual());
        let time_s: Vec<f64> = signals.rows.iter().map(|row| signals.time_s[row.at]).collect();
        let change = height + change_at(&time_s, residual, at_s)?;
        if change * height.signum() < SUDDEN * height.abs() {
            return Some(Doubt::Absent);
        }
        let behind = time_s.partition_point(|&time_s| time_s < at_s);
        (!stands_out(residual, behind, height)).then_some(Doubt::Faint)
    }

    fn jump(&self, carrier: &Carrier<'_>) -> Option<Jump> {
        Some(jump(&carrier.fitted))
    }

    fn written(&self, model: &Simulated<'_>) -> Option<Parameters> {
        model.jump.map(named)
    }
}

#[cfg(test)]
mod tests {
    use super::{change_at, jump_at, stands_out};

    #[test]
    fn a_jump_changes_the_mean_at_once_and_a_slow_change_next_to_nothing() {
        let time_s: Vec<f64> = (0..2000).map(|row| 0.05 * f64::from(row)).collect();
        let of = |change: &dyn Fn(f64) -> f64| -> Vec<f64> {
            time_s.iter().map(|&t| 0.2 * (3.0 * t).sin() + change(t)).collect()
        };
        let jump = change_at(&time_s, &of(&|t| if t < 50.0 { 0.0 } else { 1.0 }), 50.0).expect("rows");
        let slow = change_at(&time_s, &of(&|t| ((t - 40.0) / 20.0).clamp(0.0, 1.0)), 50.0).expect("rows");
        assert!((jump - 1.0).abs() < 0.25 && slow.abs() < 0.3, "{jump} {slow}");
        assert_eq!(change_at(&time_s, &of(&|_| 0.0), 0.0), None);
    }

    #[test]
    fn lines_to_either_side_of_a_jump_are_apart_by_its_height_whatever_their_slope() {
        let values: Vec<f64> =
            (0..40).map(|row| 0.3 * f64::from(row) + if row < 20 { 0.0 } else { 0.5 }).collect();
        let near = |row, expected: f64| (jump_at(&values, row).expect("rows") - 0.3 - expected).abs() < 1e-9;
        assert!(near(20, 0.5) && near(10, 0.0));
        assert_eq!((jump_at(&values, 9), jump_at(&values, 31)), (None, None));
    }

    #[test]
    fn a_small_jump_stands_out_of_a_swing_and_one_no_larger_than_others_does_not() {
        let swing = |row: i32| 0.2 * (0.03 * f64::from(row)).sin();
        let swings: Vec<f64> = (0..5000).map(swing).collect();
        assert!(stands_out(&swings, 2503, 0.1) && stands_out(&swings, 2503, -0.1));
        // A model gets other things wrong from one part of an excitation to the next: some 0.2, every 500 rows.
        let part = |row: i32| 0.1 * (0.7 * f64::from(row / 500)).sin();
        let of_parts: Vec<f64> = (0..5000).map(|row| swing(row) + part(row)).collect();
        assert!(!stands_out(&of_parts, 2753, 0.05) && stands_out(&of_parts, 2753, 0.4));
    }
}
