//! The valve: dead band, supply, lag, from command to pressure, and the command that brings a
//! pressure about.
//!
//! # The inverse
//! It asks lag and dead band for the command, limits that, and then lets the same valve take it:
//! what it remembers is the pressure that a valve has which got this command, not the pressure that
//! was wanted. So after a limit has bound it leads on from where the valve is.

use crate::error::ParameterError;
use crate::range::Range;
use crate::real::Real;

use super::supply_saturation::SupplySaturationParameters;
use super::valve_deadband::ValveDeadband;
use super::valve_lag::{ValveLag, ValveLagMemory, ValveLagStep};
use super::{ExtensionParameters, each};

/// A validated valve.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Valve<T> {
    deadband: Option<ValveDeadband<T>>,
    supply: Option<T>,
    lag: Option<ValveLag<T>>,
}

/// What a step of time makes of it.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub(super) enum ValveStep<T> {
    /// At the first sample the valve has long had its command.
    First,
    /// The lag's, if there is one.
    Next(Option<ValveLagStep<T>>),
}

/// What the valve remembers. Input unit.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub(super) struct ValveMemory<T> {
    set_point: T,
    lag: ValveLagMemory<T>,
}

impl<T: Real> ValveMemory<T> {
    pub(super) fn resting(pressure: T) -> Self {
        Self { set_point: pressure, lag: ValveLagMemory::resting(pressure) }
    }
}

impl<T: Real> Valve<T> {
    /// None without effects.
    pub(super) fn try_new(parameters: &ExtensionParameters<T>) -> Result<Option<Self>, ParameterError> {
        let valve = Self {
            deadband: each(&parameters.valve_deadband, ValveDeadband::try_new)?,
            supply: each(&parameters.supply_saturation, SupplySaturationParameters::checked)?,
            lag: each(&parameters.valve_lag, ValveLag::try_new)?,
        };
        Ok((valve != Self { deadband: None, supply: None, lag: None }).then_some(valve))
    }

    pub(super) fn step(&self, dt: T) -> ValveStep<T> {
        ValveStep::Next(self.lag.map(|lag| lag.step(dt)))
    }

    /// The pressure that a command leads to.
    #[inline(always)]
    pub(super) fn pressure(&self, step: &ValveStep<T>, memory: &mut ValveMemory<T>, command: T) -> T {
        let (set_point, lag) = match (step, &self.deadband) {
            (ValveStep::First, _) => (command, None),
            (ValveStep::Next(lag), None) => (command, lag.as_ref()),
            (ValveStep::Next(lag), Some(deadband)) => {
                (deadband.set_point(memory.set_point, command), lag.as_ref())
            }
        };
        let supplied = self.supplied(set_point);
        memory.set_point = set_point;
        match lag {
            Some(lag) => lag.pressure(&mut memory.lag, supplied),
            None => {
                memory.lag = ValveLagMemory::resting(supplied);
                supplied
            }
        }
    }

    /// The command, within `limits`, that leads to the wanted pressure, or as near as limits and
    /// dead band allow.
    #[inline(always)]
    pub(super) fn command(
        &self,
        step: &ValveStep<T>,
        memory: &mut ValveMemory<T>,
        wanted: T,
        limits: &Range<T>,
    ) -> T {
        let command = match step {
            ValveStep::First => wanted,
            ValveStep::Next(lag) => {
                let set_point = lag.as_ref().map_or(wanted, |lag| lag.set_point(&memory.lag, wanted));
                let set_point = self.supplied(set_point);
                let command = |deadband: &ValveDeadband<T>| deadband.command(memory.set_point, set_point);
                self.deadband.as_ref().map_or(set_point, command)
            }
        };
        let command = limits.limit(command);
        self.pressure(step, memory, command);
        command
    }

    /// The set point, as far as the supply reaches.
    #[inline(always)]
    pub(super) fn supplied(&self, set_point: T) -> T {
        self.supply.map_or(set_point, |supply| set_point.at_most(supply))
    }
}
