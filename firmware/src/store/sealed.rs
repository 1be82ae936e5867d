//! A calibration as it is kept: under a checksum of its own.
//!
//! The checksum of a record ends where the record is read, and says nothing of which part is
//! damaged. This one goes with the calibration from the host that has written it, through the
//! memory and the flash, to the moment at which it is used: a line that has lost a bit would else
//! be off by as much as the limits of [`crate::scaling`] allow, and look like a working sensor's.

use core::fmt::Debug;

use serde::de::DeserializeOwned;
use serde::{Deserialize, Serialize};
use wire::joint::JointCalibration;
use wire::{Calibration, fingerprint};

/// A calibration that can be sealed.
pub trait Lines: Copy {
    /// Its checksums.
    type Checksums: Copy + Debug + PartialEq + Serialize + DeserializeOwned;

    /// Those of what it is now.
    fn checksums(&self) -> Self::Checksums;
}

impl Lines for Calibration {
    /// Of the lines and of the inputs, as in [`Calibration::checksum`] and
    /// [`wire::Inputs::checksum`].
    type Checksums = [u32; 2];

    fn checksums(&self) -> [u32; 2] {
        [self.checksum(), self.inputs.checksum()]
    }
}

impl Lines for JointCalibration {
    type Checksums = u32;

    fn checksums(&self) -> u32 {
        fingerprint(self)
    }
}

/// A calibration under its checksum.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Sealed<C: Lines = Calibration> {
    calibration: C,
    checksums: C::Checksums,
}

impl<C: Lines> Sealed<C> {
    /// A calibration that nothing has happened to yet.
    pub fn new(calibration: C) -> Self {
        Self { calibration, checksums: calibration.checksums() }
    }

    /// The calibration; `None` where it is not the one that the checksums were made of.
    pub fn open(&self) -> Option<&C> {
        let Self { calibration, checksums } = self;
        (calibration.checksums() == *checksums).then_some(calibration)
    }
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
}
