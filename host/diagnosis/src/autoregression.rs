//! An autoregression: a model of a stationary, autocorrelated error. It is fitted to one series, and draws others like it.

use rand::{Rng, RngExt};
use rand_distr::StandardNormal;

/// The highest order that is tried; Akaike's criterion chooses. Unit: value.
const HIGHEST_ORDER: usize = 24;
/// A drawn series begins at 0, and is not yet stationary: so many times the order of its first values are left out.
const RUN_IN: usize = 50;

/// Weights of the values before, and the size of the innovation.
#[derive(Clone, Debug)]
pub struct Autoregression {
    /// Weights of the values before, the nearest first.
    weights: Vec<f64>,
    /// Standard deviation of the innovation.
    innovation: f64,
}

impl Autoregression {
    /// Of the order with the least criterion of Akaike (A new look at the statistical model identification, 1974), by the recursion of Levinson and
    /// Durbin on the autocovariances of `values`, which keeps it stationary.
    pub fn of(values: &[f64]) -> Self {
        let count = values.len() as f64;
        let covariances: Vec<f64> = (0..=HIGHEST_ORDER.min(values.len() / 4))
            .map(|lag| values.iter().zip(&values[lag..]).map(|(a, b)| a * b).sum::<f64>() / count)
            .collect();
        let (mut weights, mut variance) = (Vec::new(), covariances[0]);
        let mut best = (Self { weights: Vec::new(), innovation: variance.sqrt() }, f64::INFINITY);
        for order in 0..covariances.len() {
            if order > 0 && variance > 0.0 {
                let told: f64 =
                    weights.iter().zip(covariances[1..order].iter().rev()).map(|(a, b)| a * b).sum();
                let last = (covariances[order] - told) / variance;
                let before: Vec<f64> = weights.iter().rev().map(|weight| last * weight).collect();
                weights.iter_mut().zip(before).for_each(|(weight, change)| *weight -= change);
                weights.push(last);
                variance *= 1.0 - last * last;
            }
            let criterion = count * variance.max(f64::MIN_POSITIVE).ln() + 2.0 * order as f64;
            if criterion < best.1 {
                best = (Self { weights: weights.clone(), innovation: variance.max(0.0).sqrt() }, criterion);
            }
        }
        best.0
    }

    /// So many values of an error like it.
    pub fn draw(&self, count: usize, random: &mut impl Rng) -> Vec<f64> {
        let run_in = RUN_IN * self.weights.len();
        let mut values: Vec<f64> = Vec::with_capacity(run_in + count);
        for _ in 0..run_in + count {
            let told: f64 = self.weights.iter().zip(values.iter().rev()).map(|(a, b)| a * b).sum();
            values.push(told + self.innovation * random.sample::<f64, _>(StandardNormal));
        }
        values.split_off(run_in)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use rand::SeedableRng;
    use rand_chacha::ChaCha8Rng;

    #[test]
    fn a_drawn_error_has_the_autocorrelation_of_the_fitted_one() {
        let mut random = ChaCha8Rng::seed_from_u64(5);
        let truth = Autoregression { weights: vec![1.2, -0.5], innovation: 0.3 };
        let fitted = Autoregression::of(&truth.draw(20_000, &mut random));
        let near = |one: f64, other: f64| assert!((one - other).abs() < 0.03, "{fitted:?}");
        near(fitted.weights[0], 1.2);
        near(fitted.weights[1], -0.5);
        near(fitted.innovation, 0.3);
        let again = Autoregression::of(&fitted.draw(20_000, &mut random));
        near(again.weights[0], 1.2);
    }

    #[test]
    fn an_error_of_zeros_draws_zeros() {
        let mut random = ChaCha8Rng::seed_from_u64(5);
        assert_eq!(Autoregression::of(&[0.0; 100]).draw(3, &mut random), [0.0; 3]);
    }
}
