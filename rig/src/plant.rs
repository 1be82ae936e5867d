//! The rig as a controller sees it: command in, measured pressure and contraction out.
//!
//! Valve, then muscle under its dead load, then sensors. The caller sets the pace: a command is held over any
//! time step, the valve is exact for it and the muscle has no time in it. Steps of 50 ms and of 1 ms agree
//! within 5 µm.

use crate::muscle::Muscle;
use crate::sensor::{Measurement, Sensors};
use crate::valve::Valve;

/// A muscle on its valve with its sensors.
#[derive(Debug, Clone)]
pub struct Plant {
    valve: Valve,
    muscle: Muscle,
    sensors: Sensors,
    load_n: f64,
}

impl Plant {
    /// A vented plant at rest under `load_n`, from 0 N to [`LOAD_LIMIT_N`](crate::parameters::LOAD_LIMIT_N).
    pub fn at_rest(load_n: f64, sensors: Sensors) -> Self {
        Self { valve: Valve::default(), muscle: Muscle::at_rest(load_n), sensors, load_n }
    }

    /// Holds `command_bar` for `dt_s` (0 s and more), then measures.
    pub fn step(&mut self, command_bar: f64, dt_s: f64) -> Measurement {
        self.valve.step(command_bar, dt_s);
        self.muscle.step(self.valve.pressure_bar(), self.load_n);
        self.sensors.measure(Measurement {
            pressure_bar: self.valve.pressure_bar(),
            contraction_mm: self.muscle.contraction_mm(),
        })
    }
}
