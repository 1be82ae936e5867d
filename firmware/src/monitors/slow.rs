//! A quantity that changes slowly, the supply or a temperature: its average against limits.

use wire::fault::times::BAD_IN_A_ROW;
use wire::{Fault, Protection, Scaling};

use super::persistence::{Average, InARow};
use crate::scaling::{TEMPERATURE, level};

/// What is good.
#[derive(Clone, Copy, Debug)]
pub struct Limits {
    /// Its plausible codes.
    pub scaling: Scaling,
    /// Lowest average. Unit: ADC code.
    pub lowest: u16,
    /// Highest average. Unit: ADC code.
    pub highest: u16,
    /// What implausible codes and an average outside are.
    pub faults: [Fault; 2],
}

impl Limits {
    /// Of the pressure before the valve.
    pub fn of_supply(protection: &Protection, scaling: Scaling) -> Self {
        Self {
            scaling,
            lowest: level(&scaling, protection.supply_min_bar),
            highest: u16::MAX,
            faults: [Fault::SupplySensor, Fault::SupplyLow],
        }
    }

    /// Of the processor's temperature.
    pub fn of_temperature(protection: &Protection) -> Self {
        Self {
            scaling: TEMPERATURE,
            lowest: 0,
            highest: level(&TEMPERATURE, protection.temperature_max_c),
            faults: [Fault::Temperature; 2],
        }
    }
}

/// What is remembered of the codes.
#[derive(Clone, Copy, Debug, Default)]
pub struct Slow {
    implausible: InARow,
    average: Average<6>,
    /// The last average.
    code: u16,
}

impl Slow {
    /// Takes the code of a tick; answers the average. Implausible codes are left out.
    ///
    /// # Errors
    /// The sensor is open or short, or the average is outside the limits.
    #[inline(always)]
    pub fn take(&mut self, limits: &Limits, code: u16) -> Result<u16, Fault> {
        let [implausible, outside] = limits.faults;
        let is_plausible = limits.scaling.is_plausible(code);
        if self.implausible.holds_for(BAD_IN_A_ROW, !is_plausible) {
            return Err(implausible);
        }
        if is_plausible {
            self.code = self.average.of(code);
            if self.code < limits.lowest || self.code > limits.highest {
                return Err(outside);
            }
        }
        Ok(self.code)
    }
}
