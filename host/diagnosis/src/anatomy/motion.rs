//! How input and output move: direction, rate, time since the last change, travel, cycles.
//!
//! # Design
//! What is movement and what is noise is told by a play, as wide as the noise (five standard deviations, and half a
//! percent of the span, to either side): rates and ways are those of the play, so that the noise adds none. Where the play
//! hardly moves, the input is held; how long it has been, the longest stretch back tells in which it stays in a band as
//! high as the play is wide.
//!
//! # Limits
//! A reversal by less than the band is not seen. A ramp of less than three standard
//! deviations of the noise in a tenth of a second (or of 1/500 of the span in a second) counts as a hold.

use std::collections::VecDeque;

use super::Residual;
use recording::noise::{floor, steps};
use recording::numbers::{self, range};
use recording::turning::turning_points;

/// Half the width of the play: so many standard deviations of the noise, and that share of the span.
const BAND_DEVIATIONS: f64 = 5.0;
const BAND_SHARE: f64 = 0.005;
/// The rate is measured over so long, or so many rows, to either side. Unit: s.
const RATE_S: f64 = 0.05;
const RATE_ROWS: usize = 2;
/// The input is held where the play moves by no more than that many standard deviations of the noise over the rate's rows,
/// or by no more than that share of the span a second. Unit of the latter: 1/s.
const HELD_DEVIATIONS: f64 = 3.0;
const HELD_SPAN: f64 = 0.002;
/// The least height of a swing, as a share of the span.
pub const LEAST_SWING: f64 = 0.05;

/// The movement of every row.
#[derive(Clone, Debug)]
pub struct Motion {
    /// 1 where the input rises, -1 where it falls, 0 where it is held.
    pub direction: Vec<f64>,
    /// Of the input. Unit: input unit/s.
    pub rate: Vec<f64>,
    /// Since the input has last changed. Unit: s.
    pub since_change_s: Vec<f64>,
    /// Way of the output since the first row. Unit: output unit.
    pub travel: Vec<f64>,
    /// Number of the cycle, from 1; a cycle begins at a trough of the input.
    pub cycle: Vec<f64>,
    /// Rows of the first row, the turning points and the last row of the input.
    pub ends: Vec<usize>,
}

impl Motion {
    /// Looks at a recording.
    pub fn of(residual: &Residual<'_>) -> Self {
        let Residual { time_s, input, output, .. } = *residual;
        let (low, high) = range(input);
        let still = Still::of(time_s, input);
        let rate = rate(time_s, &still.values);
        let most = |row: usize| {
            let (from, to) = window(time_s, row);
            (HELD_DEVIATIONS * still.noise / (time_s[to] - time_s[from])).max(HELD_SPAN * (high - low))
        };
        let is_held: Vec<bool> = (0..rate.len()).map(|row| rate[row].abs() <= most(row)).collect();
        let since_s = since_elsewhere(time_s, input, 2.0 * still.band);
        let since_change_s = since_s.iter().zip(&is_held).map(|(s, held)| if *held { *s } else { 0.0 });
        let turns = turning_points(input, LEAST_SWING * (high - low));
        let troughs: Vec<usize> = turns.iter().filter(|turn| !turn.is_peak).map(|turn| turn.row).collect();
        let last = input.len().saturating_sub(1);
        let mut ends: Vec<usize> =
            [0].into_iter().chain(turns.iter().map(|turn| turn.row)).chain([last]).collect();
        ends.dedup();
        Self {
            direction: rate
                .iter()
                .zip(&is_held)
                .map(|(rate, held)| if *held { 0.0 } else { rate.signum() })
                .collect(),
            since_change_s: since_change_s.collect(),
            rate,
            travel: numbers::travel(output, Still::of(time_s, output).band),
            cycle: (0..input.len())
                .map(|row| 1.0 + troughs.partition_point(|&at| at <= row) as f64)
                .collect(),
            ends,
        }
    }
}

/// A signal without its noise.
struct Still {
    values: Vec<f64>,
    /// Half the width of the play. Unit of the signal.
    band: f64,
    /// Standard deviation of the noise. Unit of the signal.
    noise: f64,
}

impl Still {
    fn of(time_s: &[f64], values: &[f64]) -> Self {
        let (low, high) = range(values);
        let noise = floor(time_s, values).deviation;
        let band = (BAND_DEVIATIONS * noise).max(BAND_SHARE * (high - low));
        let mut held = values.first().copied().unwrap_or(0.0);
        let follow = |&value: &f64| {
            held = held.clamp(value - band, value + band);
            held
        };
        Self { values: values.iter().map(follow).collect(), band, noise }
    }
}

/// First and last row that the rate at a row is measured over.
fn window(time_s: &[f64], row: usize) -> (usize, usize) {
    let near = |other: usize| (time_s[other] - time_s[row]).abs() <= RATE_S;
    let last = time_s.len() - 1;
    let (mut from, mut to) = (row.saturating_sub(RATE_ROWS), (row + RATE_ROWS).min(last));
    while from > 0 && near(from - 1) {
        from -= 1;
    }
    while to < last && near(to + 1) {
        to += 1;
    }
    (from, to)
}

/// Differences over the rows around. Unit: signal unit/s.
fn rate(time_s: &[f64], still: &[f64]) -> Vec<f64> {
    let slope = |row: usize| {
        let (from, to) = window(time_s, row);
        (still[to] - still[from]) / (time_s[to] - time_s[from])
    };
    (0..time_s.len()).map(slope).collect()
}

/// For each row, the length of the longest stretch up to it, without a gap, in which the values stay in a band of this
/// height. Unit: s.
pub(super) fn since_elsewhere(time_s: &[f64], values: &[f64], height: f64) -> Vec<f64> {
    // Rows of the stretch that are higher (lower) than all that follow in it.
    let (mut highest, mut lowest) = (VecDeque::new(), VecDeque::new());
    let (_, gap_s) = steps(time_s);
    let mut first = 0;
    let mut since = |row: usize| {
        if row > 0 && time_s[row] - time_s[row - 1] > gap_s {
            highest.clear();
            lowest.clear();
            first = row;
        }
        while highest.back().is_some_and(|&other: &usize| values[other] <= values[row]) {
            highest.pop_back();
        }
        while lowest.back().is_some_and(|&other: &usize| values[other] >= values[row]) {
            lowest.pop_back();
        }
        highest.push_back(row);
        lowest.push_back(row);
        while values[highest[0]] - values[lowest[0]] > height {
            first = highest[0].min(lowest[0]) + 1;
            highest.retain(|&other| other >= first);
            lowest.retain(|&other| other >= first);
        }
        time_s[row] - time_s[first]
    };
    (0..values.len()).map(&mut since).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::synthetic::{Noise, held_triangles, times};

    #[test]
    fn direction_rest_rate_and_cycle_are_those_of_noisy_triangles_with_holds() {
        // Up in 4 s by 1 bar/s, hold 4 s, down, hold, twice; 100 rows a second.
        let time_s = times(3200, 0.01);
        let mut noise = Noise::new(1);
        let input: Vec<f64> = time_s.iter().map(|&t| held_triangles(t, 4.0) + noise.white(0.002)).collect();
        let zero = vec![0.0; 3200];
        let residual = Residual {
            time_s: &time_s,
            residual: &zero,
            input: &input,
            output: &input,
            load: None,
            temperature: None,
        };
        let motion = Motion::of(&residual);
        for (row, direction, rate, cycle) in
            [(200, 1.0, 1.0, 1.0), (700, 0.0, 0.0, 1.0), (1000, -1.0, -1.0, 1.0), (1800, 1.0, 1.0, 2.0)]
        {
            assert_eq!(motion.direction[row], direction, "row {row}");
            assert!((motion.rate[row] - rate).abs() < 0.1, "row {row}: {}", motion.rate[row]);
            assert_eq!(motion.cycle[row], cycle, "row {row}");
        }
        assert!((motion.since_change_s[795] - 3.9).abs() < 0.15, "{}", motion.since_change_s[795]);
        // The play loses its own width at each reversal, and the noise adds none.
        assert!((motion.travel[3199] - 16.0).abs() < 0.3, "{}", motion.travel[3199]);
    }
}
