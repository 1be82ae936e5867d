//! Which scored rows the compared models are fitted to, and which they are compared on.
//!
//! As a rule the last third: that is prediction. Where the rows before it have not taken the input
//! both ways, as in one rise, a long hold and one fall at the end, or have not been where the rest
//! goes, they cannot teach what the rest asks; and where one of both hardly moves beside the other,
//! as in a rest at the end, that one says next to nothing. Then the recording is held out in
//! stretches all through it.

use super::start::KNOTS;
use crate::Columns;
use recording::numbers::range;

/// The share of the scored rows that teaches, by convention.
const TAUGHT: f64 = 2.0 / 3.0;
/// Stretches of equally many rows, where they are held out all through: the middle one of each three.
const STRETCHES: usize = 30;
/// The share of the input's span that rows have to move through, and of the travel of as many rows of
/// the recording that they have to travel, by convention: a loop over less than half of the span says
/// little about the whole one.
const MOVES: f64 = 0.5;
/// How far the rest may go beyond the inputs of the rows that teach, as a share of the input's span: half
/// the distance between two knots of a piecewise-linear envelope. A choice; no error level is
/// calibrated for it.
const BEYOND: f64 = 0.5 / (KNOTS - 1) as f64;

/// The rows that teach, and those that do not, in order.
#[derive(Clone, Debug, PartialEq)]
pub struct Split {
    /// The compared models are fitted to these.
    pub taught: Vec<usize>,
    /// And compared on these.
    pub untaught: Vec<usize>,
    /// Where the untaught rows begin, if they are all that follows; None where they are stretches
    /// all through. Unit: s.
    pub from_s: Option<f64>,
    /// Whether the rows tell which model predicts: in a hold that goes on, any model does that has
    /// learnt its beginning.
    pub is_test: bool,
}

impl Split {
    /// Of the scored rows of a recording, which are in order.
    pub fn of(columns: &Columns, scored: &[usize]) -> Self {
        let (taught, untaught) = scored.split_at((TAUGHT * scored.len() as f64) as usize);
        let input = |rows: &[usize]| rows.iter().map(|&row| columns.input[row]).collect::<Vec<_>>();
        let span = |rows: &[usize]| {
            let (low, high) = range(&input(rows));
            high - low
        };
        let least = MOVES * span(scored);
        let goes_both_ways = |rows: &[usize]| both_ways(&input(rows)) >= least;
        let (low, high) = range(&input(taught));
        let (lowest, highest) = range(&input(scored));
        let beyond = (low - lowest).max(highest - high);
        let has_been_there = beyond <= BEYOND * (highest - lowest);
        let step = BEYOND * (highest - lowest);
        let travel_of_row = |rows: &[usize]| travel(&input(rows), step) / rows.len().max(1) as f64;
        let usual = MOVES * travel_of_row(scored);
        let both_move = travel_of_row(taught).min(travel_of_row(untaught)) >= usual;
        let at_end = goes_both_ways(taught) && span(untaught) >= least && has_been_there && both_move;
        if at_end || !goes_both_ways(scored) {
            return Self {
                taught: taught.to_vec(),
                untaught: untaught.to_vec(),
                from_s: untaught.first().map(|&row| columns.time_s[row]),
                is_test: at_end,
            };
        }
        let is_held_out = |place: usize| (STRETCHES * place / scored.len()) % 3 == 1;
        let of = |held_out: bool| {
            let places = scored.iter().enumerate().filter(|(place, _)| is_held_out(*place) == held_out);
            places.map(|(_, &row)| row).collect()
        };
        Self { taught: of(false), untaught: of(true), from_s: None, is_test: true }
    }

    /// Whether a row teaches.
    pub fn teaches(&self, row: usize) -> bool {
        self.taught.binary_search(&row).is_ok()
    }
}

/// The smaller one of the largest rise and the largest fall between any two of these, in order.
fn both_ways(values: &[f64]) -> f64 {
    let (mut low, mut high) = (f64::INFINITY, f64::NEG_INFINITY);
    let (mut rise, mut fall) = (0.0_f64, 0.0_f64);
    for &value in values {
        (low, high) = (low.min(value), high.max(value));
        (rise, fall) = (rise.max(value - low), fall.max(high - value));
    }
    rise.min(fall)
}

/// The way that a signal goes, in steps of at least so much: less is its noise.
fn travel(values: &[f64], step: f64) -> f64 {
    let mut at = values.first().copied().unwrap_or(0.0);
    let mut way = 0.0;
    for &value in values {
        if (value - at).abs() > step {
            way += (value - at).abs();
            at = value;
        }
    }
    way
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The split of an input, a row a second.
    fn split(input: impl Fn(f64) -> f64) -> Split {
        let time_s: Vec<f64> = (0..900).map(f64::from).collect();
        let input = time_s.iter().map(|&t| input(t)).collect();
        let columns = Columns { time_s, input, ..Columns::default() };
        Split::of(&columns, &(0..900).collect::<Vec<_>>())
    }

    #[test]
    fn of_cycles_the_last_third_is_held_out() {
        let cycles = split(|t| (0.05 * t).sin());
        assert_eq!((cycles.taught.len(), cycles.untaught[0]), (600, 600));
        assert_eq!((cycles.from_s, cycles.is_test), (Some(600.0), true));
    }

    #[test]
    fn of_one_rise_and_one_fall_stretches_all_through_are_held_out() {
        let hold = split(|t| t.min(20.0).min((860.0 - t).max(0.0)));
        assert_eq!((hold.taught.len(), hold.untaught.len(), hold.from_s), (600, 300, None));
        assert_eq!(hold.untaught[..2], [30, 31]);
        assert!(hold.is_test && hold.teaches(870) && !hold.teaches(850));
    }

    #[test]
    fn where_the_rest_goes_beyond_the_rows_that_teach_stretches_all_through_are_held_out() {
        let within = split(|t| if t < 600.0 { 0.97 * (0.05 * t).sin() } else { (0.05 * t).sin() });
        assert_eq!(within.from_s, Some(600.0));
        let beyond = split(|t| if t < 600.0 { 0.8 * (0.05 * t).sin() } else { (0.05 * t).sin() });
        assert_eq!((beyond.from_s, beyond.is_test), (None, true));
    }

    #[test]
    fn where_the_recording_rests_at_the_end_stretches_all_through_are_held_out() {
        // The last third swings once, and rests.
        let rests =
            split(|t| if t < 700.0 { (0.05 * t).sin() } else { (0.05_f64 * 700.0).sin() + 1e-3 * t.sin() });
        assert_eq!((rests.from_s, rests.is_test), (None, true));
        let slower = split(|t| if t < 600.0 { (0.05 * t).sin() } else { (0.03 * t).sin() });
        assert_eq!(slower.from_s, Some(600.0));
    }

    #[test]
    fn a_rise_alone_tells_no_models_apart() {
        let rise = split(|t| t.min(20.0));
        assert_eq!((rise.from_s, rise.is_test), (Some(600.0), false));
    }
}
