//! Bouc-Wen of exponent 2 with equal shape parameters: the restoring force nears its limit as a
//! hyperbolic tangent of the travel and unloads along a straight line. Exact for any travel.

use super::resist::Resist;
use crate::draw::Draw;
use crate::dynamics::Limits;

/// Its state as a share of the limit.
pub(super) struct BoucWen {
    /// Contraction ratio over which the force rises to its limit.
    reach: f64,
    growth: f64,
    ratio: f64,
    share: f64,
}

impl BoucWen {
    pub(super) fn drawn(draw: &mut Draw, ratio: f64) -> Self {
        Self { reach: draw.log_uniform(0.006, 0.03), growth: draw.uniform(0.2, 0.6), ratio, share: 0.0 }
    }

    fn share_at(&self, ratio: f64) -> f64 {
        let sign = (ratio - self.ratio).signum();
        let along = sign * self.share + (ratio - self.ratio).abs() / self.reach;
        // Against the movement the force falls linearly; from 0 on it rises as the tangent.
        let from = (sign * self.share).max(0.0);
        let after = if along <= 0.0 {
            along
        } else {
            let travelled = along - from;
            (travelled + from.min(1.0 - 1e-12).atanh()).tanh()
        };
        sign * after
    }
}

impl Resist for BoucWen {
    fn level(&self, pressure_bar: f64) -> f64 {
        1.0 - self.growth * (1.0 - pressure_bar / 6.0)
    }

    fn resistance_n(&self, ratio: f64, limits_n: &Limits) -> f64 {
        let share = self.share_at(ratio);
        if share > 0.0 { share * limits_n.rising.0 } else { share * limits_n.falling.0 }
    }

    fn settle(&mut self, ratio: f64, _limits_n: &Limits) {
        (self.share, self.ratio) = (self.share_at(ratio), ratio);
    }
}
