//! Plays that are wider the faster the muscle moves: thresholds rᵢ g, with g = 1 + h(y) ρᵃ.
//!
//! ρ is the speed of sliding, the positive part of s y', through a first-order filter. y is the operator's output: what friction
//! resists is seen in the contraction, not in the pressure. s is what the plays hold back, before the move: from -1 where all
//! follow a fall to 1 where all follow a rise. All thresholds of the bank are wider by the same factor, so that
//! a fast loop has the form of a slow one. Where muscle or model are not of this kind the loop may be widened before
//! the operator instead ([`super::rate_dependent_width`]).
//!
//! # Both ways
//! The inverse knows y, so it knows g, and asks the bank for the input at these thresholds: explicit and exact. (By the speed
//! of the pressure it would have to run after its own answer: what is wider asks for a faster pressure, which is wider.)
//! The model does not know y. It looks for the y that is the answer at the g that it asks for: the faster y moves the wider is
//! the bank, of which the answer moves less. Were the speed of a move against s counted too there would be another, at which
//! plays that are wide by the move of the direct term alone are kept by that from following.
//!
//! # Limits
//! For cascades ([`crate::cascade`]) of at most ten plays without negative weights.

use crate::convert;
use crate::error::{Check, ParameterError, Requirement};
use crate::model::Model;
use crate::real::Real;

use super::profile::{Profile, ProfileParameters};
use super::sliding::{Sliding, SlidingStep};

/// The largest g.
const WIDEST: f64 = 1e3;

/// Raw parameters of thresholds that depend on the rate.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(
    feature = "serde",
    derive(serde::Serialize, serde::Deserialize),
    serde(bound = "T: serde::Serialize + serde::de::DeserializeOwned")
)]
pub struct RateDependentThresholdsParameters<T> {
    /// a. Unit: 1, above 0, at most 4.
    pub exponent: T,
    /// Time constant of the rate's filter. Unit: s, above 0.
    pub filter_s: T,
    /// h: by which part thresholds are wider at a rate of 1 output unit/s; nowhere below 0. Unit: 1.
    pub gain: ProfileParameters<T>,
}

impl<T: Real> RateDependentThresholdsParameters<T> {
    pub(super) fn convert<U: Real>(&self) -> Result<RateDependentThresholdsParameters<U>, ParameterError> {
        Ok(RateDependentThresholdsParameters {
            exponent: convert::number(self.exponent),
            filter_s: convert::number(self.filter_s),
            gain: self.gain.convert()?,
        })
    }
}

/// Validated thresholds that depend on the rate.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct RateDependentThresholds<T> {
    sliding: Sliding<T>,
    gain: Profile<T>,
}

/// The effect at a sample.
#[derive(Clone, Copy, Debug)]
pub(super) struct PresentThresholds<'a, T> {
    effect: &'a RateDependentThresholds<T>,
    step: &'a SlidingStep<T>,
    /// ρ at the sample before. Unit: output unit/s.
    rate: T,
    /// s.
    side: T,
}

impl<T: Real> RateDependentThresholds<T> {
    /// Of this operator.
    pub(super) fn try_new<const N: usize, const M: usize>(
        parameters: &RateDependentThresholdsParameters<T>,
        model: &Model<T, N, M>,
    ) -> Result<Self, ParameterError> {
        match model {
            Model::Cascade(cascade) => cascade.plays().check_widening()?,
            Model::Agpi(_) | Model::Egpi(_) => {
                let check = Check::new("number of envelopes where thresholds change", "");
                return Err(check.length(2, Requirement::Exactly(1.0)));
            }
        }
        Ok(Self {
            sliding: Sliding::try_new(
                ("rate_dependent_thresholds exponent", parameters.exponent),
                ("rate_dependent_thresholds filter_s", parameters.filter_s),
            )?,
            gain: Profile::try_positive(&parameters.gain, "rate_dependent_thresholds", "")?,
        })
    }

    /// For a step of `dt`; an endless one is a rest.
    pub(super) fn step(&self, dt: T) -> SlidingStep<T> {
        self.sliding.step(dt)
    }

    /// For the next sample, with ρ and s as they were at the last.
    pub(super) fn at<'a>(&'a self, step: &'a SlidingStep<T>, rate: T, side: T) -> PresentThresholds<'a, T> {
        PresentThresholds { effect: self, step, rate, side }
    }
}

impl<T: Real> PresentThresholds<'_, T> {
    /// ρ after a move of the output by `moved`.
    #[inline(always)]
    pub(super) fn rate(&self, moved: T) -> T {
        self.step.rate(self.rate, self.side, moved)
    }

    /// g after a move by `moved` to `y`.
    #[inline(always)]
    pub(super) fn times(&self, (y, moved): (T, T)) -> T {
        let wider = self.effect.gain.value(y) * self.effect.sliding.power(self.rate(moved));
        (T::ONE + wider).at_most(T::from_f64(WIDEST))
    }
}
