//! A contractile force beside a spring that stiffens with pressure (Reynolds et al. 2003).

use super::pull::{FULL_BAR, Pull, beyond};
use crate::draw::Draw;

/// Stiffness without pressure and its growth, and the tube's threshold.
pub(super) struct Stiffening {
    slack: f64,
    growth: f64,
    threshold_bar: f64,
    width_bar: f64,
}

impl Stiffening {
    pub(super) fn drawn(draw: &mut Draw) -> Self {
        Self {
            slack: draw.uniform(0.6, 1.4),
            growth: draw.uniform(2.6, 3.6),
            threshold_bar: draw.uniform(0.2, 0.9),
            width_bar: draw.uniform(0.5, 1.2),
        }
    }
}

impl Pull for Stiffening {
    fn pull(&self, pressure_bar: f64, ratio: f64) -> f64 {
        let share = |bar| beyond(self.threshold_bar, self.width_bar, bar);
        let effective = share(pressure_bar) / share(FULL_BAR);
        effective - (self.slack + self.growth * effective) * ratio
    }
}
