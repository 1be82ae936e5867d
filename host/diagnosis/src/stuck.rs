//! A reading of the contraction that stands still while the muscle goes on: a sensor, or what logs it, that hangs.
//!
//! Visits to the same state do not show it, since most of them are sound. But a sensor that has noise does not read the same value many
//! times in a row, least of all where the input makes a model move.

use super::signals::Signals;
use recording::numbers::range;

/// Rows of the same reading in a row that are one that hangs.
const ROWS: usize = 10;
/// By so many times the least error a model moves meanwhile.
const MOVES: f64 = 5.0;
/// So large a share of all rows hangs.
const SHARE: f64 = 2e-3;

/// Readings that hang.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Stuck {
    /// How many rows.
    pub rows: usize,
    /// The longest time that one value was read. Unit: s.
    pub longest_s: f64,
}

/// Those of a recording, beside a model's residual, a value a scored row; None where there are none, or the readings have no noise that
/// would tell.
pub fn stuck(signals: &Signals, residual: &[f64]) -> Option<Stuck> {
    let floor = &signals.noise_floor;
    if floor.deviation <= floor.quantum {
        return None;
    }
    let (time_s, read) = (&signals.recorded.scored_s, &signals.recorded.scored);
    let model: Vec<f64> =
        read.iter().zip(signals.residual_of_all(residual)).map(|(read, error)| read - error).collect();
    let mut all = Stuck { rows: 0, longest_s: 0.0 };
    let mut first = 0;
    for run in read.chunk_by(|one, other| one == other) {
        let rows = first..first + run.len();
        first = rows.end;
        let (low, high) = range(&model[rows.clone()]);
        if run.len() >= ROWS && high - low > MOVES * signals.least_error {
            all.rows += run.len();
            all.longest_s = all.longest_s.max(time_s[rows.end - 1] - time_s[rows.start]);
        }
    }
    (all.rows as f64 > SHARE * read.len() as f64).then_some(all)
}
