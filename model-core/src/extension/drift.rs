//! A zero that moves steadily with time.

use crate::convert;
use crate::error::{Check, ParameterError};
use crate::real::Real;

/// Raw parameters of a drift.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct DriftParameters<T> {
    /// How fast. Unit: output unit/s.
    pub rate_per_s: T,
    /// Whether the inverse takes it off; else it is left to feedback. A drift that was seen once
    /// need not go on.
    pub compensated: bool,
}

impl<T: Real> DriftParameters<T> {
    pub(super) fn convert<U: Real>(&self) -> DriftParameters<U> {
        DriftParameters { rate_per_s: convert::number(self.rate_per_s), compensated: self.compensated }
    }

    /// The rate.
    pub(super) fn checked(&self) -> Result<T, ParameterError> {
        Check::new("drift rate_per_s", "output unit/s").finite(self.rate_per_s)
    }
}
