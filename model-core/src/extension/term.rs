//! One effect on the balance of forces at one sample.

use super::derivative::Affine;
use super::profile::Profile;

/// An effect at a sample: a profile times what drives it.
#[derive(Clone, Copy, Debug)]
pub(super) struct Term<'a, T> {
    pub(super) profile: &'a Profile<T>,
    pub(super) driver: Affine<T>,
}
