//! A valve whose pressure follows its set point late.
//!
//! | form | what it is | the inverse |
//! |---|---|---|
//! | first order | one time constant | exact |
//! | second order | a spool before its chamber, or one that rings | that of a first-order lag as late |
//! | orifice | air into a chamber: another time constant at every pressure | the lead by that time constant |
//!
//! The inverse leads by at most `lead_limit`: a jump of the reference would else ask for dt/T
//! times as much pressure as there is.

use crate::convert;
use crate::error::{Check, ParameterError};
use crate::real::Real;

pub(crate) mod first_order;
mod orifice;
mod second_order;

use first_order::FirstOrderStep;
use orifice::OrificeStep;
use second_order::SecondOrderStep;

/// The lead limit where nothing is known: a choice. Input unit (bar).
pub const LEAD_LIMIT: f64 = 2.0;

/// How the pressure goes to its set point.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub enum ValveLagForm<T> {
    /// As a lag of one time constant.
    FirstOrder,
    /// As two lags one behind the other, or ringing.
    SecondOrder {
        /// Above 0; from 1 on it does not ring.
        damping_ratio: T,
    },
    /// As air through an orifice (ISO 6358).
    Orifice {
        /// Absolute pressure before the orifice. Input unit, above `outside`.
        supply: T,
        /// Absolute pressure outside, where the input is 0. Input unit, above 0.
        outside: T,
    },
}

/// Raw parameters of a valve's lag.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct ValveLagParameters<T> {
    /// T: of the first order the time constant; of the second how late the pressure is on a ramp;
    /// of an orifice the time constant where it fills at half of the supply. Unit: s, above 0.
    pub time_constant_s: T,
    /// How far the inverse's set point may be from the pressure, see [`LEAD_LIMIT`]. Input unit,
    /// above 0.
    pub lead_limit: T,
    /// How the pressure goes.
    pub form: ValveLagForm<T>,
}

impl<T: Real> ValveLagParameters<T> {
    /// Of the first order, with the usual lead limit. `time_constant_s`: s, above 0.
    pub fn new(time_constant_s: T) -> Self {
        Self { time_constant_s, lead_limit: T::from_f64(LEAD_LIMIT), form: ValveLagForm::FirstOrder }
    }

    pub(super) fn convert<U: Real>(&self) -> ValveLagParameters<U> {
        let number = convert::number;
        ValveLagParameters {
            time_constant_s: number(self.time_constant_s),
            lead_limit: number(self.lead_limit),
            form: match self.form {
                ValveLagForm::FirstOrder => ValveLagForm::FirstOrder,
                ValveLagForm::SecondOrder { damping_ratio } => {
                    ValveLagForm::SecondOrder { damping_ratio: number(damping_ratio) }
                }
                ValveLagForm::Orifice { supply, outside } => {
                    ValveLagForm::Orifice { supply: number(supply), outside: number(outside) }
                }
            },
        }
    }
}

/// A validated lag.
///
/// ```
/// use model_core::extension::valve_lag::{ValveLag, ValveLagMemory, ValveLagParameters};
///
/// let step = ValveLag::try_new(&ValveLagParameters::new(0.1))?.step(0.1);
/// let mut memory = ValveLagMemory::resting(0.0);
/// assert!((step.pressure(&mut memory, 1.0) - 0.632_f64).abs() < 1e-3); // bar
/// # Ok::<(), model_core::ParameterError>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ValveLag<T> {
    parameters: ValveLagParameters<T>,
}

/// What a step of time makes of it.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct ValveLagStep<T> {
    lead_limit: T,
    /// Of the first order, or what leads where there is no inverse.
    first: FirstOrderStep<T>,
    form: FormStep<T>,
}

#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
enum FormStep<T> {
    FirstOrder,
    SecondOrder(SecondOrderStep<T>),
    Orifice(OrificeStep<T>),
}

/// What a valve remembers of its lag. Input unit, and its rate a second.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct ValveLagMemory<T> {
    pressure: T,
    /// Of the second order.
    speed: T,
    /// The pressure of a first-order lag that is as late, by which one of the second order is led.
    led: T,
}

impl<T: Real> ValveLagMemory<T> {
    /// Of a pressure that stands still. Input unit.
    pub fn resting(pressure: T) -> Self {
        Self { pressure, speed: T::ZERO, led: pressure }
    }
}

impl<T: Real> ValveLag<T> {
    /// # Errors
    /// The first parameter that no valve has.
    pub fn try_new(parameters: &ValveLagParameters<T>) -> Result<Self, ParameterError> {
        let ValveLagParameters { time_constant_s, lead_limit, form } = *parameters;
        Check::new("valve_lag time_constant_s", "s").above(time_constant_s, T::ZERO)?;
        Check::new("valve_lag lead_limit", "input unit").above(lead_limit, T::ZERO)?;
        match form {
            ValveLagForm::FirstOrder => {}
            ValveLagForm::SecondOrder { damping_ratio } => {
                Check::new("valve_lag damping_ratio", "").above(damping_ratio, T::ZERO)?;
            }
            ValveLagForm::Orifice { supply, outside } => {
                let outside = Check::new("valve_lag outside", "input unit").above(outside, T::ZERO)?;
                Check::new("valve_lag supply", "input unit").above(supply, outside)?;
            }
        }
        Ok(Self { parameters: *parameters })
    }

    /// For steps of this length. Unit: s.
    pub fn step(&self, dt: T) -> ValveLagStep<T> {
        let ValveLagParameters { time_constant_s, lead_limit, form } = self.parameters;
        ValveLagStep {
            lead_limit,
            first: FirstOrderStep::new(time_constant_s, lead_limit, dt),
            form: match form {
                ValveLagForm::FirstOrder => FormStep::FirstOrder,
                ValveLagForm::SecondOrder { damping_ratio } => {
                    FormStep::SecondOrder(SecondOrderStep::new(time_constant_s, damping_ratio, dt))
                }
                ValveLagForm::Orifice { supply, outside } => {
                    FormStep::Orifice(OrificeStep::new(time_constant_s, (supply, outside), dt))
                }
            },
        }
    }
}

impl<T: Real> ValveLagStep<T> {
    /// The pressure after the step. Both: input unit.
    #[inline(always)]
    pub fn pressure(&self, memory: &mut ValveLagMemory<T>, set_point: T) -> T {
        let ValveLagMemory { pressure, speed, led } = memory;
        match &self.form {
            FormStep::FirstOrder => *pressure = self.first.pressure(*pressure, set_point),
            FormStep::SecondOrder(step) => {
                (*pressure, *speed) = step.after((*pressure, *speed), set_point);
                *led = self.first.pressure(*led, set_point);
            }
            FormStep::Orifice(step) => *pressure = step.pressure(*pressure, set_point),
        }
        memory.pressure
    }

    /// The set point that leads to the wanted pressure, or as near as form and lead limit allow.
    /// Both: input unit.
    #[inline(always)]
    pub(super) fn set_point(&self, memory: &ValveLagMemory<T>, wanted: T) -> T {
        match &self.form {
            FormStep::FirstOrder => self.first.set_point(memory.pressure, wanted),
            FormStep::SecondOrder(_) => self.first.set_point(memory.led, wanted),
            FormStep::Orifice(step) => step.set_point(memory.pressure, wanted, self.lead_limit),
        }
    }
}

#[cfg(test)]
mod tests;
