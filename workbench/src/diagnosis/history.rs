//! From when on a recording tells what the muscle has been through.
//!
//! What an operator answers depends on what the input did before. A recording that begins at an end of the input's range leaves no
//! doubt: the muscle has come there from rest, or from its whole range, and both are tried. One that begins within the range may be
//! anywhere between the two branches of the loop, until the input has been at both ends: by then it has wiped out whatever came
//! before. What it is scored on until then would teach the model a past that it has not had.
//!
//! # Limits
//! Where that would take more than [`MOST`] of the scored rows, all stay: a doubtful past is worth less than many rows.

use super::Columns;
use crate::numbers::range;

/// So near an end of the range the input is at it, as a share of the range: what lies beyond wipes out next to nothing.
const NEAR: f64 = 0.05;
/// The largest share of the scored rows whose past may be unknown.
const MOST: f64 = 0.25;

impl Columns {
    /// The columns, no row scored whose past is unknown.
    pub fn with_known_past(mut self) -> Self {
        let Some(known) = known_from(&self.input) else { return self };
        let count = |scored: &[bool]| scored.iter().filter(|&&scored| scored).count();
        let (unknown, all) = (count(&self.scored[..known]), count(&self.scored));
        if unknown > 0 && unknown as f64 <= MOST * all as f64 {
            self.scored[..known].fill(false);
            self.past_unknown_until_s = Some(self.time_s[known]);
        }
        self
    }
}

/// The first row whose past is known; None where that of all rows is.
fn known_from(input: &[f64]) -> Option<usize> {
    let (low, high) = range(input);
    let near = NEAR * (high - low);
    let first = |is_there: &dyn Fn(&f64) -> bool| input.iter().position(is_there);
    let (at_low, at_high) = (first(&|&x| x <= low + near)?, first(&|&x| x >= high - near)?);
    (at_low.min(at_high) > 0).then(|| at_low.max(at_high))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A row a second of a triangle between 0 and 10, from a row of it on.
    fn triangle(from: usize, rows: usize) -> Columns {
        let input: Vec<f64> = (from..from + rows).map(|row| (row as f64 % 20.0 - 10.0).abs()).collect();
        Columns {
            time_s: (0..rows).map(|row| row as f64).collect(),
            output: input.clone(),
            scored: vec![true; rows],
            input,
            ..Columns::default()
        }
    }

    #[test]
    fn a_recording_that_begins_at_an_end_is_scored_from_its_first_row_on() {
        for end in [0, 10] {
            let columns = triangle(end, 100).with_known_past();
            assert_eq!(columns.past_unknown_until_s, None);
            assert!(columns.scored.iter().all(|&scored| scored));
        }
    }

    #[test]
    fn one_that_begins_within_the_range_is_scored_once_the_input_has_been_at_both_ends() {
        let columns = triangle(5, 100).with_known_past();
        assert_eq!(columns.past_unknown_until_s, Some(15.0));
        assert_eq!(columns.scored.iter().position(|&scored| scored), Some(15));
    }

    #[test]
    fn rows_that_do_not_count_anyway_take_nothing_away() {
        let mut columns = triangle(5, 100);
        columns.scored[..20].fill(false);
        assert_eq!(columns.with_known_past().past_unknown_until_s, None);
    }

    #[test]
    fn all_rows_stay_where_too_many_would_go() {
        let columns = triangle(5, 40).with_known_past();
        assert_eq!(columns.past_unknown_until_s, None);
        assert!(columns.scored.iter().all(|&scored| scored));
    }
}
