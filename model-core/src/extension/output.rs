//! The effects behind the operator: on its output, and the zero, which has nothing to do with the
//! muscle.
//!
//! y₀ = y₁ + what the balance of this site takes, contraction = y₁ - creep + zero.
//!
//! # Limits
//! A y₁ that is farther from the operator's outputs than [`FARTHEST`] of their spans counts as one
//! that is not: no finite sample then leads out of the number type.

use crate::error::ParameterError;
use crate::range::Range;
use crate::real::Real;

use super::balance::{Balance, BalanceMemory, BalanceStep, Present};
use super::creep::{Creep, CreepMemory, CreepStep};
use super::drift::DriftParameters;
use super::periodic_disturbance::{PeriodicDisturbance, Pointer, Turn};
use super::root::{Point, root};
use super::sum::Sum;
use super::{ExtensionParameters, Site, Surroundings, each};

/// How far y₁ may be from the operator's outputs. Unit: their span.
const FARTHEST: f64 = 10.0;

/// The validated effects.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct OutputEffects<T> {
    balance: Option<Balance<T>>,
    creep: Option<Creep<T>>,
    /// Rate. Unit: output unit/s.
    drift: Option<T>,
    tone: Option<PeriodicDisturbance<T>>,
    /// Of y₁ where there is a balance.
    reach: Range<T>,
}

/// What a step of time makes of them.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(
    feature = "serde",
    derive(serde::Serialize, serde::Deserialize),
    serde(bound = "T: Real + serde::Serialize + serde::de::DeserializeOwned")
)]
pub(super) struct OutputStep<T> {
    balance: Option<BalanceStep<T>>,
    creep: Option<CreepStep<T>>,
    drift: T,
    turn: Option<Turn<T>>,
}

/// What they remember.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(
    feature = "serde",
    derive(serde::Serialize, serde::Deserialize),
    serde(bound = "T: Real + serde::Serialize + serde::de::DeserializeOwned")
)]
pub(super) struct OutputMemory<T> {
    balance: BalanceMemory<T>,
    /// y₁. Output unit.
    balanced: T,
    /// The slope of y₀ over y₁ that the last search found, where the next one begins with.
    slope: T,
    creep: CreepMemory<T>,
    drifted: Sum<T>,
    pointer: Option<Pointer<T>>,
}

/// What has to be for a wanted contraction.
pub(super) struct Aim<'a, T> {
    /// Output unit.
    pub(super) y0: T,
    y1: T,
    present: Option<(Present<'a, T>, &'a Range<T>)>,
}

impl<T: Real> OutputEffects<T> {
    /// None without effects. `output_range`: of the operator.
    pub(super) fn try_new(
        parameters: &ExtensionParameters<T>,
        output_range: (T, T),
    ) -> Result<Option<Self>, ParameterError> {
        let effects = Self {
            reach: reach(output_range)?,
            balance: Balance::try_new(parameters, Site::Contraction)?,
            creep: Creep::try_at(parameters, Site::Contraction)?,
            drift: each(&parameters.drift, DriftParameters::checked)?,
            tone: each(&parameters.periodic_disturbance, PeriodicDisturbance::try_new)?,
        };
        let none = Self { balance: None, creep: None, drift: None, tone: None, reach: effects.reach };
        Ok((effects != none).then_some(effects))
    }

    /// For a step of `dt` after one of `before`.
    pub(super) fn step(&self, dt: T, before: T) -> OutputStep<T> {
        OutputStep {
            balance: self.balance.as_ref().map(|balance| balance.step(dt, before)),
            creep: self.creep.as_ref().map(|creep| creep.step(dt)),
            drift: self.drift.map_or(T::ZERO, |rate| rate * dt),
            turn: self.tone.as_ref().map(|tone| tone.step(dt)),
        }
    }

    /// For the first sample: time begins with it, and the muscle has stood still and crept to its
    /// end.
    pub(super) fn first(&self) -> OutputStep<T> {
        OutputStep {
            balance: self.balance.as_ref().map(Balance::first),
            creep: self.creep.as_ref().map(Creep::first),
            drift: T::ZERO,
            turn: None,
        }
    }

    /// What they remember where the first sample is at this time (s) and the operator stands at
    /// `y0`.
    pub(super) fn resting(&self, y0: T, time_s: T) -> OutputMemory<T> {
        let mut drifted = Sum::default();
        drifted.add(self.drift.map_or(T::ZERO, |rate| rate * time_s));
        OutputMemory {
            balance: Balance::resting(y0),
            balanced: y0,
            slope: T::ONE,
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

    /// The balance at the next sample.
    #[inline(always)]
    fn present<'a>(
        &'a self,
        step: &'a OutputStep<T>,
        memory: &'a OutputMemory<T>,
        surroundings: &Surroundings<T>,
    ) -> Option<Present<'a, T>> {
        let (balance, step) = self.balance.as_ref().zip(step.balance.as_ref())?;
        Some(balance.at(step, &memory.balance, surroundings))
    }

    /// The contraction without the zero, for the operator's output. y₁ is found to `tolerance`
    /// (output unit).
    pub(super) fn contraction(
        &self,
        step: &OutputStep<T>,
        memory: &mut OutputMemory<T>,
        y0: T,
        surroundings: &Surroundings<T>,
        tolerance: T,
    ) -> T {
        let last = memory.balanced;
        let (mut y1, mut slope) = (y0, memory.slope);
        let present = self.present(step, memory, surroundings);
        if let Some(present) = &present {
            // Beyond the reach the balance takes what it takes there: there is a root, wherever
            // that is.
            let over = |y1: T| {
                let reached = self.reach.limit(y1);
                y1 + taken(present, reached, reached - last) - y0
            };
            let f = over(last);
            y1 = last;
            if f.abs() > tolerance {
                (y1, slope) = root(Point { u: last, f }, slope, tolerance, over);
            }
            y1 = self.reach.limit(y1);
        }
        let moved = y1 - last;
        let contraction = step.creep.as_ref().map_or(y1, |creep| creep.output(&memory.creep, y1, moved));
        let balance = present.map(|present| remembered(&present, y1, moved));
        memory.slope = slope;
        step.keep(memory, y1, moved, balance);
        contraction
    }

    /// What has to be for a contraction without the zero.
    #[inline(always)]
    pub(super) fn aim<'a>(
        &'a self,
        step: &'a OutputStep<T>,
        memory: &'a OutputMemory<T>,
        contraction: T,
        surroundings: &Surroundings<T>,
    ) -> Aim<'a, T> {
        let last = memory.balanced;
        let y1 = step
            .creep
            .as_ref()
            .map_or(contraction, |creep| last + creep.moved(&memory.creep, last, contraction));
        let present = self.present(step, memory, surroundings);
        let Some(present) = present else { return Aim { y0: y1, y1, present: None } };
        let y1 = self.reach.limit(y1);
        Aim { y0: y1 + taken(&present, y1, y1 - last), y1, present: Some((present, &self.reach)) }
    }
}

/// Whatever can count as a contraction, where the operator's outputs are from `lowest` to
/// `highest`.
///
/// # Errors
/// They are no range.
pub(crate) fn reach<T: Real>((lowest, highest): (T, T)) -> Result<Range<T>, ParameterError> {
    let margin = T::from_f64(FARTHEST) * (highest - lowest);
    Range::try_new(lowest - margin, highest + margin, "output range", "output unit")
}

/// What the balance takes, y₁ having moved by `moved` to `y1`.
#[inline(always)]
fn taken<T: Real>(present: &Present<'_, T>, y1: T, moved: T) -> T {
    present.value((y1, moved), (y1, moved))
}

#[inline(always)]
fn remembered<T: Real>(present: &Present<'_, T>, y1: T, moved: T) -> BalanceMemory<T> {
    present.remembered((y1, moved), moved)
}

impl<T: Real> Aim<'_, T> {
    /// What is reached where the operator's output is `y0`, which may be less than was aimed at:
    /// then the contraction is taken to fall short by as much. y₁, and what the balance remembers
    /// of it, for [`OutputStep::keep`].
    #[inline(always)]
    pub(super) fn reached(self, last: T, y0: T) -> (T, Option<BalanceMemory<T>>) {
        let y1 = self.y1 + (y0 - self.y0);
        match self.present {
            None => (y1, None),
            Some((present, reach)) => {
                let y1 = reach.limit(y1);
                (y1, Some(remembered(&present, y1, y1 - last)))
            }
        }
    }
}

impl<T: Real> OutputMemory<T> {
    /// y₁.
    pub(super) fn balanced(&self) -> T {
        self.balanced
    }
}

impl<T: Real> OutputStep<T> {
    /// y₁ has moved by `moved` to `y1`.
    #[inline(always)]
    pub(super) fn keep(
        &self,
        memory: &mut OutputMemory<T>,
        y1: T,
        moved: T,
        balance: Option<BalanceMemory<T>>,
    ) {
        memory.balanced = y1;
        if let Some(balance) = balance {
            memory.balance = balance;
        }
        if let Some(creep) = &self.creep {
            creep.keep(&mut memory.creep, moved);
        }
    }
}
