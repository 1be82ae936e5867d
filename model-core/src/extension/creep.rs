//! Creep: a part of every move comes late, over decades of time.
//!
//! Of the contraction, or, before the hysteresis, of the pressure: what follows is said of the
//! first.
//!
//! y = y₀ - Σ cₖ dₖ, where dₖ = y₀ - (y₀ through a first-order low-pass of time constant τₖ):
//! Kelvin-Voigt elements on a logarithmic grid. Between samples y₀ is taken to move evenly: of
//! second order.
//!
//! The distances dₖ are remembered, with compensated sums: what is added in a sample is a millionth
//! of them.
//!
//! # The inverse
//! Explicit: all dₖ are affine in the next move of y₀, and Σ cₖ < 1.

use crate::convert;
use crate::error::{Check, ParameterError, Requirement};
use crate::list::List;
use crate::real::Real;

use super::sum::Sum;
use super::{ExtensionParameters, Site, each, relaxation};

/// The most elements.
pub const CREEP_ELEMENTS: usize = 6;

/// Raw parameters of creep.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(
    feature = "serde",
    derive(serde::Serialize, serde::Deserialize),
    serde(bound = "T: Real + serde::Serialize + serde::de::DeserializeOwned")
)]
pub struct CreepParameters<T> {
    /// τ, strictly increasing. Unit: s, above 0.
    pub time_constants_s: List<T, CREEP_ELEMENTS>,
    /// c, as many as time constants: the share of a move that comes late by each. At least 0,
    /// together below 1.
    pub fractions: List<T, CREEP_ELEMENTS>,
}

impl<T: Real> CreepParameters<T> {
    pub(super) fn convert<U: Real>(&self) -> Result<CreepParameters<U>, ParameterError> {
        Ok(CreepParameters {
            time_constants_s: convert::list("time_constants_s", &self.time_constants_s)?,
            fractions: convert::list("fractions", &self.fractions)?,
        })
    }
}

/// Validated creep.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Creep<T> {
    parameters: CreepParameters<T>,
}

/// What a step of time makes of an element.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
struct ElementStep<T> {
    fraction: T,
    /// The part of the distance that is lost.
    share: T,
    /// The part of a move that is left at its end.
    mean: T,
}

/// What a step of time makes of creep.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(
    feature = "serde",
    derive(serde::Serialize, serde::Deserialize),
    serde(bound = "T: Real + serde::Serialize + serde::de::DeserializeOwned")
)]
pub(super) struct CreepStep<T> {
    elements: List<ElementStep<T>, CREEP_ELEMENTS>,
    /// The part of the next move that comes late.
    late: T,
    /// How far y₀ has to move for y to move by 1.
    per_move: T,
}

/// The distances dₖ. Output unit.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub(super) struct CreepMemory<T> {
    distances: [Sum<T>; CREEP_ELEMENTS],
}

impl<T: Real> CreepMemory<T> {
    pub(super) fn resting() -> Self {
        Self { distances: [Sum::default(); CREEP_ELEMENTS] }
    }
}

impl<T: Real> Creep<T> {
    pub(super) fn try_new(parameters: &CreepParameters<T>) -> Result<Self, ParameterError> {
        let CreepParameters { time_constants_s, fractions } = parameters;
        if fractions.len() != time_constants_s.len() {
            let requirement = Requirement::Exactly(time_constants_s.len() as f64);
            return Err(Check::new("number of creep fractions", "").length(fractions.len(), requirement));
        }
        let (mut last, mut sum) = (T::ZERO, T::ZERO);
        for (i, (&time_constant_s, &fraction)) in time_constants_s.iter().zip(fractions).enumerate() {
            last = Check::at("creep time_constants_s", i, "s").above(time_constant_s, last)?;
            sum += Check::at("creep fractions", i, "").at_least(fraction, T::ZERO)?;
        }
        if sum >= T::ONE {
            return Err(Check::new("sum of creep fractions", "").error(sum.to_f64(), Requirement::Below(1.0)));
        }
        Ok(Self { parameters: parameters.clone() })
    }

    /// The creep that acts at a site.
    pub(super) fn try_at(
        parameters: &ExtensionParameters<T>,
        site: Site,
    ) -> Result<Option<Self>, ParameterError> {
        if parameters.sites.creep == site { each(&parameters.creep, Self::try_new) } else { Ok(None) }
    }

    /// For the first sample: the muscle has crept to its end.
    pub(super) fn first(&self) -> CreepStep<T> {
        self.step(T::INFINITY)
    }

    pub(super) fn step(&self, dt: T) -> CreepStep<T> {
        let CreepParameters { time_constants_s, fractions } = &self.parameters;
        let element = |(&time_constant_s, &fraction): (&T, &T)| ElementStep {
            fraction,
            share: relaxation::share(dt, time_constant_s),
            mean: relaxation::mean(dt, time_constant_s),
        };
        let mut elements = List::<_, CREEP_ELEMENTS>::new();
        for pair in time_constants_s.iter().zip(fractions) {
            // Both lists have the same room.
            let _ = elements.push(element(pair));
        }
        let late = elements.iter().fold(T::ZERO, |late, element| late + element.fraction * element.mean);
        CreepStep { elements, late, per_move: T::ONE / (T::ONE - late) }
    }
}

impl<T: Real> CreepStep<T> {
    /// What creep takes from y when y₀ does not move. Output unit.
    #[inline(always)]
    fn taken(&self, memory: &CreepMemory<T>) -> T {
        let mut taken = T::ZERO;
        for (element, distance) in self.elements.iter().zip(&memory.distances) {
            taken += element.fraction * (distance.value() - element.share * distance.value());
        }
        taken
    }

    /// y, where y₀ has moved by `moved` to `y0`.
    pub(super) fn output(&self, memory: &CreepMemory<T>, y0: T, moved: T) -> T {
        y0 - self.late * moved - self.taken(memory)
    }

    /// How far y₀ has to move from `y0` for the output `y`.
    #[inline(always)]
    pub(super) fn moved(&self, memory: &CreepMemory<T>, y0: T, y: T) -> T {
        (y - y0 + self.taken(memory)) * self.per_move
    }

    /// y₀ has moved.
    #[inline(always)]
    pub(super) fn keep(&self, memory: &mut CreepMemory<T>, moved: T) {
        for (element, distance) in self.elements.iter().zip(&mut memory.distances) {
            distance.add(element.mean * moved - element.share * distance.value());
        }
    }
}
