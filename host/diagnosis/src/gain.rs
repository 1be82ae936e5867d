//! What a set of effects gains on blocks of time that it was not fitted to.

use super::signals::Signals;
use recording::numbers::median;

/// Rows with a leverage above so many times the mean are not scored: there a fold's fit extrapolates.
const LEVERAGE: f64 = 4.0;
/// A block counts at most so many times the median one.
const CLIP: f64 = 4.0;

/// Which rows are scored, by their leverage on the baseline, the same for all rivals.
pub fn mask(leverage: &[f64]) -> Vec<bool> {
    leverage.iter().map(|&leverage| leverage <= LEVERAGE).collect()
}

/// Whether the squared error of a rival exceeds that of a set by less than the set's own squared error exceeds the noise's. All are
/// root mean squares of one unit.
pub fn differ_less_than_misfit(set: f64, rival: f64, noise: f64) -> bool {
    rival.powi(2) - set.powi(2) < set.powi(2) - noise.powi(2)
}

/// Held-out error of each block. Output unit.
#[derive(Clone, Debug)]
pub struct Score {
    /// Root mean square of each block that has scored rows.
    pub blocks: Vec<f64>,
}

impl Score {
    /// Of a fit, over the rows of the mask.
    pub fn of(signals: &Signals, unseen: &[f64], mask: &[bool]) -> Self {
        let mut sums = vec![(0.0, 0.0); signals.blocks];
        for ((row, residual), &scored) in signals.rows.iter().zip(unseen).zip(mask) {
            if scored {
                sums[row.block].0 += residual * residual;
                sums[row.block].1 += 1.0;
            }
        }
        let blocks: Vec<f64> =
            sums.iter().filter(|sum| sum.1 > 0.0).map(|(squares, count)| (squares / count).sqrt()).collect();
        let most = CLIP * median(&mut blocks.clone());
        Self { blocks: blocks.iter().map(|&block| block.min(most)).collect() }
    }

    /// Mean over the blocks. Output unit.
    pub fn mean(&self) -> f64 {
        let mean = self.blocks.iter().sum::<f64>() / self.blocks.len().max(1) as f64;
        if mean.is_finite() { mean } else { f64::MAX }
    }

    /// Logarithm of the ratio of this error to a later one: above 0 if that is smaller.
    pub fn gain(&self, after: &Self) -> f64 {
        (self.mean() / after.mean().max(1e-12)).ln()
    }

    /// Standard error of the gain, from the differences of the blocks.
    pub fn gain_error(&self, after: &Self) -> f64 {
        let count = self.blocks.len() as f64;
        let ratio = after.mean() / self.mean();
        let differences: Vec<f64> =
            self.blocks.iter().zip(&after.blocks).map(|(before, after)| ratio * before - after).collect();
        let squares: f64 = differences.iter().map(|d| d * d).sum();
        (squares / (count * (count - 1.0).max(1.0))).sqrt() / after.mean().max(1e-12)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn within_the_misfit_that_is_left_a_simpler_form_is_not_refuted() {
        assert!(differ_less_than_misfit(0.19, 0.21, 0.03));
        assert!(!differ_less_than_misfit(0.19, 0.35, 0.03));
        // Where the set leaves nothing but noise, any difference decides.
        assert!(!differ_less_than_misfit(0.03, 0.031, 0.03));
    }
}
