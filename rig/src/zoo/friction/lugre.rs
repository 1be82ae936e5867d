//! LuGre (Canudas de Wit et al. 1995): one bristle deflection that nears its limit exponentially,
//! with the slight Stribeck effect of a lubricated guide. Exact for a constant speed over the step.

use super::resist::Resist;
use crate::draw::Draw;
use crate::dynamics::Limits;

/// The deflection as a share of the limit.
pub(super) struct LuGre {
    /// Contraction ratio over which the deflection nears its limit.
    reach: f64,
    /// Share of the friction that goes with speed.
    stribeck: f64,
    ratio: f64,
    share: f64,
}

impl LuGre {
    pub(super) fn drawn(draw: &mut Draw, ratio: f64) -> Self {
        Self { reach: draw.log_uniform(0.004, 0.02), stribeck: draw.uniform(0.0, 0.03), ratio, share: 0.0 }
    }

    fn share_at(&self, ratio: f64) -> f64 {
        let (sign, travel) = ((ratio - self.ratio).signum(), (ratio - self.ratio).abs());
        // Fast is what moves by a hundredth of the reach in a step.
        let limit = 1.0 - self.stribeck * (1.0 - (-(100.0 * travel / self.reach).powi(2)).exp());
        sign * limit + (self.share - sign * limit) * (-travel / self.reach).exp()
    }
}

impl Resist for LuGre {
    fn level(&self, _pressure_bar: f64) -> f64 {
        1.0
    }

    fn resistance_n(&self, ratio: f64, limits_n: &Limits) -> f64 {
        let share = self.share_at(ratio);
        if share > 0.0 { share * limits_n.rising.0 } else { share * limits_n.falling.0 }
    }

    fn settle(&mut self, ratio: f64, _limits_n: &Limits) {
        (self.share, self.ratio) = (self.share_at(ratio), ratio);
    }
}
