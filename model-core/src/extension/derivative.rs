//! The time derivative of a sampled signal, at the last of its samples.
//!
//! v + λ v₋ = (1 + λ) s + (1 - λ) w (s - s₋), with s the slope of the last step, s₋ and v₋ slope
//! and derivative one sample before, w = dt/(dt + dt₋). It is exact for parabolas (when v₋ is), so
//! of second order, at steps of any lengths.
//!
//! # Why λ = ½
//! Both directions have to be stable. Solved for the signal (a model that is simulated), it
//! integrates: of equal steps A-stable for every λ up to 1. Solved for the derivative (a reference
//! that is differentiated), its memory fades as (-λ)ᵏ: at λ = 1, the trapezoidal rule or Newmark's
//! average acceleration, it never would, and one kink of the reference would ring for ever. λ = 0,
//! the second backward difference, forgets at once, but its error (2 - λ)/(1 + λ) dt² y‴/6 is four
//! times that of the trapezoidal rule; at ½ it is twice that, and the numerical damping of an
//! oscillation a fifth.

use crate::real::Real;

const LAMBDA: f64 = 0.5;

/// What a step of time makes of the formula.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub(super) struct Stencil<T> {
    /// 1/dt. Unit: 1/s.
    pub(super) per_second: T,
    /// The derivative for each unit that the signal moves. Unit: 1/s.
    gain: T,
    /// (1 - λ) w
    bend: T,
}

impl<T: Real> Stencil<T> {
    /// Of a step of `dt` after one of `before`. Both: s, above 0.
    pub(super) fn new(dt: T, before: T) -> Self {
        let lambda = T::from_f64(LAMBDA);
        let bend = (T::ONE - lambda) * (dt / (dt + before));
        let per_second = T::ONE / dt;
        Self { per_second, gain: (T::ONE + lambda + bend) * per_second, bend }
    }

    /// Of a signal that has rested: all derivatives are 0, however far it has moved in the
    /// meantime.
    pub(super) fn resting() -> Self {
        Self { per_second: T::ZERO, gain: T::ZERO, bend: T::ZERO }
    }

    /// Whether time has passed in which the signal moved.
    pub(super) fn is_moving(&self) -> bool {
        self.per_second > T::ZERO
    }
}

/// What is known of a value before the signal's sample is: constant + gain * (how far the signal
/// will have moved).
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Affine<T> {
    pub(super) constant: T,
    pub(super) gain: T,
}

impl<T: Real> Affine<T> {
    /// The move itself.
    pub(super) fn identity() -> Self {
        Self { constant: T::ZERO, gain: T::ONE }
    }

    #[inline(always)]
    pub(super) fn at(&self, moved: T) -> T {
        self.constant + self.gain * moved
    }
}

/// What is remembered of a signal to differentiate it; at first, that it rests.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub(super) struct Derivative<T> {
    slope: T,
    rate: T,
}

impl<T: Real> Derivative<T> {
    pub(super) fn resting() -> Self {
        Self { slope: T::ZERO, rate: T::ZERO }
    }

    /// The derivative at the next sample, given how far the signal moves until then.
    #[inline(always)]
    pub(super) fn rate(&self, stencil: &Stencil<T>, moves: &Affine<T>) -> Affine<T> {
        let memory = stencil.bend * self.slope + T::from_f64(LAMBDA) * self.rate;
        Affine { constant: stencil.gain * moves.constant - memory, gain: stencil.gain * moves.gain }
    }

    /// How far the derivative moves from the last sample to the next, at which it is `rate`.
    #[inline(always)]
    pub(super) fn moves(&self, rate: &Affine<T>) -> Affine<T> {
        Affine { constant: rate.constant - self.rate, gain: rate.gain }
    }

    /// The signal has moved, and has this derivative now. Answers how far the derivative has moved.
    #[inline(always)]
    pub(super) fn keep(&mut self, stencil: &Stencil<T>, moved: T, rate: T) -> T {
        let change = rate - self.rate;
        *self = Self { slope: moved * stencil.per_second, rate };
        change
    }
}
