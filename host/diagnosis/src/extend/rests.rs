//! What the rows of a rest count where there is a mass.
//!
//! Where a muscle comes to rest after a swing hangs on how far it swung, by way of the hysteresis: all rows of the rest err by the same,
//! and say it once. Were each to count as much as one of the swing, a few rests would decide what the mass is, and their errors are
//! those of the operator as well.

use model_core::ExtensionParameters;

use crate::Columns;
use recording::numbers::range;

/// A muscle rests while it stays within this share of its stroke.
const MOVES: f64 = 0.004;
/// A rest counts as much as one and a half times so long of movement, however long it lasts. Unit: s.
const RESTED_S: f64 = 0.1;

/// The square roots of what scored rows count, one in the mean square; None where there is no mass, and each counts as much.
pub fn weights(
    columns: &Columns,
    scored: &[usize],
    extensions: &ExtensionParameters<f64>,
) -> Option<Vec<f64>> {
    extensions.inertia.as_ref()?;
    let Columns { time_s, output, .. } = columns;
    let (low, high) = range(output);
    let mut moved = *scored.first()?;
    let counted = scored.iter().map(|&row| {
        if (output[row] - output[moved]).abs() > MOVES * (high - low) {
            moved = row;
        }
        (1.0 + ((time_s[row] - time_s[moved]) / RESTED_S).powi(2)).recip()
    });
    let counted: Vec<f64> = counted.collect();
    let mean = counted.iter().sum::<f64>() / counted.len() as f64;
    Some(counted.iter().map(|counted| (counted / mean).sqrt()).collect())
}

#[cfg(test)]
mod tests {
    use model_core::extension::ProfileParameters;

    use super::*;

    #[test]
    fn a_long_rest_counts_little_more_than_a_short_one_and_movement_counts_whole() {
        // A climb of 10 s, a rest of 10 s.
        let time_s: Vec<f64> = (0..2000).map(|row| f64::from(row) * 0.01).collect();
        let output: Vec<f64> = time_s.iter().map(|t| 10.0 * t.min(10.0)).collect();
        let columns = Columns { time_s, output, ..Columns::default() };
        let scored: Vec<usize> = (0..2000).collect();
        let mass = ExtensionParameters {
            inertia: Some(ProfileParameters::constant(1e-3)),
            ..ExtensionParameters::default()
        };
        let weights = weights(&columns, &scored, &mass).expect("there is a mass");
        let count =
            |rows: std::ops::Range<usize>| weights[rows].iter().map(|weight| weight * weight).sum::<f64>();
        assert!((count(0..2000) - 2000.0).abs() < 1e-6);
        let second = count(0..1000) / 10.0;
        assert!((0.1..0.2).contains(&(count(1000..2000) / second)), "{}", count(1000..2000) / second);
        assert!(count(1200..2000) < 0.05 * count(1000..1200));
    }

    #[test]
    fn without_a_mass_all_rows_count_alike() {
        let columns = Columns { time_s: vec![0.0, 1.0], output: vec![0.0, 1.0], ..Columns::default() };
        assert_eq!(weights(&columns, &[0, 1], &ExtensionParameters::default()), None);
    }
}
