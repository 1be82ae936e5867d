//! What a kind of board keeps, as far as the store has to know it.
//!
//! # Layouts
//! Each record carries the number of its layout. The high byte tells the kind of board that it is
//! of, the low one counts: so no set of one kind is ever read as one of another, by a firmware that
//! knows the other kind or by one that does not.
//!
//! | high byte | board |
//! |---|---|
//! | 0 | with one muscle ([`super::Parameters`]) |
//! | 1 | with a joint ([`super::JointParameters`]) |

use core::fmt::Debug;

use serde::Serialize;
use serde::de::DeserializeOwned;
use wire::State;
use wire::joint::JointBoardState;

use super::LoadError;

/// A set of parameters, kept as a whole. Raw: validated each time that it is taken.
pub trait Set: Clone + Debug + PartialEq + Serialize {
    /// Number of the layout that is written.
    const LAYOUT: u16;
    /// The set of a new board.
    const NEW: Self;

    /// The set of a layout.
    ///
    /// # Errors
    /// Its bytes are damaged, or this firmware does not know its layout.
    fn of_layout(layout: u16, bytes: &[u8]) -> Result<Self, LoadError>;
}

/// The value that the bytes are, none left over.
pub(super) fn whole<T: DeserializeOwned>(bytes: &[u8]) -> Result<T, LoadError> {
    match postcard::take_from_bytes(bytes) {
        Ok((value, [])) => Ok(value),
        _ => Err(LoadError::Corrupt),
    }
}

/// The state of a board, in which it stays while a set is saved.
pub trait BoardState: Copy {
    /// Whether a valve may be open.
    fn is_driven(self) -> bool;
}

impl BoardState for State {
    fn is_driven(self) -> bool {
        Self::is_driven(self)
    }
}

impl BoardState for JointBoardState {
    fn is_driven(self) -> bool {
        Self::is_driven(self)
    }
}
