//! Where a recording is split into a part that a model is identified from and a part that it is
//! tried on, and how several recordings are.
//!
//! The split is by whole cycles: at the turning point, from falling to rising, that is nearest to
//! the middle of the scored rows. What turns back by less than a tenth of the input's span is no
//! cycle. The second part is never looked at before the model of the first stands; only its input
//! has been, as the range of the recording.

use crate::progress::{Tell, within};
use crate::{Options, Problem, identify_several, simulate, work};
use recording::Recording;
use recording::figures::Figures;
use recording::turning::turning_points;

/// The least height of a cycle, as a share of the input's span.
const LEAST_HEIGHT: f64 = 0.1;
/// The least share of the scored rows on either side.
const LEAST_SHARE: f64 = 0.25;

/// How a model of the first part does on the second.
#[derive(Clone, Debug)]
pub struct Later {
    /// The time of the split. Unit: s.
    pub from_s: f64,
    /// Its figures on the second part. Output unit.
    pub figures: Figures,
    /// What it simulates, a value a row. Output unit.
    pub simulated: Vec<f64>,
    /// The scored rows of the second part.
    pub scored: Vec<bool>,
}

/// How a model of the first part does on the second; None where there are no two parts, or the
/// first is too short for the model.
pub fn later_cycles(recording: &Recording, options: &Options, progress: Tell<'_>) -> Option<Later> {
    let Recording { drive, output, .. } = recording;
    let first = split(&drive.input.values, &drive.scored)?;
    let problem = Problem { scored: &part(&drive.scored, first, true), ..recording.into() };
    let fit = crate::identify(&problem, options, progress).ok()?;
    let scored = part(&drive.scored, first, false);
    let figures = Figures::of(&output.values, &fit.simulated, &scored);
    Some(Later { from_s: drive.time_s[first], figures, simulated: fit.simulated, scored })
}

/// What models of the other recordings answer to each of several, one behind the other, output
/// unit; None where the others are too short for the model.
pub fn by_others(all: &[Problem<'_>], options: &Options, progress: Tell<'_>) -> Option<Vec<f64>> {
    let mut simulated = Vec::new();
    for (place, left_out) in all.iter().enumerate() {
        let others: Vec<Problem<'_>> = [&all[..place], &all[place + 1..]].concat();
        let shares = [place, place + 1].map(|done| done as f64 / all.len() as f64);
        let fit = identify_several(&others, options, &within(progress, shares)).ok()?;
        simulated.extend(simulate(&fit.model, left_out.input));
    }
    Some(simulated)
}

/// The share of the work on a model of all recordings, where models of parts follow: of the first
/// cycles of one ([`later_cycles`]), of the others for each of several ([`by_others`]).
pub fn share_before_others(recordings: &[Recording], options: &Options) -> f64 {
    let scored = |recording: &Recording| recording.drive.scored.iter().filter(|&&scored| scored).count();
    let rows: Vec<usize> = recordings.iter().map(scored).collect();
    let all: usize = rows.iter().sum();
    let parts: f64 = match rows[..] {
        [rows] => work(rows / 2, options),
        _ => rows.iter().map(|rows| work(all - rows, options)).sum(),
    };
    work(all, options) / (work(all, options) + parts)
}

/// The recording with its first part scored only; as it is where there are no two parts.
pub fn first_part(recording: &Recording) -> Recording {
    let mut part_of = recording.clone();
    let drive = &mut part_of.drive;
    if let Some(first) = split(&drive.input.values, &drive.scored) {
        drive.scored = part(&drive.scored, first, true);
    }
    part_of
}

/// The scored rows before the row `first`, or those from there on.
fn part(scored: &[bool], first: usize, before: bool) -> Vec<bool> {
    scored.iter().enumerate().map(|(row, &scored)| scored && (row < first) == before).collect()
}

/// The first row of the held-out part; None where no cycle ends between the first and the last
/// quarter of the scored rows.
fn split(input: &[f64], scored: &[bool]) -> Option<usize> {
    let total = scored.iter().filter(|&&scored| scored).count() as f64;
    let mut before = 0.0;
    let shares: Vec<f64> = scored
        .iter()
        .map(|&scored| {
            let share = before / total;
            before += f64::from(u8::from(scored));
            share
        })
        .collect();
    let distance = |row: &usize| (shares[*row] - 0.5).abs();
    let is_inside = |row: &usize| distance(row) <= 0.5 - LEAST_SHARE;
    minima(input).into_iter().filter(is_inside).min_by(|one, other| distance(one).total_cmp(&distance(other)))
}

/// The rows where the input has fallen and will rise, by a cycle's least height each.
fn minima(input: &[f64]) -> Vec<usize> {
    let (low, high) =
        input.iter().fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), &x| (low.min(x), high.max(x)));
    let turns = turning_points(input, LEAST_HEIGHT * (high - low));
    turns.iter().filter(|turn| !turn.is_peak).map(|turn| turn.row).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Triangles of 200 rows.
    fn triangles(count: usize) -> Vec<f64> {
        let triangle = |row: usize| (1.0 - (row as f64 / 100.0 - 1.0).abs()) * 6.0;
        (0..200 * count).map(|row| triangle(row % 200)).collect()
    }

    #[test]
    fn six_triangles_are_split_after_the_third() {
        assert_eq!(split(&triangles(6), &[true; 1200]), Some(600));
    }

    #[test]
    fn rows_that_are_not_scored_do_not_count_for_the_middle() {
        let scored: Vec<bool> = (0..1200).map(|row| row >= 400).collect();
        assert_eq!(split(&triangles(6), &scored), Some(800));
    }

    #[test]
    fn noise_is_no_cycle() {
        let noisy: Vec<f64> =
            triangles(6).iter().enumerate().map(|(row, x)| x + 0.2 * (row as f64 * 2.4).sin()).collect();
        let row = split(&noisy, &[true; 1200]).expect("a cycle ends");
        assert!(row.abs_diff(600) < 8, "{row}");
    }

    #[test]
    fn a_single_cycle_is_not_split() {
        assert_eq!(split(&triangles(1), &[true; 200]), None);
        assert_eq!(split(&[], &[]), None);
    }
}
