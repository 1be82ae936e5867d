//! A loop that widens with speed and does not lag at rest: h(y) ρᵃ s(u).
//!
//! s is the stop of radius r on the operator's input u, divided by r: from -1 on the way down to 1
//! on the way up. ρ is the speed of sliding, the positive part of s u', through a first-order
//! filter.
//!
//! # Why of sliding
//! While the stop still turns round, s and u' have opposite signs. Were their speed counted there,
//! a faster move would ask for less pressure and the muscle could not be simulated: F of
//! [`super::ExtendedModel`] would fall. And the present sample counts: with the speed of the sample
//! before, the simulation is unstable from h a ρᵃ⁻¹ = filter_s on. As it is, the effect rises with
//! u from every state.

use crate::convert;
use crate::error::{Check, ParameterError};
use crate::real::Real;

use super::profile::{Profile, ProfileParameters};
use super::sliding::{Sliding, SlidingStep};

/// Raw parameters of a rate-dependent width.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(
    feature = "serde",
    derive(serde::Serialize, serde::Deserialize),
    serde(bound = "T: Real + serde::Serialize + serde::de::DeserializeOwned")
)]
pub struct RateDependentWidthParameters<T> {
    /// r: half the way over which the friction turns round. Input unit, above 0.
    pub radius: T,
    /// a. Unit: 1, above 0, at most 4.
    pub exponent: T,
    /// Time constant of the rate's filter. Unit: s, above 0.
    pub filter_s: T,
    /// Half the width at a rate of 1 input unit/s; nowhere below 0. Input unit.
    pub width: ProfileParameters<T>,
}

impl<T: Real> RateDependentWidthParameters<T> {
    pub(super) fn convert<U: Real>(&self) -> Result<RateDependentWidthParameters<U>, ParameterError> {
        Ok(RateDependentWidthParameters {
            radius: convert::number(self.radius),
            exponent: convert::number(self.exponent),
            filter_s: convert::number(self.filter_s),
            width: self.width.convert()?,
        })
    }
}

/// A validated rate-dependent width.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct RateDependentWidth<T> {
    radius: T,
    per_radius: T,
    sliding: Sliding<T>,
    width: Profile<T>,
}

/// What is remembered of the operator's input.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub(super) struct WidthMemory<T> {
    /// Output of the play of radius r. Input unit.
    play: T,
    /// ρ. Unit: input unit/s.
    rate: T,
}

impl<T: Real> WidthMemory<T> {
    /// Of a muscle that has long stood at the input `u`.
    pub(super) fn resting(u: T) -> Self {
        Self { play: u, rate: T::ZERO }
    }
}

/// The effect at a sample.
#[derive(Clone, Copy, Debug)]
pub(super) struct Width<'a, T> {
    effect: &'a RateDependentWidth<T>,
    step: &'a SlidingStep<T>,
    memory: &'a WidthMemory<T>,
}

impl<T: Real> RateDependentWidth<T> {
    pub(super) fn try_new(parameters: &RateDependentWidthParameters<T>) -> Result<Self, ParameterError> {
        let radius =
            Check::new("rate_dependent_width radius", "input unit").above(parameters.radius, T::ZERO)?;
        Ok(Self {
            radius,
            per_radius: Check::new("1/radius", "1/input unit").finite(T::ONE / radius)?,
            sliding: Sliding::try_new(
                ("rate_dependent_width exponent", parameters.exponent),
                ("rate_dependent_width filter_s", parameters.filter_s),
            )?,
            width: Profile::try_positive(&parameters.width, "rate_dependent_width", "input unit")?,
        })
    }

    /// For a step of `dt`; an endless one is a rest.
    pub(super) fn step(&self, dt: T) -> SlidingStep<T> {
        self.sliding.step(dt)
    }

    pub(super) fn at<'a>(&'a self, step: &'a SlidingStep<T>, memory: &'a WidthMemory<T>) -> Width<'a, T> {
        Width { effect: self, step, memory }
    }
}

impl<T: Real> Width<'_, T> {
    /// What is remembered, and the stop (-1 to 1), after a move of u by `pushed` to `u`.
    #[inline(always)]
    fn next(&self, u: T, pushed: T) -> (WidthMemory<T>, T) {
        let RateDependentWidth { radius, per_radius, .. } = self.effect;
        let play = self.memory.play.limit(u - *radius, u + *radius);
        let stop = (u - play) * *per_radius;
        (WidthMemory { play, rate: self.step.rate(self.memory.rate, stop, pushed) }, stop)
    }

    /// What the effect takes, with the operator's output at `y`. Input unit.
    #[inline(always)]
    pub(super) fn value(&self, u: T, pushed: T, y: T) -> T {
        let (WidthMemory { rate, .. }, stop) = self.next(u, pushed);
        self.effect.width.value(y) * self.effect.sliding.power(rate) * stop
    }

    /// What is remembered after the move.
    #[inline(always)]
    pub(super) fn moved(&self, u: T, pushed: T) -> WidthMemory<T> {
        self.next(u, pushed).0
    }
}
