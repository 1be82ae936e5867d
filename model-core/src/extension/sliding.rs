//! The speed of sliding and its power, which a width that depends on the rate grows by: ρᵃ.
//!
//! ρ is the positive part of s times a speed, through a first-order filter; s, from -1 to 1, is the
//! direction of the friction.

use crate::error::{Check, ParameterError};
use crate::real::Real;

use super::relaxation;

/// The largest exponent of the rate.
const LARGEST_EXPONENT: f64 = 4.0;
/// Below this a rate counts as none. Unit: that of the rate.
const SLOWEST: f64 = 1e-9;

/// A validated filter and exponent.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Sliding<T> {
    exponent: T,
    filter_s: T,
}

/// What a step of time makes of the filter.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub(super) struct SlidingStep<T> {
    /// That it goes of its way.
    share: T,
    /// The same over the step's length. Unit: 1/s.
    share_per_second: T,
}

impl<T: Real> Sliding<T> {
    /// Each with its name for errors.
    pub(super) fn try_new(
        (exponent, a): (&'static str, T),
        (filter, filter_s): (&'static str, T),
    ) -> Result<Self, ParameterError> {
        let exponent = Check::new(exponent, "");
        exponent.above(a, T::ZERO)?;
        Ok(Self {
            exponent: exponent.at_most(a, T::from_f64(LARGEST_EXPONENT))?,
            filter_s: Check::new(filter, "s").above(filter_s, T::ZERO)?,
        })
    }

    /// For a step of `dt`; an endless one is a rest.
    pub(super) fn step(&self, dt: T) -> SlidingStep<T> {
        let share = relaxation::share(dt, self.filter_s);
        SlidingStep { share, share_per_second: share / dt }
    }

    /// A rate to the exponent, by the logarithm that the operator has anyway.
    #[inline(always)]
    pub(super) fn power(&self, rate: T) -> T {
        if rate < T::from_f64(SLOWEST) {
            return T::ZERO;
        }
        (T::from_f64(2.0) * self.exponent * T::atanh_of_ratio(rate, T::ONE)).exp()
    }
}

impl<T: Real> SlidingStep<T> {
    /// ρ after a way of `moved` where the friction's direction is `side`, and `rate` was ρ before.
    #[inline(always)]
    pub(super) fn rate(&self, rate: T, side: T, moved: T) -> T {
        let slid = (side * moved).at_least(T::ZERO);
        rate - rate * self.share + slid * self.share_per_second
    }
}
