//! A proportional solenoid valve whose coil sees the mean of a pulse train: duty cycle 0 to 1 for
//! the codes 0 to 4095.

use embedded_hal::pwm::SetDutyCycle;

use super::{DacCode, Valve};
use crate::scaling::COMMAND;

/// A valve on a pulse-width output.
#[derive(Debug)]
pub struct PwmValve<P>(pub P);

impl<P: SetDutyCycle> Valve for PwmValve<P> {
    type Error = P::Error;

    fn set(&mut self, code: DacCode) -> Result<(), P::Error> {
        self.0.set_duty_cycle_fraction(code.0.min(COMMAND.code_max), COMMAND.code_max)
    }
}
