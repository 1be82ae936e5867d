//! The layouts of the set of a board with one muscle.
//!
//! | layout | set |
//! |---|---|
//! | 2, 3, 4, 5, 6 | [`previous`] |
//! | 7 | [`Parameters`] |
//!
//! A change of [`Parameters`], or of anything in it, is a new layout: [`LAYOUT`] is raised, and the
//! struct as it was joins those before it.

use super::LoadError;
use super::parameters::Parameters;
use super::previous::{self, OfFirstOrder, Ratiometric, Unobserved, Unsealed, WithoutBus};
use super::set::{Set, whole};

/// Number of the layout that is written.
pub const LAYOUT: u16 = 7;

impl Set for Parameters {
    const LAYOUT: u16 = LAYOUT;
    const NEW: Self = Self::FACTORY;

    fn of_layout(layout: u16, bytes: &[u8]) -> Result<Self, LoadError> {
        match layout {
            LAYOUT => whole(bytes),
            previous::FIRST_ORDER => whole::<OfFirstOrder>(bytes).map(Self::from),
            previous::UNOBSERVED => whole::<Unobserved>(bytes).map(Self::from),
            previous::RATIOMETRIC => whole::<Ratiometric>(bytes).map(Self::from),
            previous::UNSEALED => whole::<Unsealed>(bytes).map(Self::from),
            previous::WITHOUT_BUS => whole::<WithoutBus>(bytes).map(Self::from),
            other => Err(LoadError::Layout(other)),
        }
    }
}
