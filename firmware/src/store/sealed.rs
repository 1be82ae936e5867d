//! A calibration as it is kept: under a checksum of its own.
//!
//! The checksum of a record ends where the record is read, and says nothing of which part is
//! damaged. This one goes with the calibration from the host that has written it, through the
//! memory and the flash, to the moment at which it is used: a line that has lost a bit would else
//! be off by as much as the limits of [`crate::scaling`] allow, and look like a working sensor's.

use serde::{Deserialize, Serialize};
use wire::Calibration;

/// A calibration under its checksum.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Sealed {
    calibration: Calibration,
    /// As in [`Calibration::checksum`].
    checksum: u32,
}

impl Sealed {
    /// A calibration under the checksum that has come with it; `None` where that is another's.
    pub fn under(calibration: Calibration, checksum: u32) -> Option<Self> {
        let sealed = Self { calibration, checksum };
        sealed.open().is_some().then_some(sealed)
    }

    /// A calibration that nothing has happened to yet.
    pub fn new(calibration: Calibration) -> Self {
        Self { calibration, checksum: calibration.checksum() }
    }

    /// The calibration; `None` where it is not the one that the checksum was made of.
    pub fn open(&self) -> Option<&Calibration> {
        (self.calibration.checksum() == self.checksum).then_some(&self.calibration)
    }
}
