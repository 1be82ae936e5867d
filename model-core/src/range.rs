//! A closed interval with its limits in order.

use crate::error::{Check, ParameterError};
use crate::real::Real;

/// A closed interval, `min < max`, both finite. Unit: that of its use.
///
/// ```
/// use model_core::Range;
///
/// let limits = Range::try_new(0.0, 6.0, "command range", "bar")?;
/// assert_eq!([limits.limit(-1.0), limits.limit(7.0)], [0.0, 6.0]);
/// assert!(limits.contains(6.0) && !limits.contains(f64::NAN));
/// assert!(Range::try_new(6.0, 0.0, "command range", "bar").is_err());
/// # Ok::<(), Box<dyn core::error::Error>>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Range<T> {
    min: T,
    max: T,
}

impl<T: Real> Range<T> {
    /// # Errors
    /// Names `parameter` when a limit is not finite or `max` is not above `min`.
    pub fn try_new(
        min: T,
        max: T,
        parameter: &'static str,
        unit: &'static str,
    ) -> Result<Self, ParameterError> {
        let check = Check::new(parameter, unit);
        let min = check.finite(min)?;
        Ok(Self { min, max: check.above(max, min)? })
    }

    /// Lower limit.
    pub fn min(&self) -> T {
        self.min
    }

    /// Upper limit.
    pub fn max(&self) -> T {
        self.max
    }

    /// The limit in one direction.
    #[inline(always)]
    pub(crate) fn end<const RISING: bool>(&self) -> T {
        if RISING { self.max } else { self.min }
    }

    /// The value, or the limit that it passes.
    pub fn limit(&self, value: T) -> T {
        value.limit(self.min, self.max)
    }

    /// Where one step of at most `largest` (above 0) leads from a value inside toward another one,
    /// without leaving the range.
    #[inline(always)]
    pub(crate) fn step_toward(&self, from: T, to: T, largest: T) -> T {
        // Only the limits in the direction of the step can bind.
        if to > from {
            to.at_most(from + largest).at_most(self.max)
        } else {
            to.at_least(from - largest).at_least(self.min)
        }
    }

    /// The value, or where it passes the range by more than the range's span: beyond that nothing
    /// is extrapolated, so that no finite value leads out of the number type.
    pub fn extrapolated(&self, value: T) -> T {
        let span = self.max - self.min;
        value.limit(self.min - span, self.max + span)
    }

    /// Whether the value lies inside; a NaN does not.
    pub fn contains(&self, value: T) -> bool {
        value >= self.min && value <= self.max
    }
}
