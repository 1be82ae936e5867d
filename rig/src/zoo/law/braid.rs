//! Inextensible fibres wound at an angle (Chou and Hannaford 1996), with tapered ends (Tondu and
//! Lopez 2000).

use super::pull::{FULL_BAR, Pull, beyond};
use crate::draw::Draw;

/// Angle of the fibres, taper, and the tube's threshold.
pub(super) struct Braid {
    a: f64,
    b: f64,
    taper: f64,
    threshold_bar: f64,
    width_bar: f64,
    full: f64,
}

impl Braid {
    pub(super) fn drawn(draw: &mut Draw) -> Self {
        let (sin, cos) = draw.uniform(20.0, 27.0).to_radians().sin_cos();
        let (a, b) = (3.0 * cos * cos / (sin * sin), 1.0 / (sin * sin));
        let (threshold_bar, width_bar) = (draw.uniform(0.3, 1.2), draw.uniform(0.4, 1.0));
        let full = beyond(threshold_bar, width_bar, FULL_BAR) * (a - b);
        Self { a, b, taper: draw.uniform(1.0, 1.15), threshold_bar, width_bar, full }
    }
}

impl Pull for Braid {
    fn pull(&self, pressure_bar: f64, ratio: f64) -> f64 {
        // Beyond its turning point the parabola would rise again.
        let length_ratio = (1.0 - self.taper * ratio).max(0.0);
        let reaching_bar = beyond(self.threshold_bar, self.width_bar, pressure_bar);
        reaching_bar * (self.a * length_ratio * length_ratio - self.b) / self.full
    }
}
