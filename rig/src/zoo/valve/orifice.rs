//! A proportional orifice between supply, chamber and exhaust: mass flow by ISO 6358, isothermal,
//! into a chamber that grows with the contraction.

use crate::effects::Effects;
use crate::set_point::{DeadBand, SetPoint};
use crate::valve::Regulator;

/// Ambient pressure, bar.
const AMBIENT_BAR: f64 = 1.013;

/// Ratio of pressures below which the flow is sonic.
const CRITICAL: f64 = 0.3;

/// Upstream pressure times flow function in mid-range, bar: what the time constant is stated at.
const TYPICAL_BAR: f64 = 7.7;

/// The valve and its chamber.
pub(super) struct Orifice {
    set_point: SetPoint,
    /// Error of pressure at which the valve is wide open, bar.
    open_bar: f64,
    /// Conductance over the volume at rest, 1/s.
    conductance_per_s: f64,
    pressure_bar: f64,
    volume: f64,
}

impl Orifice {
    /// One that follows small steps in mid-range with `time_constant_s` and opens wide at
    /// `open_bar`.
    pub(super) fn new(effects: &Effects, time_constant_s: f64, open_bar: f64) -> Self {
        Self {
            set_point: SetPoint::with(effects, DeadBand::Hold),
            open_bar,
            conductance_per_s: open_bar / (TYPICAL_BAR * time_constant_s),
            pressure_bar: 0.0,
            volume: 1.0,
        }
    }
}

/// Flow over sonic flow at a ratio of downstream to upstream pressure.
fn flow(ratio: f64) -> f64 {
    let over = ((ratio - CRITICAL) / (1.0 - CRITICAL)).clamp(0.0, 1.0);
    (1.0 - over * over).sqrt()
}

impl Regulator for Orifice {
    fn step(&mut self, command_bar: f64, volume: f64, dt_s: f64) {
        let error_bar = self.set_point.target_bar(command_bar) - self.pressure_bar;
        let opening = (error_bar / self.open_bar).clamp(-1.0, 1.0);
        let inside_bar = self.pressure_bar + AMBIENT_BAR;
        let supply_bar = self.set_point.supply_bar() + AMBIENT_BAR;
        let flow_bar_per_s = if opening > 0.0 {
            supply_bar * flow(inside_bar / supply_bar)
        } else {
            inside_bar * flow(AMBIENT_BAR / inside_bar)
        } * opening
            * self.conductance_per_s;
        let filled_bar = inside_bar * self.volume / volume + flow_bar_per_s / volume * dt_s;
        self.volume = volume;
        self.pressure_bar = (filled_bar - AMBIENT_BAR).clamp(0.0, self.set_point.supply_bar());
    }

    fn pressure_bar(&self) -> f64 {
        self.pressure_bar
    }
}
