//! A pilot stage before the main one: second order.

use crate::effects::Effects;
use crate::set_point::{DeadBand, SetPoint};
use crate::valve::Regulator;

/// Pressure and its rate.
pub(super) struct SecondOrder {
    set_point: SetPoint,
    natural_per_s: f64,
    damping_ratio: f64,
    pressure_bar: f64,
    rate_bar_per_s: f64,
}

impl SecondOrder {
    /// One that lags a ramp by `time_constant_s`.
    pub(super) fn new(effects: &Effects, time_constant_s: f64, damping_ratio: f64) -> Self {
        Self {
            set_point: SetPoint::with(effects, DeadBand::Hold),
            natural_per_s: 2.0 * damping_ratio / time_constant_s,
            damping_ratio,
            pressure_bar: 0.0,
            rate_bar_per_s: 0.0,
        }
    }
}

impl Regulator for SecondOrder {
    fn step(&mut self, command_bar: f64, _volume: f64, dt_s: f64) {
        let target_bar = self.set_point.target_bar(command_bar);
        let ahead = self.natural_per_s * self.natural_per_s * dt_s;
        // Implicit in damping, so that any step is stable.
        self.rate_bar_per_s = (self.rate_bar_per_s + ahead * (target_bar - self.pressure_bar))
            / (1.0 + 2.0 * self.damping_ratio * self.natural_per_s * dt_s + ahead * dt_s);
        self.pressure_bar = (self.pressure_bar + self.rate_bar_per_s * dt_s).max(0.0);
    }

    fn pressure_bar(&self) -> f64 {
        self.pressure_bar
    }
}
