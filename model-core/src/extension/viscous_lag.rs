//! Viscosity: h(y) y', the contraction follows its static curve late.
//!
//! As an equivalent input the lag is the longer, the flatter the curve; behind the hysteresis it is
//! a first-order lag of the contraction.

use crate::error::ParameterError;
use crate::real::Real;

use super::derivative::Affine;
use super::profile::{Profile, ProfileParameters};
use super::term::Term;

/// A validated viscosity.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct ViscousLag<T> {
    viscosity: Profile<T>,
}

impl<T: Real> ViscousLag<T> {
    /// Nowhere below 0, which no muscle could be simulated with.
    pub(super) fn try_new(viscosity: &ProfileParameters<T>) -> Result<Self, ParameterError> {
        Ok(Self { viscosity: Profile::try_positive(viscosity, "viscous_lag", "input unit s/output unit")? })
    }

    #[inline(always)]
    pub(super) fn term(&self, velocity: Affine<T>) -> Term<'_, T> {
        Term { profile: &self.viscosity, driver: velocity }
    }
}
