//! Rows in which a muscle was slack: its pressure was so low that it did not pull, so that the
//! torque did not answer to it, as the balance of torques says it does. The joint at its end stop
//! shows alike, and is met where one pressure alone is let down.
//!
//! # How they are recognised
//! Nothing tells beforehand below which pressure a muscle is slack, and a balance that was fitted
//! to such rows bends to them. So the first fit is to the half of the rows whose lower pressure is
//! highest, or to three quarters where the half does not tell a joint. Rows below are predicted,
//! and the fit goes down to the highest band of pressures of which many rows are off by far, for
//! either muscle by itself, and again from there, until it gets no lower. Where it comes to the
//! lowest pressure nothing was slack.
//!
//! # Limits
//! More than half of the rows have to be taut, and some of these under a known torque. Where three
//! quarters of the rows do not tell a joint either, nothing is looked for.

use std::collections::BTreeMap;
use std::iter::repeat_n;
use std::ops::Range;

use recording::joint::columns::JointRecording;

use super::balance::{Rows, averaged, of_torques};
use super::check::check;
use super::unknowns::{LINEAR, shape};
use super::{JointError, SWING_RAD};

/// Half the time that a residual is averaged over: as the speed. Unit: s.
const HALF_S: f64 = 0.1;
/// A row is far off if its averaged residual is larger than this many times the RMS residual of the
/// fitted rows. In sound recordings of the rig's joints the largest is 3.0 to 3.7 times it, once
/// all rows are fitted; in those with slack rows, which are not, 16 to 150 times.
const FAR: f64 = 8.0;
/// Height of a band of pressures. Unit: bar.
const BAND_BAR: f64 = 0.1;
/// A band is slack if at least this share of its rows is far off. A few are in any band that a
/// pressure passes fast, because of inertia.
const MANY: f64 = 0.2;
/// If the RMS residual of a fit is more than this many times the smallest one so far, the fit
/// includes slack rows. With sound rows alone it has been at most 1.2 times.
const WORSE: f64 = 1.5;
/// Most fits. The fit of a sound recording comes down in two to four.
const ROUNDS: usize = 12;
/// What is less apart is one stretch, and what is so near to one is left out with it: pressures may
/// have been let down faster than the model, without inertia, can follow. Unit: s.
const NEAR_S: f64 = 1.0;

/// A stretch of a recording in which a muscle was slack.
#[derive(Clone, Debug, PartialEq)]
pub struct Slack {
    /// Number of the muscle, 0: the one that turns the joint to larger angles.
    pub muscle: usize,
    /// Pressure below which it was slack in this recording. Unit: bar.
    pub below_bar: f64,
    /// Lowest pressure in the stretch. Unit: bar.
    pub lowest_bar: f64,
    /// The rows that are left out for it.
    pub rows: Range<usize>,
}

/// The stretches of a recording that has been checked, those of one muscle behind those of the
/// other.
pub(super) fn find(recording: &JointRecording) -> Result<Vec<Slack>, JointError> {
    let below_bar = pressures_below(recording)?;
    Ok((0..2).flat_map(|muscle| stretches(recording, muscle, below_bar[muscle])).collect())
}

/// The pressure below which each muscle was slack; minus infinity if it never was. Unit: bar.
fn pressures_below(recording: &JointRecording) -> Result<[f64; 2], JointError> {
    let JointRecording { pressures_bar: [a, b], scored, .. } = recording;
    let lower = |row: usize| a[row].min(b[row]);
    let mut sorted: Vec<f64> = (0..scored.len()).filter(|row| scored[*row]).map(lower).collect();
    sorted.sort_by(f64::total_cmp);
    let from = |start: &f64| fitted(recording, [*start; 2]);
    let starts = [sorted[sorted.len() / 2], sorted[sorted.len() / 4]];
    let Some(start) = starts.into_iter().find(|start| check(&from(start)).is_ok()) else {
        return Ok([f64::NEG_INFINITY; 2]);
    };
    let mut below_bar = [start; 2];
    let (mut before_bar, mut best) = (below_bar, f64::INFINITY);
    for _ in 0..ROUNDS {
        let (far, rms) = far_off(&fitted(recording, below_bar))?;
        if rms > WORSE * best {
            return Ok(before_bar);
        }
        best = best.min(rms);
        let next = [0, 1].map(|muscle| {
            let is_lower = |row: &usize| (b[*row] < a[*row]) == (muscle == 1);
            let rows = (0..scored.len()).filter(|row| scored[*row]).filter(is_lower);
            let pressures = rows.map(|row| (recording.pressures_bar[muscle][row], far[row]));
            top_of_many(pressures).min(below_bar[muscle])
        });
        if next == below_bar {
            break;
        }
        (before_bar, below_bar) = (below_bar, next);
    }
    Ok(below_bar)
}

/// The recording with those rows alone to be fitted in which both pressures are not below these
/// (bar).
fn fitted(recording: &JointRecording, below_bar: [f64; 2]) -> JointRecording {
    let [a, b] = &recording.pressures_bar;
    let is_taut = |row: usize| recording.scored[row] && a[row] >= below_bar[0] && b[row] >= below_bar[1];
    JointRecording { scored: (0..a.len()).map(is_taut).collect(), ..recording.clone() }
}

/// Which rows of a recording are off by far from the balance of those that are scored, and the RMS
/// residual of these, N m.
fn far_off(recording: &JointRecording) -> Result<(Vec<bool>, f64), JointError> {
    let fitted = &recording.scored;
    let rows = Rows::of(recording, SWING_RAD)?;
    let found = of_torques(&rows, fitted)?;
    let shape = shape(&found);
    let residual = |(features, torque): ([f64; LINEAR], &f64)| {
        torque + features.iter().zip(&found).map(|(feature, by)| feature * by).sum::<f64>()
    };
    let residuals: Vec<f64> = rows.features(&shape).zip(&rows.torque).map(residual).collect();
    let squares: Vec<f64> = residuals
        .iter()
        .zip(fitted)
        .filter(|(_, fitted)| **fitted)
        .map(|(residual, _)| residual * residual)
        .collect();
    let rms = (squares.iter().sum::<f64>() / squares.len() as f64).sqrt();
    let half = rows_in(recording, HALF_S);
    let is_far =
        |part: Range<usize>| averaged(&residuals[part], half).into_iter().map(|mean| mean.abs() > FAR * rms);
    Ok((recording.parts().flat_map(is_far).collect(), rms))
}

/// The upper end of the highest pressure band in which many rows are far off; minus infinity if
/// there is no such band. Unit: bar.
fn top_of_many(pressures: impl Iterator<Item = (f64, bool)>) -> f64 {
    let mut bands: BTreeMap<i64, (usize, usize)> = BTreeMap::new();
    for (bar, is_far) in pressures {
        let (rows, far) = bands.entry((bar / BAND_BAR).floor() as i64).or_default();
        (*rows, *far) = (*rows + 1, *far + usize::from(is_far));
    }
    let is_slack = |(_, (rows, far)): &(&i64, &(usize, usize))| *far as f64 >= MANY * *rows as f64;
    bands.iter().rev().find(is_slack).map_or(f64::NEG_INFINITY, |(band, _)| (band + 1) as f64 * BAND_BAR)
}

/// The stretches in which a muscle's pressure was below this one.
fn stretches(recording: &JointRecording, muscle: usize, below_bar: f64) -> Vec<Slack> {
    let pressures = &recording.pressures_bar[muscle];
    let near = rows_in(recording, NEAR_S);
    let mut found: Vec<Slack> = Vec::new();
    for part in recording.parts() {
        for row in part.clone().filter(|row| recording.scored[*row] && pressures[*row] < below_bar) {
            let (bar, end) = (pressures[row], (row + near + 1).min(part.end));
            let begin = row.saturating_sub(near).max(part.start);
            match found.last_mut() {
                Some(last) if last.rows.end >= begin && last.rows.start >= part.start => {
                    (last.rows.end, last.lowest_bar) = (end, last.lowest_bar.min(bar));
                }
                _ => found.push(Slack { muscle, below_bar, lowest_bar: bar, rows: begin..end }),
            }
        }
    }
    found
}

/// The recording without the rows of these stretches: they are history only.
pub fn without_slack(recording: &JointRecording, slack: &[Slack]) -> JointRecording {
    let mut taut = recording.clone();
    for Slack { rows, .. } in slack {
        taut.scored.splice(rows.clone(), repeat_n(false, rows.len()));
    }
    taut
}

/// Number of rows in a time (s).
fn rows_in(recording: &JointRecording, s: f64) -> usize {
    let time_s = &recording.time_s;
    (s * (time_s.len() - 1) as f64 / (time_s[time_s.len() - 1] - time_s[0])).round() as usize
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_highest_band_of_which_many_rows_are_off_is_told() {
        let sound = |bar: f64| repeat_n((bar, false), 20);
        let few = [(2.55, true)];
        let rows = || sound(2.55).chain(few).chain(sound(1.31)).chain(sound(0.15));
        assert_eq!(top_of_many(rows()), f64::NEG_INFINITY);
        let slack = repeat_n((1.33, true), 5);
        assert!((top_of_many(rows().chain(slack)) - 1.4).abs() < 1e-12);
    }
}
