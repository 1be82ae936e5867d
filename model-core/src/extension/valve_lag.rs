//! A valve whose pressure follows its set point as a first-order lag: p += (s - p)(1 - exp(-dt/T)),
//! exact for a set point that is held over the step.
//!
//! The inverse leads, s = p₋ + (p - p₋)/(1 - exp(-dt/T)), by at most `lead_limit`: a jump of the
//! reference would else ask for dt/T times as much pressure as there is.

use crate::convert;
use crate::error::{Check, ParameterError};
use crate::real::Real;

use super::relaxation;

/// The lead limit where nothing is known. Input unit (bar).
pub const LEAD_LIMIT: f64 = 2.0;

/// Raw parameters of a valve's lag.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct ValveLagParameters<T> {
    /// T. Unit: s, above 0.
    pub time_constant_s: T,
    /// How far the inverse's set point may be from the pressure, see [`LEAD_LIMIT`]. Input unit,
    /// above 0.
    pub lead_limit: T,
}

impl<T: Real> ValveLagParameters<T> {
    /// With the usual lead limit. `time_constant_s`: s, above 0.
    pub fn new(time_constant_s: T) -> Self {
        Self { time_constant_s, lead_limit: T::from_f64(LEAD_LIMIT) }
    }

    pub(super) fn convert<U: Real>(&self) -> ValveLagParameters<U> {
        ValveLagParameters {
            time_constant_s: convert::number(self.time_constant_s),
            lead_limit: convert::number(self.lead_limit),
        }
    }
}

/// A validated lag.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct ValveLag<T> {
    time_constant_s: T,
    lead_limit: T,
}

/// What a step of time makes of it.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub(crate) struct ValveLagStep<T> {
    share: T,
    per_share: T,
    lead_limit: T,
}

impl<T: Real> ValveLag<T> {
    pub(crate) fn try_new(parameters: &ValveLagParameters<T>) -> Result<Self, ParameterError> {
        let ValveLagParameters { time_constant_s, lead_limit } = *parameters;
        Ok(Self {
            time_constant_s: Check::new("valve_lag time_constant_s", "s").above(time_constant_s, T::ZERO)?,
            lead_limit: Check::new("valve_lag lead_limit", "input unit").above(lead_limit, T::ZERO)?,
        })
    }

    pub(crate) fn step(&self, dt: T) -> ValveLagStep<T> {
        let share = relaxation::share(dt, self.time_constant_s);
        ValveLagStep { share, per_share: T::ONE / share, lead_limit: self.lead_limit }
    }
}

impl<T: Real> ValveLagStep<T> {
    /// The pressure after the step.
    #[inline(always)]
    pub(crate) fn pressure(&self, from: T, set_point: T) -> T {
        from + (set_point - from) * self.share
    }

    /// The set point that leads to the wanted pressure, or as near as the lead limit allows.
    #[inline(always)]
    pub(crate) fn set_point(&self, from: T, wanted: T) -> T {
        from + ((wanted - from) * self.per_share).limit(-self.lead_limit, self.lead_limit)
    }
}
