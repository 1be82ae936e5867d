//! An autoregression: a stationary error whose neighbouring values are alike, fitted to one and drawn anew.

use rand::{Rng, RngExt};
use rand_distr::StandardNormal;

/// The longest memory, in values.
const MEMORY: usize = 24;
/// So many values for each of the memory are drawn and left out, before which a drawn error still knows that it began at 0.
const BEFORE: usize = 50;

/// What a value is of those before it, and what is new in it.
#[derive(Clone, Debug)]
pub struct Autoregression {
    /// Weights of the values before, the nearest first.
    weights: Vec<f64>,
    /// Standard deviation of what is new.
    new: f64,
}

impl Autoregression {
    /// Of the order that tells most (Akaike, A new look at the statistical model identification, 1974), by the recursion of Levinson and
    /// Durbin on the autocovariances of `values`, which keeps it stationary.
    pub fn of(values: &[f64]) -> Self {
        let count = values.len() as f64;
        let covariances: Vec<f64> = (0..=MEMORY.min(values.len() / 4))
            .map(|lag| values.iter().zip(&values[lag..]).map(|(a, b)| a * b).sum::<f64>() / count)
            .collect();
        let (mut weights, mut variance) = (Vec::new(), covariances[0]);
        let mut best = (Self { weights: Vec::new(), new: variance.sqrt() }, f64::INFINITY);
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
                best = (Self { weights: weights.clone(), new: variance.max(0.0).sqrt() }, criterion);
            }
        }
        best.0
    }

    /// So many values of an error like it.
    pub fn draw(&self, count: usize, random: &mut impl Rng) -> Vec<f64> {
        let before = BEFORE * self.weights.len();
        let mut values: Vec<f64> = Vec::with_capacity(before + count);
        for _ in 0..before + count {
            let told: f64 = self.weights.iter().zip(values.iter().rev()).map(|(a, b)| a * b).sum();
            values.push(told + self.new * random.sample::<f64, _>(StandardNormal));
        }
        values.split_off(before)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use rand::SeedableRng;
    use rand_chacha::ChaCha8Rng;

    #[test]
    fn an_error_that_is_drawn_is_as_alike_as_the_one_that_was_fitted() {
        let mut random = ChaCha8Rng::seed_from_u64(5);
        let truth = Autoregression { weights: vec![1.2, -0.5], new: 0.3 };
        let fitted = Autoregression::of(&truth.draw(20_000, &mut random));
        let near = |one: f64, other: f64| assert!((one - other).abs() < 0.03, "{fitted:?}");
        near(fitted.weights[0], 1.2);
        near(fitted.weights[1], -0.5);
        near(fitted.new, 0.3);
        let again = Autoregression::of(&fitted.draw(20_000, &mut random));
        near(again.weights[0], 1.2);
    }

    #[test]
    fn nothing_has_no_likeness() {
        let mut random = ChaCha8Rng::seed_from_u64(5);
        assert_eq!(Autoregression::of(&[0.0; 100]).draw(3, &mut random), [0.0; 3]);
    }
}
