//! The best rate-independent hysteresis of an input, by least squares: static curve, and plays of
//! many thresholds whose weights change over the input.

use nalgebra::{DMatrix, DVector};

/// Knots of the static curve over the range of the input.
const KNOTS: usize = 9;

/// Thresholds of the plays over the range of the input.
const THRESHOLDS: [f64; 7] = [0.01, 0.03, 0.06, 0.12, 0.22, 0.38, 0.6];

/// Most rows of a fit: every so many rows are taken.
const MOST_ROWS: usize = 6000;

/// Ridge on the columns of unit mean square.
const RIDGE: f64 = 1e-9;

/// The hysteresis that an input can have.
pub(super) struct Hysteresis {
    columns: DMatrix<f64>,
    stride: usize,
}

impl Hysteresis {
    /// Of an input that moves.
    pub(super) fn of(input: &[f64]) -> Self {
        let (low, high) = input.iter().fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), value| {
            (low.min(*value), high.max(*value))
        });
        let span = (high - low).max(1e-9);
        let stride = input.len().div_ceil(MOST_ROWS).max(1);
        let mut plays = THRESHOLDS.map(|_| 0.0f64);
        let mut rows = Vec::new();
        for (index, value) in input.iter().enumerate() {
            let at = (value - low) / span;
            for (play, threshold) in plays.iter_mut().zip(THRESHOLDS) {
                *play = play.clamp(at - threshold, at + threshold);
            }
            if index % stride == 0 {
                let tent = |knot: usize| (1.0 - (at * (KNOTS - 1) as f64 - knot as f64).abs()).max(0.0);
                rows.extend((0..KNOTS).map(tent));
                rows.extend(
                    plays.iter().flat_map(|play| [at - play, (at - play) * at, (at - play) * play * play]),
                );
            }
        }
        let width = KNOTS + 3 * THRESHOLDS.len();
        Self { columns: DMatrix::from_row_slice(rows.len() / width, width, &rows), stride }
    }

    /// Root mean square of what is left of `values` of all rows.
    pub(super) fn rest(&self, values: &[f64]) -> f64 {
        let values =
            DVector::from_iterator(self.columns.nrows(), values.iter().step_by(self.stride).copied());
        let mut normal = self.columns.tr_mul(&self.columns);
        let ridge = RIDGE * self.columns.nrows() as f64;
        for index in 0..normal.nrows() {
            normal[(index, index)] += ridge;
        }
        let right = self.columns.tr_mul(&values);
        let weights = normal.cholesky().map_or_else(|| DVector::zeros(right.len()), |c| c.solve(&right));
        let rest = &values - &self.columns * weights;
        (rest.norm_squared() / rest.len() as f64).sqrt()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn hysteresis_of_the_input_leaves_nothing_and_a_delay_leaves_something() {
        let input: Vec<f64> = (0..4000).map(|i| 3.0 + 3.0 * (0.01 * f64::from(i)).sin()).collect();
        let hysteresis = Hysteresis::of(&input);
        let mut play = 3.0f64;
        let looped: Vec<f64> = input
            .iter()
            .map(|value| {
                play = play.clamp(value - 0.36, value + 0.36);
                play
            })
            .collect();
        assert!(hysteresis.rest(&looped) < 0.01, "{}", hysteresis.rest(&looped));
        let noise: Vec<f64> = (0..4000).map(|i| f64::from((i * 7919) % 13) - 6.0).collect();
        assert!(hysteresis.rest(&noise) > 3.0);
    }
}
