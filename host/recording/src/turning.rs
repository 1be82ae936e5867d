//! Where a signal turns back.

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
}
