//! Which way an input goes.

use crate::turning::turning_points;

/// What turns back by less than this share of the input's span is noise.
const LEAST_HEIGHT: f64 = 0.02;

/// Whether the input rises at each row: from a turning point on, seen afterwards, so that noise
/// does not count.
///
/// ```
/// assert_eq!(recording::direction::rising(&[0.0, 1.0, 2.0, 1.0, 0.0]), [true, true, true, false, false]);
/// ```
pub fn rising(input: &[f64]) -> Vec<bool> {
    let (low, high) =
        input.iter().fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), &x| (low.min(x), high.max(x)));
    let turns = turning_points(input, LEAST_HEIGHT * (high - low));
    let mut rising = vec![true; input.len()];
    for turn in turns {
        // The first row belongs to the way that it begins.
        let from = if turn.row == 0 { 0 } else { turn.row + 1 };
        rising[from..].fill(!turn.is_peak);
    }
    rising
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_turning_point_ends_a_way_and_noise_does_not() {
        let input = [0.0, 1.0, 0.99, 2.0, 5.0, 4.0, 4.01, 3.0, 6.0];
        assert_eq!(rising(&input), [true, true, true, true, true, false, false, false, true]);
    }

    #[test]
    fn a_way_may_begin_by_falling_and_an_input_may_be_empty() {
        assert_eq!(rising(&[3.0, 2.9, 1.0]), [false; 3]);
        assert_eq!(rising(&[]), [] as [bool; 0]);
    }
}
