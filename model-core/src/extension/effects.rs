//! The groups of effects with their steps of time and memories, as model and inverse share them.

use crate::error::ParameterError;
use crate::hysteresis::Hysteresis;
use crate::model::Model;
use crate::real::Real;

use super::balance::{Balance, BalanceMemory, BalanceStep};
use super::creep::{Creep, CreepMemory, CreepStep};
use super::output::{OutputEffects, OutputMemory, OutputStep};
use super::rate_dependent_thresholds::RateDependentThresholds;
use super::sliding::SlidingStep;
use super::valve::{Valve, ValveMemory, ValveStep};
use super::{ExtensionParameters, Site, each};

/// The validated effects, but for the delay.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Effects<T> {
    pub(super) valve: Option<Valve<T>>,
    /// Of the pressure.
    pub(super) creep: Option<Creep<T>>,
    pub(super) balance: Option<Balance<T>>,
    pub(super) thresholds: Option<RateDependentThresholds<T>>,
    pub(super) output: Option<OutputEffects<T>>,
}

/// What a step of time makes of them.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(
    feature = "serde",
    derive(serde::Serialize, serde::Deserialize),
    serde(bound = "T: Real + serde::Serialize + serde::de::DeserializeOwned")
)]
pub(super) struct EffectsStep<T> {
    pub(super) valve: ValveStep<T>,
    pub(super) creep: Option<CreepStep<T>>,
    pub(super) balance: Option<BalanceStep<T>>,
    pub(super) thresholds: Option<SlidingStep<T>>,
    pub(super) output: Option<OutputStep<T>>,
}

/// What they remember, and where the operator stands.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(
    feature = "serde",
    derive(serde::Serialize, serde::Deserialize),
    serde(bound = "T: Real + serde::Serialize + serde::de::DeserializeOwned")
)]
pub(super) struct EffectsMemory<T> {
    pub(super) valve: ValveMemory<T>,
    pub(super) creep: CreepMemory<T>,
    /// The pressure that creeps. Input unit.
    pub(super) felt: T,
    pub(super) balance: BalanceMemory<T>,
    /// The rate that thresholds depend on. Unit: output unit/s; in a model whose thresholds go by
    /// the pressure input unit/s.
    pub(super) rate: T,
    pub(super) output: Option<OutputMemory<T>>,
    /// The operator's input. Input unit.
    pub(super) u: T,
    /// Its output. Output unit.
    pub(super) y0: T,
}

impl<T: Real> Effects<T> {
    /// Of this operator.
    pub(super) fn try_new<const N: usize, const M: usize>(
        parameters: &ExtensionParameters<T>,
        model: &Model<T, N, M>,
    ) -> Result<Self, ParameterError> {
        let thresholds = |thresholds: &_| RateDependentThresholds::try_new(thresholds, model);
        Ok(Self {
            valve: Valve::try_new(parameters)?,
            creep: Creep::try_at(parameters, Site::Pressure)?,
            balance: Balance::try_new(parameters, Site::Pressure)?,
            thresholds: each(&parameters.rate_dependent_thresholds, thresholds)?,
            output: OutputEffects::try_new(parameters, model.output_range())?,
        })
    }

    /// Whether there are none.
    pub(super) fn is_empty(&self) -> bool {
        let Self { valve, creep, balance, thresholds, output } = self;
        let is_before = valve.is_none() && creep.is_none() && balance.is_none();
        is_before && thresholds.is_none() && output.is_none()
    }

    /// For a step of `dt` after one of `before`.
    pub(super) fn step(&self, dt: T, before: T) -> EffectsStep<T> {
        EffectsStep {
            valve: self.valve.as_ref().map_or(ValveStep::First, |valve| valve.step(dt)),
            creep: self.creep.as_ref().map(|creep| creep.step(dt)),
            balance: self.balance.as_ref().map(|balance| balance.step(dt, before)),
            thresholds: self.thresholds.as_ref().map(|thresholds| thresholds.step(dt)),
            output: self.output.as_ref().map(|output| output.step(dt, before)),
        }
    }

    /// For the first sample.
    pub(super) fn first(&self) -> EffectsStep<T> {
        EffectsStep {
            valve: ValveStep::First,
            creep: self.creep.as_ref().map(Creep::first),
            balance: self.balance.as_ref().map(Balance::first),
            thresholds: self.thresholds.as_ref().map(|thresholds| thresholds.step(T::INFINITY)),
            output: self.output.as_ref().map(OutputEffects::first),
        }
    }

    /// Before the first sample, which is at this time (s): the operator stands at `u` and `y0`.
    pub(super) fn resting(&self, u: T, y0: T, time_s: T) -> EffectsMemory<T> {
        EffectsMemory {
            valve: ValveMemory::resting(u),
            creep: CreepMemory::resting(),
            felt: u,
            balance: Balance::resting(u),
            rate: T::ZERO,
            output: self.output.as_ref().map(|output| output.resting(y0, time_s)),
            u,
            y0,
        }
    }
}
