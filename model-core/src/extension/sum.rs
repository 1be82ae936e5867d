//! A sum that loses nothing to rounding: many small terms on a large value, as time and travel at a
//! thousand samples a second are in `f32`. Kahan's compensation.

use crate::real::Real;

/// A sum and what rounding has kept from it.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub(super) struct Sum<T> {
    value: T,
    rest: T,
}

impl<T: Real> Sum<T> {
    pub(super) fn value(&self) -> T {
        self.value
    }

    #[inline(always)]
    pub(super) fn add(&mut self, term: T) {
        let term = term + self.rest;
        let sum = self.value + term;
        self.rest = term - (sum - self.value);
        self.value = sum;
    }
}
