//! Too much pressure in a muscle: in one sample, or on average.

use wire::{Fault, Protection, Scaling};

use super::persistence::Average;
use crate::scaling::level;

/// What the codes are compared with. Unit: ADC code.
#[derive(Clone, Copy, Debug)]
pub struct Limits {
    /// Above it a single sample vents.
    pub hard: u16,
    /// Above it the average vents.
    pub soft: u16,
    /// What is above this is no pressure but a broken sensor.
    pub highest: u16,
}

impl Limits {
    /// The protection's limits in codes of a pressure.
    pub fn new(protection: &Protection, pressure: &Scaling) -> Self {
        Self {
            hard: level(pressure, protection.overpressure_hard_bar),
            soft: level(pressure, protection.overpressure_soft_bar),
            highest: pressure.code_max,
        }
    }

    /// Looks at a sample itself: a burst is no less likely than a spike.
    ///
    /// # Errors
    /// It is above the hard limit.
    #[inline(always)]
    pub fn hold(&self, code: u16) -> Result<(), Fault> {
        if code > self.hard && code <= self.highest { Err(Fault::OverpressureHard) } else { Ok(()) }
    }
}

/// The average of a muscle's pressure over some 16 ticks.
#[derive(Clone, Copy, Debug, Default)]
pub struct Overpressure {
    average: Average<4>,
}

impl Overpressure {
    /// Takes the code of a tick, as far as it can be trusted.
    ///
    /// # Errors
    /// The average is above the soft limit.
    #[inline(always)]
    pub fn take(&mut self, limits: &Limits, code: u16) -> Result<(), Fault> {
        if self.average.of(code) > limits.soft { Err(Fault::OverpressureSoft) } else { Ok(()) }
    }
}
