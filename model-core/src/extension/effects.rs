//! The three groups of effects with their steps of time and memories, as model and inverse share them.

use crate::error::ParameterError;
use crate::real::Real;

use super::ExtensionParameters;
use super::balance::{Balance, BalanceMemory, BalanceStep};
use super::output::{OutputEffects, OutputMemory, OutputStep};
use super::valve::{Valve, ValveMemory, ValveStep};

/// The validated effects, but for the delay.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Effects<T> {
    pub(super) valve: Option<Valve<T>>,
    pub(super) balance: Option<Balance<T>>,
    pub(super) output: Option<OutputEffects<T>>,
}

/// What a step of time makes of them.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct EffectsStep<T> {
    pub(super) valve: ValveStep<T>,
    pub(super) balance: Option<BalanceStep<T>>,
    pub(super) output: Option<OutputStep<T>>,
}

/// What they remember, and where the operator stands.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct EffectsMemory<T> {
    pub(super) valve: ValveMemory<T>,
    pub(super) balance: BalanceMemory<T>,
    pub(super) output: Option<OutputMemory<T>>,
    /// The operator's input. Input unit.
    pub(super) u: T,
    /// Its output. Output unit.
    pub(super) y0: T,
}

impl<T: Real> Effects<T> {
    pub(super) fn try_new(parameters: &ExtensionParameters<T>) -> Result<Self, ParameterError> {
        Ok(Self {
            valve: Valve::try_new(parameters)?,
            balance: Balance::try_new(parameters)?,
            output: OutputEffects::try_new(parameters)?,
        })
    }

    /// Whether there are none.
    pub(super) fn is_empty(&self) -> bool {
        self.valve.is_none() && self.balance.is_none() && self.output.is_none()
    }

    /// For a step of `dt` after one of `before`.
    pub(super) fn step(&self, dt: T, before: T) -> EffectsStep<T> {
        EffectsStep {
            valve: self.valve.as_ref().map_or(ValveStep::First, |valve| valve.step(dt)),
            balance: self.balance.as_ref().map(|balance| balance.step(dt, before)),
            output: self.output.as_ref().map(|output| output.step(dt)),
        }
    }

    /// For the first sample.
    pub(super) fn first(&self) -> EffectsStep<T> {
        EffectsStep {
            valve: ValveStep::First,
            balance: self.balance.as_ref().map(Balance::first),
            output: self.output.as_ref().map(OutputEffects::first),
        }
    }

    /// Before the first sample, which is at this time (s): the operator stands at `u` and `y0`.
    pub(super) fn resting(&self, u: T, y0: T, time_s: T) -> EffectsMemory<T> {
        EffectsMemory {
            valve: ValveMemory::resting(u),
            balance: Balance::resting(u),
            output: self.output.as_ref().map(|output| output.resting(time_s)),
            u,
            y0,
        }
    }
}
