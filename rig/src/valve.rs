//! The proportional pressure regulator: dead band, limits, then a first-order lag.
//!
//! Exact for a command held over the step, whatever the step. A sound regulator has no dead band,
//! and a supply above its range.

use crate::effects::Effects;
use crate::parameters::VALVE_TIME_CONSTANT_S;
use crate::set_point::{DeadBand, SetPoint};

/// What turns a command into the pressure in the muscle.
pub trait Regulator: Send {
    /// Holds `command_bar` for `dt_s` (0 s and more) with `volume` in the muscle, relative to that
    /// at rest. A command outside the range or beyond the supply is cut.
    fn step(&mut self, command_bar: f64, volume: f64, dt_s: f64);

    /// The pressure in the muscle, bar.
    fn pressure_bar(&self) -> f64;
}

/// A regulator of first order and the pressure it has reached.
#[derive(Debug, Clone)]
pub struct Valve {
    set_point: SetPoint,
    time_constant_s: f64,
    pressure_bar: f64,
}

impl Default for Valve {
    fn default() -> Self {
        Self::with(&Effects::default(), DeadBand::Hold)
    }
}

impl Valve {
    /// A vented regulator with what of `effects` is the valve's.
    pub fn with(effects: &Effects, dead_band: DeadBand) -> Self {
        Self {
            set_point: SetPoint::with(effects, dead_band),
            time_constant_s: effects
                .valve_lag
                .as_ref()
                .map_or(VALVE_TIME_CONSTANT_S, |hidden| hidden.time_constant_s),
            pressure_bar: 0.0,
        }
    }
}

impl Regulator for Valve {
    fn pressure_bar(&self) -> f64 {
        self.pressure_bar
    }

    fn step(&mut self, command_bar: f64, _volume: f64, dt_s: f64) {
        let target_bar = self.set_point.target_bar(command_bar);
        self.pressure_bar += (target_bar - self.pressure_bar) * -(-dt_s / self.time_constant_s).exp_m1();
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::effects::{SupplySaturation, ValveDeadband, ValveLag};
    use crate::parameters::VALVE_RANGE_BAR;

    #[test]
    fn step_response_is_a_first_order_lag_at_any_step_size() {
        for time_constant_s in [VALVE_TIME_CONSTANT_S, 0.3] {
            for steps in [1, 7, 50] {
                let valve_lag = Some(ValveLag { time_constant_s });
                let effects = Effects { valve_lag, ..Effects::default() };
                let mut valve = Valve::with(&effects, DeadBand::Hold);
                for _ in 0..steps {
                    valve.step(4.0, 1.0, time_constant_s / f64::from(steps));
                }
                let expected_bar = 4.0 * (1.0 - (-1.0f64).exp());
                assert!((valve.pressure_bar() - expected_bar).abs() < 1e-12, "{steps} steps");
            }
        }
    }

    #[test]
    fn pressure_stays_between_vented_and_the_range_or_a_weak_supply() {
        let weak =
            Effects { supply_saturation: Some(SupplySaturation { supply_bar: 4.5 }), ..Effects::default() };
        for (effects, highest_bar) in [(Effects::default(), VALVE_RANGE_BAR), (weak, 4.5)] {
            let mut valve = Valve::with(&effects, DeadBand::Hold);
            valve.step(100.0, 1.0, 10.0);
            assert!((valve.pressure_bar() - highest_bar).abs() < 1e-12);
            valve.step(-100.0, 1.0, 10.0);
            assert!(valve.pressure_bar().abs() < 1e-12);
        }
    }

    #[test]
    fn dead_band_ignores_changes_below_it_in_either_form() {
        let valve_deadband = Some(ValveDeadband { band_bar: 0.2 });
        let effects = Effects { valve_deadband, ..Effects::default() };
        let settled_bar = |dead_band, commands_bar: &[f64]| {
            let mut valve = Valve::with(&effects, dead_band);
            commands_bar.iter().for_each(|command_bar| valve.step(*command_bar, 1.0, 10.0));
            valve.pressure_bar()
        };
        for (commands_bar, hold_bar, backlash_bar) in [
            (&[2.0, 2.1][..], 2.0, 2.0),
            (&[2.0, 2.15], 2.0, 2.05),
            (&[2.0, 2.3], 2.3, 2.2),
            (&[2.0, 1.5], 1.5, 1.6),
        ] {
            assert!((settled_bar(DeadBand::Hold, commands_bar) - hold_bar).abs() < 1e-9);
            assert!((settled_bar(DeadBand::Backlash, commands_bar) - backlash_bar).abs() < 1e-9);
        }
    }
}
