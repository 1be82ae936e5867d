//! Layout 2, the one before the present: without the bus's parameters and a calibration.
//!
//! What it reads was written by boards that are not at hand any more. A test holds it to stored
//! bytes: should a part of it change, this becomes a frozen copy of what the part was.

use serde::Deserialize;
use wire::{BoardParameters, Protection};

use super::parameters::Parameters;

/// Number of the layout.
pub const LAYOUT: u16 = 2;

/// A set in layout 2.
#[derive(Deserialize)]
pub struct Previous {
    protection: Protection,
    tracking: Option<BoardParameters>,
}

impl From<Previous> for Parameters {
    /// The same parameters, reached as a new board is.
    fn from(Previous { protection, tracking }: Previous) -> Self {
        Self { protection, tracking, ..Self::FACTORY }
    }
}
