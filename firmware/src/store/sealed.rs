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
    /// Of the lines and of the inputs, as in [`Calibration::checksum`] and
    /// [`wire::Inputs::checksum`].
    checksums: [u32; 2],
}

impl Sealed {
    /// A calibration under the checksum that has come with it; `None` where that is another's.
    pub fn under(calibration: Calibration, checksum: u32) -> Option<Self> {
        Some(Self::found(calibration, checksum)).filter(|sealed| sealed.open().is_some())
    }

    /// A calibration as it was found under a checksum of its lines, right or not.
    pub(super) fn found(calibration: Calibration, checksum: u32) -> Self {
        Self { calibration, checksums: [checksum, calibration.inputs.checksum()] }
    }

    /// A calibration that nothing has happened to yet.
    pub fn new(calibration: Calibration) -> Self {
        Self::found(calibration, calibration.checksum())
    }

    /// The calibration; `None` where it is not the one that the checksums were made of.
    pub fn open(&self) -> Option<&Calibration> {
        let Self { calibration, checksums } = self;
        ([calibration.checksum(), calibration.inputs.checksum()] == *checksums).then_some(calibration)
    }
}
