//! Inertia: h(y) y'', with viscosity a second order that overshoots and rings.

use crate::error::ParameterError;
use crate::real::Real;

use super::derivative::Affine;
use super::profile::{Profile, ProfileParameters};
use super::term::Term;

/// A validated inertia.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Inertia<T> {
    inertia: Profile<T>,
}

impl<T: Real> Inertia<T> {
    /// Nowhere below 0, which no muscle could be simulated with.
    pub(super) fn try_new(inertia: &ProfileParameters<T>) -> Result<Self, ParameterError> {
        Ok(Self { inertia: Profile::try_positive(inertia, "inertia", "input unit s²/output unit")? })
    }

    #[inline(always)]
    pub(super) fn term(&self, acceleration: Affine<T>) -> Term<'_, T> {
        Term { profile: &self.inertia, driver: acceleration }
    }
}
