//! A supply that the valve's pressure never exceeds.
//!
//! The inverse commands no more than the supply, and remembers what that leads to: nothing winds
//! up.

use crate::convert;
use crate::error::{Check, ParameterError};
use crate::real::Real;

/// Raw parameters of a supply.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct SupplySaturationParameters<T> {
    /// The supply's pressure. Input unit, finite.
    pub supply: T,
}

impl<T: Real> SupplySaturationParameters<T> {
    pub(super) fn convert<U: Real>(&self) -> SupplySaturationParameters<U> {
        SupplySaturationParameters { supply: convert::number(self.supply) }
    }

    /// The highest set point of the valve. Input unit.
    pub(super) fn checked(&self) -> Result<T, ParameterError> {
        Check::new("supply_saturation supply", "input unit").finite(self.supply)
    }
}
