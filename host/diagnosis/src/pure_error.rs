//! Pure error: how much the residual differs between visits to the same state far apart in time.
//!
//! A misfit of shape that repeats itself, however large, cancels in the difference; what a missing cause or a
//! disturbance does is not the same at both visits.

use super::basis::{Basis, Seen};
use super::signals::Signals;
use recording::numbers::{NORMAL_MEDIAN, root_mean_square};

/// Rows that are compared, at most.
const ROWS: usize = 1500;
/// Two visits are at least so far apart, as a share of the record.
const APART: f64 = 0.04;
/// Two states are the same within so much in every direction: of the input's span, of each stop's range.
const SAME: f64 = 0.12;
/// Weight of the input against the stops in that.
const INPUT_WEIGHT: f64 = 8.0;
/// The shares of the pairs that differ by less than what is usual, and than what is rare.
const USUAL: f64 = 0.9;
const RARE: f64 = 0.98;
/// What nine of ten differ by counts as at most so many times what half of them do: sound muscles come to 5, without any noise to 14.
const TIMES: f64 = 8.0;
/// Fewest pairs that say something, and their least share of the rows.
const PAIRS: usize = 60;
const MATCHED: f64 = 0.1;

/// A loss of so small a share of the matched rows is by chance.
const CHANCE: f64 = 0.05;

/// What visits to the same state differ by.
#[derive(Clone, Copy, Debug)]
pub struct PureError {
    /// Mean square. Unit: square of the output unit.
    pub square: f64,
    /// Share of the rows whose state is visited again.
    pub matched: f64,
    /// The standard deviation of the errors that half of the pairs speak of. Where a model's memory is not quite that of the muscle few
    /// visits differ by far more than the others, in the states where it is wrong; what acts all the time is seen in most pairs. Output
    /// unit.
    pub typical: f64,
    /// What nine of ten pairs differ by less than, or eight times what half of them do if that is less. Output unit.
    pub usual: f64,
    /// What all but two of a hundred differ by less than. Output unit.
    pub rare: f64,
}

impl PureError {
    /// The error, root mean square: what is matched less than by `other`, beyond chance, counts with its whole residual. A
    /// set of causes that spreads the states has explained nothing by that. Output unit.
    pub fn beside(&self, other: &Self, residual: &[f64]) -> f64 {
        let lost = ((1.0 - CHANCE) * other.matched - self.matched).max(0.0);
        let whole = root_mean_square(residual).powi(2);
        ((self.matched * self.square + lost * whole) / (self.matched + lost)).sqrt()
    }
}

/// The pure error of a residual, a value a scored row, of what saw this input; None where the recording visits too few
/// states twice.
pub fn pure_error(signals: &Signals, basis: &Basis, seen: &Seen, residual: &[f64]) -> Option<PureError> {
    let states = basis.states(seen, &signals.rows);
    let every = states.len().div_ceil(ROWS).max(1);
    let apart_s = APART * signals.duration_s();
    let time_s = |i: usize| signals.time_s[signals.rows[i].at];
    // By input, so that the states that may be the same stand together.
    let mut by_input: Vec<usize> = (0..states.len()).step_by(every).collect();
    by_input.sort_by(|&i, &j| states[i][0].total_cmp(&states[j][0]));
    let near = |i: usize, j: usize| INPUT_WEIGHT * (states[i][0] - states[j][0]).abs() < SAME;
    let mut differences = Vec::new();
    for (place, &i) in by_input.iter().enumerate() {
        let (before, after) = by_input.split_at(place);
        let before = before.iter().rev().take_while(|&&j| near(i, j));
        // Of several that are as near, as of readings on a grid there are many, the earliest.
        let mut nearest = (SAME, usize::MAX);
        for &j in before.chain(after.iter().take_while(|&&j| near(i, j))) {
            let away = distance(&states[i], &states[j], nearest.0.next_up());
            if (away, j) < nearest && (time_s(j) - time_s(i)).abs() >= apart_s {
                nearest = (away, j);
            }
        }
        if let Some(there) = residual.get(nearest.1) {
            differences.push((residual[i] - there).powi(2));
        }
    }
    let matched = differences.len() as f64 / by_input.len() as f64;
    if differences.len() < PAIRS || matched < MATCHED {
        return None;
    }
    differences.sort_by(f64::total_cmp);
    let at = |share: f64| (0.5 * differences[(share * (differences.len() - 1) as f64) as usize]).sqrt();
    // A few pairs of a coarse match do not count for more than ten times the middle ones.
    let most = 20.0 * differences[differences.len() / 2];
    let mean = differences.iter().map(|&d| d.min(most)).sum::<f64>() / differences.len() as f64;
    let typical = at(0.5) / NORMAL_MEDIAN;
    Some(PureError {
        square: mean / 2.0,
        matched,
        typical,
        usual: at(USUAL).min(TIMES * at(0.5)),
        rare: at(RARE),
    })
}

/// The largest difference; anything above `enough` where it is that.
fn distance<const K: usize>(one: &[f64; K], other: &[f64; K], enough: f64) -> f64 {
    let mut largest = INPUT_WEIGHT * (one[0] - other[0]).abs();
    for (a, b) in one[1..].iter().zip(&other[1..]) {
        if largest >= enough {
            return largest;
        }
        largest = largest.max((a - b).abs());
    }
    largest
}
