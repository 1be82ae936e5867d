//! No envelope: γ(x) = x. The plays are then linear plays, as in the classical and the modified
//! model.

use crate::envelope::Envelope;
use crate::range::Range;
use crate::real::Real;

/// γ(x) = x.
///
/// ```
/// use model_core::envelope::{Envelope, Identity};
///
/// assert_eq!(Identity.inverse(Identity.value(2.5)), 2.5);
/// ```
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Identity;

impl<T: Real> Envelope<T> for Identity {
    fn value(&self, x: T) -> T {
        x
    }

    fn inverse(&self, v: T) -> T {
        v
    }

    fn least_slope(&self, _: &Range<T>) -> T {
        T::ONE
    }
}
