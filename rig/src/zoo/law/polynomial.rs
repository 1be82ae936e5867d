//! Pressure times a cubic of the contraction, less a membrane's cubic (Hildebrandt et al. 2005).

use super::pull::{FULL_BAR, Pull};
use crate::draw::Draw;

/// Coefficients of the gas part and of the membrane.
pub(super) struct Polynomial {
    gas: [f64; 3],
    membrane: [f64; 2],
}

impl Polynomial {
    pub(super) fn drawn(draw: &mut Draw) -> Self {
        Self {
            gas: [-5.2, 6.0, -8.0].map(|nominal| nominal * draw.uniform(0.95, 1.05)),
            membrane: [0.25, 4.0].map(|nominal| nominal * draw.uniform(0.6, 1.5)),
        }
    }
}

impl Pull for Polynomial {
    fn pull(&self, pressure_bar: f64, ratio: f64) -> f64 {
        let ([c1, c2, c3], [m1, m3]) = (self.gas, self.membrane);
        let gas = 1.0 + ratio * (c1 + ratio * (c2 + ratio * c3));
        pressure_bar / FULL_BAR * gas - ratio * (m1 + m3 * ratio * ratio)
    }
}
