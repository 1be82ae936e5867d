//! The proportional pressure regulator: limits, then a first-order lag.
//!
//! Exact for a command held over the step, whatever the step.

use crate::parameters::{SUPPLY_BAR, VALVE_RANGE_BAR, VALVE_TIME_CONSTANT_S};

/// A regulator and the pressure it has reached.
#[derive(Debug, Clone, Default)]
pub struct Valve {
    pressure_bar: f64,
}

impl Valve {
    /// The pressure in the muscle, bar.
    pub fn pressure_bar(&self) -> f64 {
        self.pressure_bar
    }

    /// Holds `command_bar` for `dt_s` (0 s and more). A command outside the range or beyond the supply is
    /// cut.
    pub fn step(&mut self, command_bar: f64, dt_s: f64) {
        let target_bar = command_bar.clamp(0.0, VALVE_RANGE_BAR.min(SUPPLY_BAR));
        self.pressure_bar += (target_bar - self.pressure_bar) * -(-dt_s / VALVE_TIME_CONSTANT_S).exp_m1();
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn step_response_is_a_first_order_lag_at_any_step_size() {
        for steps in [1, 7, 50] {
            let mut valve = Valve::default();
            for _ in 0..steps {
                valve.step(4.0, VALVE_TIME_CONSTANT_S / f64::from(steps));
            }
            let expected_bar = 4.0 * (1.0 - (-1.0f64).exp());
            assert!((valve.pressure_bar() - expected_bar).abs() < 1e-12, "{steps} steps");
        }
    }

    #[test]
    fn pressure_stays_between_vented_and_the_range() {
        let mut valve = Valve::default();
        valve.step(100.0, 10.0);
        assert!((valve.pressure_bar() - VALVE_RANGE_BAR).abs() < 1e-12);
        valve.step(-100.0, 10.0);
        assert!(valve.pressure_bar().abs() < 1e-12);
    }
}
