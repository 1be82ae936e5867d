//! A measured quantity that moves the curve: the load that the muscle carries, or its temperature.
//!
//! h(y) (x - reference): bar for each newton or kelvin away from the reference, at the contraction
//! y.
//!
//! A value that is not measured is taken to be at its reference.

use crate::convert;
use crate::error::{Check, ParameterError};
use crate::real::Real;

use super::derivative::Affine;
use super::profile::{Profile, ProfileParameters};
use super::term::Term;

/// The farthest from its reference that a measured value is believed to be, in its unit.
const FARTHEST: f64 = 1e6;

/// Raw parameters of a schedule.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(
    feature = "serde",
    derive(serde::Serialize, serde::Deserialize),
    serde(bound = "T: Real + serde::Serialize + serde::de::DeserializeOwned")
)]
pub struct ScheduleParameters<T> {
    /// The value at which the model needs no correction. Unit: N, or °C.
    pub reference: T,
    /// What has to be added to the input, or behind the hysteresis to the output. Unit: that of
    /// either per N, or per K.
    pub offset: ProfileParameters<T>,
}

impl<T: Real> ScheduleParameters<T> {
    pub(super) fn convert<U: Real>(&self) -> Result<ScheduleParameters<U>, ParameterError> {
        Ok(ScheduleParameters { reference: convert::number(self.reference), offset: self.offset.convert()? })
    }
}

/// A validated schedule.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Schedule<T> {
    reference: T,
    offset: Profile<T>,
}

impl<T: Real> Schedule<T> {
    pub(super) fn try_new(
        parameters: &ScheduleParameters<T>,
        parameter: &'static str,
    ) -> Result<Self, ParameterError> {
        Ok(Self {
            reference: Check::new(parameter, "").finite(parameters.reference)?,
            offset: Profile::try_new(&parameters.offset, parameter, "")?,
        })
    }

    #[inline(always)]
    pub(super) fn term(&self, measured: T) -> Term<'_, T> {
        let constant = (measured - self.reference).limit(T::from_f64(-FARTHEST), T::from_f64(FARTHEST));
        Term { profile: &self.offset, driver: Affine { constant, gain: T::ZERO } }
    }
}
