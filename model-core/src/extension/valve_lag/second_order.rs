//! A lag of the second order: p'' = w²(s - p) - 2 d w p', exact for a set point that is held over
//! the step. It is late by 2 d/w on a ramp; from a damping ratio d of 1 on it is two first-order
//! lags one behind the other.
//!
//! It has no inverse of its own: from one sample to the next the set point would have to swing with
//! a size that grows without end. The lead is that of a first-order lag which is as late.

use crate::real::Real;

/// Below this angle the sine is as long as its arc, to the rounding of the numbers.
const SMALL: f64 = 1e-6;

/// What a step of time leaves of a distance, and of a speed.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub(super) struct SecondOrderStep<T> {
    kept: T,
    gone_on: T,
    pulled: T,
    damped: T,
}

impl<T: Real> SecondOrderStep<T> {
    /// By the exponential of the matrix of the two states, in double precision: on the board this
    /// is done once. `late_s`, `dt`: s.
    pub(super) fn new(late_s: T, damping_ratio: T, dt: T) -> Self {
        let (late_s, ratio, dt) = (late_s.to_f64(), damping_ratio.to_f64(), dt.to_f64());
        let frequency = 2.0 * ratio / late_s;
        let decay = ratio * frequency;
        // Half of the difference of the poles, squared: negative where it rings.
        let apart = frequency * frequency * (ratio * ratio - 1.0);
        let turned = libm::sqrt(libm::fabs(apart)) * dt;
        let fade = libm::exp(-decay * dt);
        // Both exponents of an overdamped one are negative: neither overflows.
        let (even, odd) = if turned < SMALL {
            (fade, fade * dt)
        } else if apart < 0.0 {
            (fade * libm::cos(turned), fade * libm::sin(turned) * dt / turned)
        } else {
            let (slow, fast) = (libm::exp(turned - decay * dt), libm::exp(-turned - decay * dt));
            (0.5 * (slow + fast), 0.5 * (slow - fast) * dt / turned)
        };
        Self {
            kept: T::from_f64(even + decay * odd),
            gone_on: T::from_f64(odd),
            pulled: T::from_f64(-frequency * frequency * odd),
            damped: T::from_f64(even - decay * odd),
        }
    }

    /// Pressure and its speed after the step. Units: input unit, input unit/s.
    #[inline(always)]
    pub(super) fn after(&self, (pressure, speed): (T, T), set_point: T) -> (T, T) {
        let distance = pressure - set_point;
        (
            set_point + self.kept * distance + self.gone_on * speed,
            self.pulled * distance + self.damped * speed,
        )
    }
}
