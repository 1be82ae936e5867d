//! An elasto-plastic bristle: a spring in series with friction.
//!
//! The spring holds the contraction to an anchor until its force reaches the limit, then the anchor
//! is dragged along. The limits are given by the caller at every step since they grow with
//! pressure, and may grow with the speed of sliding. Six of these in parallel are the muscle's
//! memory (Maxwell slip; for muscles Vo-Minh et al. 2011).

use crate::dynamics::Limits;

/// A bristle: its stiffness, and the contraction ratio it is anchored at.
#[derive(Debug, Clone)]
pub(crate) struct Bristle {
    stiffness_n: f64,
    anchor_ratio: f64,
}

impl Bristle {
    /// A relaxed bristle at `contraction_ratio`, of a stiffness in N per unit of contraction ratio.
    pub(crate) fn relaxed(stiffness_n: f64, contraction_ratio: f64) -> Self {
        Self { stiffness_n, anchor_ratio: contraction_ratio }
    }

    /// Resistance to contraction in N and its slope in N, if the contraction went to
    /// `contraction_ratio`.
    pub(crate) fn resistance_n(&self, contraction_ratio: f64, limits_n: &Limits) -> (f64, f64) {
        let elastic_n = self.stiffness_n * (contraction_ratio - self.anchor_ratio);
        if elastic_n > limits_n.rising.0 {
            limits_n.rising
        } else if -elastic_n > limits_n.falling.0 {
            (-limits_n.falling.0, limits_n.falling.1)
        } else {
            (elastic_n, self.stiffness_n)
        }
    }

    /// Goes to `contraction_ratio`, dragging the anchor as far as the limits demand.
    pub(crate) fn settle(&mut self, contraction_ratio: f64, limits_n: &Limits) {
        let elastic_n = self.stiffness_n * (contraction_ratio - self.anchor_ratio);
        let (force_n, _) = self.resistance_n(contraction_ratio, limits_n);
        if force_n != elastic_n {
            self.anchor_ratio = contraction_ratio - force_n / self.stiffness_n;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn alike(limit_n: f64) -> Limits {
        Limits { rising: (limit_n, 0.0), falling: (limit_n, 0.0) }
    }

    #[test]
    fn bristle_sticks_below_its_limit_and_is_dragged_above_it() {
        let mut bristle = Bristle::relaxed(100.0, 0.0);
        bristle.settle(0.05, &alike(10.0));
        assert_eq!(bristle.resistance_n(0.0, &alike(10.0)).0, 0.0);
        bristle.settle(0.3, &alike(10.0));
        assert_eq!(bristle.resistance_n(0.3, &alike(20.0)).0, 10.0);
        assert!((bristle.resistance_n(0.15, &alike(20.0)).0 + 5.0).abs() < 1e-12);
    }

    #[test]
    fn falling_limit_makes_a_resting_bristle_slip() {
        let mut bristle = Bristle::relaxed(100.0, 0.0);
        bristle.settle(0.1, &alike(10.0));
        bristle.settle(0.1, &alike(4.0));
        assert!((bristle.resistance_n(0.1, &alike(10.0)).0 - 4.0).abs() < 1e-12);
    }
}
