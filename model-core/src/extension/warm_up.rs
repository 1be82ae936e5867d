//! Warm-up: the first strokes need another pressure, and the difference wears off with the way that
//! the muscle has gone.
//!
//! h(y) exp(-travel/λ), travel being the sum of all moves before the present one.

use crate::convert;
use crate::error::{Check, ParameterError};
use crate::real::Real;

use super::derivative::Affine;
use super::profile::{Profile, ProfileParameters};
use super::term::Term;

/// Raw parameters of a warm-up.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(
    feature = "serde",
    derive(serde::Serialize, serde::Deserialize),
    serde(bound = "T: Real + serde::Serialize + serde::de::DeserializeOwned")
)]
pub struct WarmUpParameters<T> {
    /// λ: the travel after which 1/e is left. Output unit, above 0.
    pub travel: T,
    /// What has to be added to the input of a muscle that has not moved yet; behind the hysteresis
    /// to its output. Input unit, or output unit.
    pub offset: ProfileParameters<T>,
}

impl<T: Real> WarmUpParameters<T> {
    pub(super) fn convert<U: Real>(&self) -> Result<WarmUpParameters<U>, ParameterError> {
        Ok(WarmUpParameters { travel: convert::number(self.travel), offset: self.offset.convert()? })
    }
}

/// A validated warm-up.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct WarmUp<T> {
    per_travel: T,
    offset: Profile<T>,
}

impl<T: Real> WarmUp<T> {
    pub(super) fn try_new(parameters: &WarmUpParameters<T>) -> Result<Self, ParameterError> {
        let travel = Check::new("warm_up travel", "output unit").above(parameters.travel, T::ZERO)?;
        Ok(Self {
            per_travel: Check::new("1/(warm_up travel)", "1/output unit").finite(T::ONE / travel)?,
            offset: Profile::try_new(&parameters.offset, "warm_up offset", "input unit")?,
        })
    }

    #[inline(always)]
    pub(super) fn term(&self, travel: T) -> Term<'_, T> {
        let constant = (-travel * self.per_travel).exp();
        Term { profile: &self.offset, driver: Affine { constant, gain: T::ZERO } }
    }
}
