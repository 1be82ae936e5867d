//! How alike the residuals of neighbouring rows are, and how much more estimates scatter for it.
//!
//! # Design
//! The residuals are taken as a stationary process that knows nothing of the model's derivatives,
//! whose autocovariance they show themselves, tapered by Bartlett's kernel (Newey and West 1987).
//! In a few dozen cycles that covers the truth better than sums of residual times derivative over
//! blocks of rows, where large residuals pull the fit to themselves. A long memory is looked at in
//! blocks of rows, so that the work grows with the rows only.
//!
//! Distances are counted in rows that count: other rows between them are passed over.

use std::collections::VecDeque;
use std::ops::Range;

use nalgebra::{DMatrix, DVector};
use rustfft::FftPlanner;
use rustfft::num_complex::Complex;

/// The most lags that are looked at; a longer memory is seen in blocks of rows.
const LAGS: usize = 32;

/// Over how many rows residuals are alike; 1 if they are white.
///
/// Twice the length of least mean squared error (Andrews 1991, eq. (6.2), Bartlett's kernel), since
/// intervals want a longer one (Sun, Phillips and Jin 2008): 2 (1.5 g² n)^⅓, g = Σ 2 k ρₖ / (1 + Σ
/// 2 ρₖ), ρₖ the autocorrelation of the n residuals at lag k. The sums end before the first ρₖ
/// below the two standard errors 2/√n of white residuals.
pub fn memory(residuals: &[f64]) -> usize {
    let (total, by_lag) = sums(residuals);
    let length = 2.0 * (1.5 * (by_lag / total).powi(2) * residuals.len() as f64).cbrt();
    (length.ceil() as usize).clamp(1, residuals.len())
}

/// How many times the variance of a mean of the residuals is that of as many white ones: 1 + Σ 2
/// ρₖ, as in [`memory`].
///
/// ```
/// use identification::autocorrelation::inflation;
///
/// let slow: Vec<f64> = (0..1000).map(|k| (0.05 * f64::from(k)).sin()).collect();
/// let alternating: Vec<f64> = (0..1000).map(|k| if k % 2 == 0 { 1.0 } else { -1.0 }).collect();
/// assert!(inflation(&slow) > inflation(&alternating)); // alike residuals tell less
/// ```
pub fn inflation(residuals: &[f64]) -> f64 {
    sums(residuals).0
}

/// 1 + Σ 2 ρₖ and Σ 2 k ρₖ.
fn sums(residuals: &[f64]) -> (f64, f64) {
    let least = 2.0 / (residuals.len() as f64).sqrt();
    let square = residuals.iter().map(|r| r * r).sum::<f64>();
    // A quarter of the rows at most: over less, nothing shows how the quarters differ.
    let end = residuals.len() / 4 + 1;
    let (mut total, mut by_lag) = (1.0, 0.0);
    let mut lags = 1..end.min(1 + LAGS);
    while !lags.is_empty() {
        for (lag, product) in lags.clone().zip(products(residuals, lags.clone())) {
            let correlation = product / square;
            if correlation.is_nan() || correlation <= least {
                return (total, by_lag);
            }
            total += 2.0 * correlation;
            by_lag += 2.0 * lag as f64 * correlation;
        }
        // Wider and wider, so that a long memory costs little more than a short one.
        lags = lags.end..end.min(lags.end + 4 * lags.len());
    }
    (total, by_lag)
}

/// Sums of the products of values at some lags: few by themselves, many by Fourier transforms of as
/// many values at a time.
fn products(values: &[f64], lags: Range<usize>) -> Vec<f64> {
    if lags.len() <= LAGS {
        return lags.map(|lag| values.iter().zip(&values[lag..]).map(|(a, b)| a * b).sum()).collect();
    }
    let block = lags.len().next_power_of_two();
    let mut planner = FftPlanner::new();
    let (forward, inverse) = (planner.plan_fft_forward(2 * block), planner.plan_fft_inverse(2 * block));
    let mut cross = vec![Complex::default(); 2 * block];
    let mut both = cross.clone();
    for first in (0..values.len() - lags.start).step_by(block) {
        // A block as the real part, and all that it is multiplied by as the imaginary one.
        let later = values[first + lags.start..].iter().chain(std::iter::repeat(&0.0));
        let these = values[first..].iter().take(block).chain(std::iter::repeat(&0.0));
        for (value, (re, im)) in both.iter_mut().zip(these.zip(later)) {
            *value = Complex::new(*re, *im);
        }
        forward.process(&mut both);
        for (k, sum) in cross.iter_mut().enumerate() {
            let (value, mirrored) = (both[k], both[(2 * block - k) % (2 * block)].conj());
            *sum += (value + mirrored).conj() * (value - mirrored) * Complex::new(0.0, -0.25);
        }
    }
    inverse.process(&mut cross);
    cross.iter().take(lags.len()).map(|sum| sum.re / (2 * block) as f64).collect()
}

/// The covariance of the sum over all rows of derivatives times residuals that are alike over some
/// rows, taken row by row.
pub struct Scatter {
    /// Rows of a block.
    block: usize,
    /// Of each lag in blocks: the covariance of the residuals' means, tapered.
    covariances: Vec<f64>,
    /// Sums over the last blocks, the latest last, as many as there are lags, and that of the block
    /// that is not full.
    sums: VecDeque<DVector<f64>>,
    /// Rows in that.
    taken: usize,
    sum: DMatrix<f64>,
}

impl Scatter {
    /// For residuals that are alike over `memory` rows, and as many derivatives by `unknowns` each.
    pub fn new(unknowns: usize, residuals: &[f64], memory: usize) -> Self {
        let block = memory.div_ceil(LAGS);
        let means: Vec<f64> =
            residuals.chunks(block).map(|chunk| chunk.iter().sum::<f64>() / chunk.len() as f64).collect();
        let covariance = |lag: usize| {
            let taper = 1.0 - (lag * block) as f64 / memory as f64;
            let products = means.iter().zip(&means[lag..]).map(|(a, b)| a * b);
            taper * products.sum::<f64>() / means.len() as f64
        };
        Self {
            block,
            covariances: (0..memory.div_ceil(block).min(means.len())).map(covariance).collect(),
            sums: VecDeque::from([DVector::zeros(unknowns)]),
            taken: 0,
            sum: DMatrix::zeros(unknowns, unknowns),
        }
    }

    /// Takes the derivatives of the next row.
    pub fn take(&mut self, derivatives: &[f64]) {
        if self.taken == self.block {
            self.close();
        }
        for (sum, derivative) in self.sums.iter_mut().rev().take(1).flatten().zip(derivatives) {
            *sum += derivative;
        }
        self.taken += 1;
    }

    /// Adds what the last block and those before it make.
    fn close(&mut self) {
        let Some(last) = self.sums.back() else { return };
        // Of two blocks either may be the earlier one.
        let mut with_earlier = last * (self.covariances[0] / 2.0);
        for (earlier, covariance) in self.sums.iter().rev().zip(&self.covariances).skip(1) {
            with_earlier.axpy(*covariance, earlier, 1.0);
        }
        self.sum.ger(1.0, last, &with_earlier, 1.0);
        self.sum.ger(1.0, &with_earlier, last, 1.0);
        // The place of a block that no lag reaches any more is used again.
        let mut next = match self.sums.len() < self.covariances.len() {
            true => DVector::zeros(last.len()),
            false => self.sums.pop_front().unwrap_or_default(),
        };
        next.fill(0.0);
        self.sums.push_back(next);
        self.taken = 0;
    }

    /// That covariance.
    pub fn sum(mut self) -> DMatrix<f64> {
        self.close();
        self.sum
    }
}

/// By how many standard errors a 95 % interval reaches to each side: Student's quantile for so many
/// degrees of freedom (the expansion of Abramowitz and Stegun, 26.7.5), at least 3.
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
    fn products_at_many_lags_are_the_sums_that_they_stand_for() {
        let values: Vec<f64> =
            (0..1500).map(|k| (f64::from(k) * 0.37).sin() + f64::from(k * k % 11)).collect();
        let many = products(&values, 40..340);
        for (lag, product) in (40..340).zip(many) {
            let sum: f64 = values.iter().zip(&values[lag..]).map(|(a, b)| a * b).sum();
            assert!((product - sum).abs() < 1e-9 * sum.abs().max(1.0), "{lag}: {product} for {sum}");
        }
    }

    fn scatter(derivatives: &DMatrix<f64>, residuals: &[f64], memory: usize) -> DMatrix<f64> {
        let mut scatter = Scatter::new(derivatives.nrows(), residuals, memory);
        derivatives.column_iter().for_each(|row| scatter.take(row.as_slice()));
        scatter.sum()
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
        // A slow wave over many rows, seen in blocks, against the double sum over all pairs of
        // rows.
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
