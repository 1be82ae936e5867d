//! How alike the residuals of neighbouring rows are, and how much more estimates scatter for it.
//!
//! # Design
//! The residuals are taken as a stationary process that knows nothing of the model's derivatives, whose autocovariance
//! they show themselves, tapered by Bartlett's kernel (Newey and West 1987). In a few dozen cycles that covers the truth
//! better than sums of residual times derivative over blocks of rows, where large residuals pull the fit to themselves.
//! A long memory is looked at in blocks of rows, so that the work grows with the rows only.
//!
//! Distances are counted in rows that count: other rows between them are passed over.

use nalgebra::{DMatrix, DVector};

/// The most lags that are looked at; a longer memory is seen in blocks of rows.
const LAGS: usize = 32;

/// Over how many rows residuals are alike; 1 if they are white.
///
/// Twice the length of least mean squared error (Andrews 1991, eq. (6.2), Bartlett's kernel), since intervals want a
/// longer one (Sun, Phillips and Jin 2008): 2 (1.5 g² n)^⅓, g = Σ 2 k ρₖ / (1 + Σ 2 ρₖ), ρₖ the autocorrelation of the n
/// residuals at lag k. The sums end before the first ρₖ below the two standard errors 2/√n of white residuals.
pub fn memory(residuals: &[f64]) -> usize {
    let (total, by_lag) = sums(residuals);
    let length = 2.0 * (1.5 * (by_lag / total).powi(2) * residuals.len() as f64).cbrt();
    (length.ceil() as usize).clamp(1, residuals.len())
}

/// How many times the variance of a mean of the residuals is that of as many white ones: 1 + Σ 2 ρₖ, as in [`memory`].
pub fn inflation(residuals: &[f64]) -> f64 {
    sums(residuals).0
}

/// 1 + Σ 2 ρₖ and Σ 2 k ρₖ.
fn sums(residuals: &[f64]) -> (f64, f64) {
    let least = 2.0 / (residuals.len() as f64).sqrt();
    let products = |lag: usize| -> f64 { residuals.iter().zip(&residuals[lag..]).map(|(a, b)| a * b).sum() };
    let square = products(0);
    // A quarter of the rows at most: over less, nothing shows how the quarters differ.
    let lags = (1..=residuals.len() / 4).map(|lag| (lag as f64, products(lag) / square));
    lags.take_while(|(_, correlation)| *correlation > least)
        .fold((1.0, 0.0), |(total, by_lag), (lag, correlation)| {
            (total + 2.0 * correlation, by_lag + 2.0 * lag * correlation)
        })
}

/// The covariance of the sum over all rows of derivatives times residuals, for residuals that are alike over `memory`
/// rows. `derivatives` has a column for each row.
pub fn scatter(derivatives: &DMatrix<f64>, residuals: &[f64], memory: usize) -> DMatrix<f64> {
    let block = memory.div_ceil(LAGS);
    let sums: Vec<DVector<f64>> = (0..residuals.len())
        .step_by(block)
        .map(|first| derivatives.columns(first, block.min(residuals.len() - first)).column_sum())
        .collect();
    let sums = DMatrix::from_columns(&sums);
    let means: Vec<f64> =
        residuals.chunks(block).map(|chunk| chunk.iter().sum::<f64>() / chunk.len() as f64).collect();
    let blocks = means.len();
    let covariance =
        |lag: usize| means.iter().zip(&means[lag..]).map(|(a, b)| a * b).sum::<f64>() / blocks as f64;
    let mut scatter = &sums * sums.transpose() * covariance(0);
    for lag in 1..memory.div_ceil(block).min(blocks) {
        let taper = 1.0 - (lag * block) as f64 / memory as f64;
        let products = sums.columns(0, blocks - lag) * sums.columns(lag, blocks - lag).transpose();
        scatter += (&products + products.transpose()) * (taper * covariance(lag));
    }
    scatter
}

/// By how many standard errors a 95 % interval reaches to each side: Student's quantile for so many degrees of freedom
/// (the expansion of Abramowitz and Stegun, 26.7.5), at least 3.
pub fn reach(freedom: f64) -> f64 {
    let (z, freedom) = (1.959_964_f64, freedom.max(3.0));
    let first = (z.powi(3) + z) / 4.0;
    let second = (5.0 * z.powi(5) + 16.0 * z.powi(3) + 3.0 * z) / 96.0;
    let third = (3.0 * z.powi(7) + 19.0 * z.powi(5) + 17.0 * z.powi(3) - 15.0 * z) / 384.0;
    z + first / freedom + second / freedom.powi(2) + third / freedom.powi(3)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn intervals_reach_as_far_as_students_quantile() {
        for (freedom, quantile) in [(3.0, 3.182), (5.0, 2.571), (10.0, 2.228), (30.0, 2.042), (1e9, 1.960)] {
            assert!((reach(freedom) / quantile - 1.0).abs() < 1e-2, "{freedom}: {}", reach(freedom));
        }
    }

    #[test]
    fn of_white_residuals_the_scatter_is_the_textbooks() {
        let residuals: Vec<f64> =
            (0..400_i32).map(|row| if row * row % 7 < 3 { 1.0 } else { -1.0 }).collect();
        let derivatives = DMatrix::from_fn(2, 400, |i, row| (0.1 * (row * (i + 1)) as f64).sin());
        let plain = &derivatives * derivatives.transpose();
        assert!((scatter(&derivatives, &residuals, 1) - plain).amax() < 1e-9);
    }

    #[test]
    fn blocks_of_rows_tell_what_the_rows_do() {
        // A slow wave over many rows, seen in blocks, against the double sum over all pairs of rows.
        let (rows, memory) = (4000, 200);
        let wave = |row: usize, length: f64| (row as f64 / length).sin();
        let residuals: Vec<f64> = (0..rows).map(|row| wave(row, 60.0) + 0.3 * wave(row, 37.0)).collect();
        let derivatives = DMatrix::from_fn(2, rows, |i, row| 1.0 + wave(row, 150.0 * (i + 1) as f64));
        let mut direct = DMatrix::zeros(2, 2);
        for lag in 0..memory {
            let products = residuals.iter().zip(&residuals[lag..]).map(|(a, b)| a * b).sum::<f64>();
            let weight = (1.0 - lag as f64 / memory as f64) * products / rows as f64;
            let pairs = derivatives.columns(0, rows - lag) * derivatives.columns(lag, rows - lag).transpose();
            direct += if lag == 0 { pairs * weight } else { (&pairs + pairs.transpose()) * weight };
        }
        let error = (scatter(&derivatives, &residuals, memory) - &direct).amax() / direct.amax();
        assert!(error < 0.05, "{error}");
    }
}
