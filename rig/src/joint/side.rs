//! One side of a joint: a valve and a muscle whose contraction is the joint's.

use crate::effects::{Effects, ValveLag};
use crate::muscle::{Condition, Muscle};
use crate::parameters::{NOMINAL_LENGTH_MM, VALVE_TIME_CONSTANT_S};
use crate::set_point::DeadBand;
use crate::valve::{Regulator, Valve};

/// How far the muscles are contracted where the joint stands at 0, mm. Assumed: the middle of what
/// they can do at half of the pressure.
pub const MOUNTED_MM: f64 = 50.0;

/// A valve and its muscle.
#[derive(Debug, Clone)]
pub struct Side {
    valve: Valve,
    muscle: Muscle,
    /// Factors on all forces, on the skin's stiffness and on the friction.
    strength: f64,
    skin: f64,
    friction: f64,
    length_mm: f64,
    pub(super) mounted_mm: f64,
}

impl Side {
    /// A vented side. `around` draws around a nominal value.
    pub(super) fn drawn(around: &mut impl FnMut(f64) -> f64) -> Self {
        let valve_lag = Some(ValveLag { time_constant_s: around(VALVE_TIME_CONSTANT_S) });
        Self {
            valve: Valve::with(&Effects { valve_lag, ..Effects::default() }, DeadBand::Hold),
            muscle: Muscle::at_rest(0.0),
            strength: around(1.0),
            skin: around(1.0),
            friction: around(1.0),
            length_mm: around(NOMINAL_LENGTH_MM),
            mounted_mm: around(MOUNTED_MM),
        }
    }

    /// Pressure in the muscle, bar.
    pub(super) fn pressure_bar(&self) -> f64 {
        self.valve.pressure_bar()
    }

    /// Holds a command (bar) for `dt_s`.
    pub(super) fn blow(&mut self, command_bar: f64, dt_s: f64) {
        self.valve.step(command_bar, 1.0, dt_s);
    }

    fn condition(&self) -> Condition {
        let Self { skin, friction, .. } = *self;
        Condition { skin, friction, ..Condition::sound(self.pressure_bar(), 0.0) }
    }

    /// What the muscle pulls with at a contraction (mm), N, negative where it would push, and the
    /// slope, N/mm.
    pub(super) fn pull_n(&self, contraction_mm: f64) -> (f64, f64) {
        let (pull_n, slope_n) = self.muscle.pull_n(contraction_mm / self.length_mm, &self.condition());
        (self.strength * pull_n, self.strength * slope_n / self.length_mm)
    }

    /// Holds the muscle at a contraction (mm).
    pub(super) fn hold(&mut self, contraction_mm: f64) {
        let condition = self.condition();
        self.muscle.hold(contraction_mm / self.length_mm, &condition);
    }
}
