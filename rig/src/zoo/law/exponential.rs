//! The empirical formula `(a1 p + a2) exp(a3 e) + a4 p e + a5 p + a6` (Sarosi 2012) near a muscle
//! of 20 mm.

use super::pull::{FULL_BAR, Pull};
use crate::draw::Draw;

/// Its six coefficients, for pressures in bar and contractions in percent.
pub(super) struct Exponential {
    coefficients: [f64; 6],
    full: f64,
}

impl Exponential {
    pub(super) fn drawn(draw: &mut Draw) -> Self {
        let [a1, a2, a3, a4, a5] =
            [-4.356, 281.24, -0.3285, -9.270, 302.21].map(|nominal| nominal * draw.uniform(0.92, 1.08));
        // Without pressure and contraction the muscle does not pull.
        let coefficients = [a1, a2, a3, a4, a5, -a2];
        Self { coefficients, full: FULL_BAR * (a1 + a5) }
    }
}

impl Pull for Exponential {
    fn pull(&self, pressure_bar: f64, ratio: f64) -> f64 {
        let ([a1, a2, a3, a4, a5, a6], percent) = (self.coefficients, 100.0 * ratio);
        let curved = (a1 * pressure_bar + a2) * (a3 * percent).exp();
        (curved + a4 * pressure_bar * percent + a5 * pressure_bar + a6) / self.full
    }
}
