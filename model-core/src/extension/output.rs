//! The effects on the output: creep, drift, tone.
//!
//! output = y₀ - creep + zero, the zero being what has nothing to do with the muscle.

use crate::error::ParameterError;
use crate::real::Real;

use super::creep::{Creep, CreepMemory, CreepStep};
use super::drift::DriftParameters;
use super::periodic_disturbance::{PeriodicDisturbance, Pointer, Turn};
use super::sum::Sum;
use super::{ExtensionParameters, each};

/// The validated effects.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct OutputEffects<T> {
    creep: Option<Creep<T>>,
    /// Rate. Unit: output unit/s.
    drift: Option<T>,
    tone: Option<PeriodicDisturbance<T>>,
}

/// What a step of time makes of them.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct OutputStep<T> {
    creep: Option<CreepStep<T>>,
    drift: T,
    turn: Option<Turn<T>>,
}

/// What they remember.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct OutputMemory<T> {
    creep: CreepMemory<T>,
    drifted: Sum<T>,
    pointer: Option<Pointer<T>>,
}

impl<T: Real> OutputEffects<T> {
    /// None without effects.
    pub(super) fn try_new(parameters: &ExtensionParameters<T>) -> Result<Option<Self>, ParameterError> {
        let effects = Self {
            creep: each(&parameters.creep, Creep::try_new)?,
            drift: each(&parameters.drift, DriftParameters::checked)?,
            tone: each(&parameters.periodic_disturbance, PeriodicDisturbance::try_new)?,
        };
        Ok((effects != Self { creep: None, drift: None, tone: None }).then_some(effects))
    }

    /// For a step of `dt`.
    pub(super) fn step(&self, dt: T) -> OutputStep<T> {
        OutputStep {
            creep: self.creep.as_ref().map(|creep| creep.step(dt)),
            drift: self.drift.map_or(T::ZERO, |rate| rate * dt),
            turn: self.tone.as_ref().map(|tone| tone.step(dt)),
        }
    }

    /// For the first sample: time begins with it, and the muscle has crept to its end.
    pub(super) fn first(&self) -> OutputStep<T> {
        let creep = self.creep.as_ref().map(|creep| creep.step(T::INFINITY));
        OutputStep { creep, drift: T::ZERO, turn: None }
    }

    /// What they remember where the first sample is at this time. Unit: s.
    pub(super) fn resting(&self, time_s: T) -> OutputMemory<T> {
        let mut drifted = Sum::default();
        drifted.add(self.drift.map_or(T::ZERO, |rate| rate * time_s));
        OutputMemory {
            creep: CreepMemory::resting(),
            drifted,
            pointer: self.tone.as_ref().map(|tone| tone.start(time_s)),
        }
    }

    /// The zero at the next sample. Output unit.
    #[inline(always)]
    pub(super) fn zero(&self, step: &OutputStep<T>, memory: &mut OutputMemory<T>) -> T {
        memory.drifted.add(step.drift);
        let mut zero = memory.drifted.value();
        if let (Some(tone), Some(pointer)) = (&self.tone, &mut memory.pointer) {
            if let Some(turn) = &step.turn {
                pointer.turn(turn);
            }
            zero += tone.value(pointer);
        }
        zero
    }
}

impl<T: Real> OutputStep<T> {
    /// The output without the zero, where y₀ has moved by `moved` to `y0`.
    pub(super) fn output(&self, memory: &OutputMemory<T>, y0: T, moved: T) -> T {
        self.creep.as_ref().map_or(y0, |creep| creep.output(&memory.creep, y0, moved))
    }

    /// y₀, which was `before`, for an output without the zero.
    #[inline(always)]
    pub(super) fn y0(&self, memory: &OutputMemory<T>, before: T, output: T) -> T {
        self.creep.as_ref().map_or(output, |creep| before + creep.moved(&memory.creep, before, output))
    }

    /// y₀ has moved.
    #[inline(always)]
    pub(super) fn keep(&self, memory: &mut OutputMemory<T>, moved: T) {
        if let Some(creep) = &self.creep {
            creep.keep(&mut memory.creep, moved);
        }
    }
}
