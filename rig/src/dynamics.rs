//! Forces of motion: mass, viscosity, and friction that grows with the speed of sliding.
//!
//! A step by Newmark's average acceleration turns mass and viscosity into one more spring, from the
//! ratio the muscle would fly to; so the balance of forces keeps its form and its single root. The
//! friction's limit is `F0 (1 + k s^a)` with the speed s in the direction of sliding, in units of
//! [`RATE_UNIT_MM_PER_S`]; below 1 mm/s the power is rounded off, since its slope at rest would be
//! infinite.

use crate::parameters::NOMINAL_LENGTH_MM;

/// Speed at which a rate-dependent friction has grown by its gain, mm/s: at mid stroke that of 1
/// bar/s.
pub const RATE_UNIT_MM_PER_S: f64 = 20.0;

/// Speed below which the growth of the friction is rounded off, mm/s.
const SLOW_MM_PER_S: f64 = 1.0;

/// Coefficients of the forces of motion. The default is none.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct Dynamics {
    /// Mass, N s² per unit of contraction ratio.
    pub mass_n_s2: f64,
    /// Viscosity, N s per unit of contraction ratio.
    pub viscosity_n_s: f64,
    /// Growth of the friction at [`RATE_UNIT_MM_PER_S`], dimensionless.
    pub width_gain: f64,
    /// Exponent of that growth, dimensionless.
    pub rate_exponent: f64,
}

/// Where the muscle is and how it moves.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Motion {
    /// Contraction ratio.
    pub(crate) ratio: f64,
    speed_per_s: f64,
    acceleration_per_s2: f64,
}

impl Motion {
    /// Rest at a contraction ratio.
    pub(crate) fn resting(ratio: f64) -> Self {
        Self { ratio, speed_per_s: 0.0, acceleration_per_s2: 0.0 }
    }
}

/// The largest forces of a bristle and their slopes by the contraction ratio, all N and 0 or more.
#[derive(Debug, Clone, Copy)]
pub struct Limits {
    /// While it is dragged up.
    pub(crate) rising: (f64, f64),
    /// While it is dragged down.
    pub(crate) falling: (f64, f64),
}

impl Limits {
    /// Those of an element that has a share of the friction.
    pub(crate) fn scaled(&self, share: f64) -> Self {
        let of = |(force_n, slope_n): (f64, f64)| (share * force_n, share * slope_n);
        Self { rising: of(self.rising), falling: of(self.falling) }
    }

    /// The larger force, N.
    pub(crate) fn widest(&self) -> f64 {
        self.rising.0.max(self.falling.0)
    }
}

/// One step of time: what it asks of the balance of forces.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Step {
    from: Motion,
    dynamics: Dynamics,
    dt_s: f64,
    /// Force per unit of contraction ratio beyond [`Self::free_ratio`], N.
    pub(crate) stiffness_n: f64,
    /// Where the muscle would be at the end of the step without any force.
    pub(crate) free_ratio: f64,
}

impl Dynamics {
    /// A step of `dt_s` (above 0 s; infinite for a change without haste).
    pub(crate) fn step(&self, from: &Motion, dt_s: f64) -> Step {
        let Motion { ratio, speed_per_s, acceleration_per_s2 } = *from;
        let (mass_n, viscous_n) = (4.0 * self.mass_n_s2 / (dt_s * dt_s), 2.0 * self.viscosity_n_s / dt_s);
        let stiffness_n = mass_n + viscous_n;
        let free_ratio = if stiffness_n > 0.0 {
            let flown = mass_n * (dt_s * speed_per_s + 0.25 * dt_s * dt_s * acceleration_per_s2)
                + viscous_n * 0.5 * dt_s * speed_per_s;
            ratio + flown / stiffness_n
        } else {
            ratio
        };
        Step { from: *from, dynamics: *self, dt_s, stiffness_n, free_ratio }
    }
}

impl Step {
    /// Where the step begins.
    pub(crate) fn start_ratio(&self) -> f64 {
        self.from.ratio
    }

    /// The limits of a bristle, `slow_n` while it slips slowly, if the step ended at `ratio`.
    pub(crate) fn limits_n(&self, slow_n: f64, ratio: f64) -> Limits {
        let unit_ratio = RATE_UNIT_MM_PER_S / NOMINAL_LENGTH_MM * self.dt_s;
        let rate = (ratio - self.from.ratio) / unit_ratio;
        let limit = |rate: f64| {
            let Dynamics { width_gain, rate_exponent, .. } = self.dynamics;
            if rate <= 0.0 || width_gain == 0.0 {
                return (slow_n, 0.0);
            }
            let slow = SLOW_MM_PER_S / RATE_UNIT_MM_PER_S;
            let rounded = rate * rate + slow * slow;
            let growth = rounded.powf(0.5 * rate_exponent) - slow.powf(rate_exponent);
            let slope = rate_exponent * rate * rounded.powf(0.5 * rate_exponent - 1.0);
            (slow_n * (1.0 + width_gain * growth), slow_n * width_gain * slope / unit_ratio)
        };
        Limits { rising: limit(rate), falling: limit(-rate) }
    }

    /// The motion at the end of a step that ended at `ratio`.
    pub(crate) fn arrive(&self, ratio: f64) -> Motion {
        if self.stiffness_n == 0.0 {
            return Motion::resting(ratio);
        }
        let Self { from, dt_s, .. } = self;
        let speed_per_s = 2.0 * (ratio - from.ratio) / dt_s - from.speed_per_s;
        let acceleration_per_s2 = 2.0 * (speed_per_s - from.speed_per_s) / dt_s - from.acceleration_per_s2;
        Motion { ratio, speed_per_s, acceleration_per_s2 }
    }
}
