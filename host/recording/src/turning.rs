//! Where a signal turns back, and which way it goes.

/// What turns back by less than this share of the input's span is noise.
const LEAST_HEIGHT: f64 = 0.02;

/// A row at which a signal turns.
///
/// ```
/// use recording::turning::{Turn, turning_points};
///
/// // A dip of 0.5 is noise where less than 1 is.
/// let turns = turning_points(&[0.0, 3.0, 2.5, 5.0, 1.0], 1.0);
/// assert_eq!(turns, [Turn { row: 3, is_peak: true }]);
/// ```
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Turn {
    /// The row of the extreme value.
    pub row: usize,
    /// From rising to falling; else the other way.
    pub is_peak: bool,
}

/// The turning points of `values`, peaks and troughs in turn. What turns back by no more than
/// `height` (unit of the values) is no turn.
///
/// A signal that begins to fall has a peak in its first row; the last extreme, from which it has
/// not come back, is not counted.
pub fn turning_points(values: &[f64], height: f64) -> Vec<Turn> {
    let mut turns = Vec::new();
    let (mut row, mut is_rising) = (0, true);
    for (here, &value) in values.iter().enumerate() {
        // How far the signal goes on in its direction.
        let ahead = if is_rising { value - values[row] } else { values[row] - value };
        if ahead > 0.0 {
            row = here;
        } else if ahead < -height {
            turns.push(Turn { row, is_peak: is_rising });
            (row, is_rising) = (here, !is_rising);
        }
    }
    turns
}

/// Whether the input rises at each row: from a turning point on, seen afterwards, so that noise
/// does not count.
///
/// ```
/// assert_eq!(recording::turning::rising(&[0.0, 1.0, 2.0, 1.0, 0.0]), [true, true, true, false, false]);
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
    fn peaks_and_troughs_come_in_turn_and_small_ones_are_passed_over() {
        let turns = turning_points(&[0.0, 3.0, 2.5, 5.0, 5.0, 1.0, 1.4, 0.0, 4.0], 1.0);
        let expected = [Turn { row: 3, is_peak: true }, Turn { row: 7, is_peak: false }];
        assert_eq!(turns, expected);
    }

    #[test]
    fn a_falling_start_is_a_peak_and_a_still_signal_has_none() {
        assert_eq!(turning_points(&[2.0, 1.0, 0.0], 0.5), [Turn { row: 0, is_peak: true }]);
        assert_eq!(turning_points(&[1.0; 5], 0.0), []);
        assert_eq!(turning_points(&[], 0.0), []);
    }

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
