//! A first-order lag: p += (s - p)(1 - exp(-dt/T)), exact for a set point that is held over the
//! step.
//!
//! The inverse leads, s = p₋ + (p - p₋)/(1 - exp(-dt/T)).

use crate::extension::relaxation;
use crate::real::Real;

/// What a step of time makes of it.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub(crate) struct FirstOrderStep<T> {
    share: T,
    per_share: T,
    lead_limit: T,
}

impl<T: Real> FirstOrderStep<T> {
    /// `time_constant_s`, `dt`: s.
    pub(crate) fn new(time_constant_s: T, lead_limit: T, dt: T) -> Self {
        let share = relaxation::share(dt, time_constant_s);
        Self { share, per_share: T::ONE / share, lead_limit }
    }

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
