//! Plays that are wider the faster the muscle moves: thresholds rᵢ g, with g = 1 + h(y) ρᵃ.
//!
//! ρ is the speed of sliding, the positive part of s y', through a first-order filter. y is the
//! operator's output: what friction resists is seen in the contraction, not in the pressure. s is
//! what the plays hold back, before the move: from -1 where all follow a fall to 1 where all follow
//! a rise. All thresholds of the bank are wider by the same factor, so that a fast loop has the
//! form of a slow one. Where muscle or model are not of this kind the loop may be widened before
//! the operator instead ([`super::rate_dependent_width`]).
//!
//! # Both ways
//! The inverse knows y, so it knows g, and asks the bank for the input at these thresholds:
//! explicit and exact. (By the speed of the pressure it would have to run after its own answer:
//! what is wider asks for a faster pressure, which is wider.) The model does not know y. It looks
//! for the y that is the answer at the g that it asks for: the faster y moves the wider is the
//! bank, of which the answer moves less. Were the speed of a move against s counted too there would
//! be another, at which plays that are wide by the move of the direct term alone are kept by that
//! from following.
//!
//! # By the rate of the pressure
//! Rate-dependent operators are also described with thresholds by the rate of their input: rᵢ (1 +
//! k ρᵃ), ρ the size of the pressure's rate through the same filter (Al Janaideh, Rakheja and Su,
//! Mechatronics 19, 2009; there another function of the rate). With `pressure` the model is of that
//! kind: it knows the pressure, so it knows g. What is measured is never at rest, and a small rate
//! to a power below 1 is not small: so the pressure goes through a play of the sensor's noise
//! before. The inverse is not of that kind, for the reason above, and goes by h: k over the loop's
//! slope to the power of a is about the same. Forward of inverse is then near, and not exact.
//!
//! # Limits
//! For cascades ([`crate::cascade`]) of at most ten plays without negative weights.

use crate::convert;
use crate::error::{Check, ParameterError, Requirement};
use crate::model::Model;
use crate::real::Real;

use super::each;
use super::profile::{Profile, ProfileParameters};
use super::sliding::{Sliding, SlidingStep};

/// The largest g.
const WIDEST: f64 = 1e3;
/// The largest k, and the largest ρᵃ beside it: no pressure then leads out of the number type.
const LARGEST: f64 = 1e9;

/// Raw parameters of thresholds that depend on the rate.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(
    feature = "serde",
    derive(serde::Serialize, serde::Deserialize),
    serde(bound = "T: Real + serde::Serialize + serde::de::DeserializeOwned")
)]
pub struct RateDependentThresholdsParameters<T> {
    /// a. Unit: 1, above 0, at most 4.
    pub exponent: T,
    /// Time constant of the rate's filter. Unit: s, above 0.
    pub filter_s: T,
    /// h: by which part thresholds are wider at a rate of 1 output unit/s; nowhere below 0.
    /// Unit: 1.
    pub gain: ProfileParameters<T>,
    /// The rate of the pressure, if it is that which the model goes by; the inverse goes by h all
    /// the same.
    pub pressure: Option<PressureRateParameters<T>>,
}

/// Raw parameters of thresholds by the rate of the pressure.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct PressureRateParameters<T> {
    /// k: by which part thresholds are wider where the pressure moves by 1 input unit/s. Unit: 1,
    /// at least 0.
    pub gain: T,
    /// Radius of the play that the pressure goes through before its rate is taken: what it moves by
    /// unseen. Input unit, at least 0.
    pub resolution: T,
}

impl<T: Real> RateDependentThresholdsParameters<T> {
    pub(super) fn convert<U: Real>(&self) -> Result<RateDependentThresholdsParameters<U>, ParameterError> {
        Ok(RateDependentThresholdsParameters {
            exponent: convert::number(self.exponent),
            filter_s: convert::number(self.filter_s),
            gain: self.gain.convert()?,
            pressure: self.pressure.map(|PressureRateParameters { gain, resolution }| {
                PressureRateParameters {
                    gain: convert::number(gain),
                    resolution: convert::number(resolution),
                }
            }),
        })
    }
}

impl<T: Real> PressureRateParameters<T> {
    fn checked(&self) -> Result<Self, ParameterError> {
        let gain = Check::new("rate_dependent_thresholds pressure_gain", "");
        let resolution = Check::new("rate_dependent_thresholds resolution", "input unit");
        gain.at_least(gain.at_most(self.gain, T::from_f64(LARGEST))?, T::ZERO)?;
        resolution.at_least(resolution.finite(self.resolution)?, T::ZERO)?;
        Ok(*self)
    }
}

/// Validated thresholds that depend on the rate.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct RateDependentThresholds<T> {
    sliding: Sliding<T>,
    gain: Profile<T>,
    pressure: Option<PressureRateParameters<T>>,
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
            pressure: each(&parameters.pressure, PressureRateParameters::checked)?,
        })
    }

    /// For a step of `dt`; an endless one is a rest.
    pub(super) fn step(&self, dt: T) -> SlidingStep<T> {
        self.sliding.step(dt)
    }

    /// At a pressure, with ρ and the output of the play as they were at the sample before: ρ, that
    /// output, and g. None where the contraction's rate counts.
    pub(super) fn at_pressure(
        &self,
        step: &SlidingStep<T>,
        (rate, seen): (T, T),
        pressure: T,
    ) -> Option<(T, T, T)> {
        let PressureRateParameters { gain, resolution } = self.pressure?;
        let now = seen.limit(pressure - resolution, pressure + resolution);
        let rate = step.rate(rate, T::ONE, (now - seen).abs());
        let power = self.sliding.power(rate).at_most(T::from_f64(LARGEST));
        Some((rate, now, wider(gain * power)))
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
        wider(self.effect.gain.value(y) * self.effect.sliding.power(self.rate(moved)))
    }
}

/// g of so much.
#[inline(always)]
fn wider<T: Real>(by: T) -> T {
    (T::ONE + by).at_most(T::from_f64(WIDEST))
}
