//! The parameters that a board keeps without power: a set ([`Parameters`] of one muscle,
//! [`JointParameters`] of a joint) in two sectors of NOR flash.
//!
//! # Design
//! Each sector is a log of records (`sequential-storage`, CRC-32 over each); a record is a whole
//! set with a sequence number and the version of its layout, which tells the kind of board, too
//! ([`Set`]). The newest readable record is the board's set. If it was written by another kind of
//! board, the board starts without a set.
//!
//! | save | what is done |
//! |---|---|
//! | nothing has changed | nothing is written |
//! | the sector of the newest record has room | the record is appended there |
//! | else | the *other* sector is erased, and the record is its first |
//!
//! So the newest record is never in a sector that is being erased, and no word of it is written
//! again: whatever a loss of power leaves of the new record, or of the other sector, the old set
//! stays as it was until the new one is complete and its CRC right. A record that does not read
//! back is written again in the other sector.
//!
//! # Contract
//! * [`ParameterStore::save`] writes in vented states only and refuses in all others, since
//!   programming and erasing stop the processor: 16 µs a word, up to 0.5 s for a sector of 16 KB. A
//!   watchdog's period has to be longer.
//! * [`ParameterStore::load`] reads the present layout and those before it. Saving what was loaded
//!   brings an older layout up to date.
//! * A calibration has a checksum of its own ([`Sealed`]), which is looked at where it is used.
//! * Nothing panics or allocates, whatever stands in the flash; reading and writing take time
//!   bounded by its size.
//!
//! # Limits
//! A bit that ages and a record that was broken off look alike: the set before is then the newest
//! readable one. Marginal bits, which read differently each time, are seen only when they are read
//! wrong. Endurance: a sector of 16 KB holds more than 20 records of the largest model, and lasts
//! 10,000 erasures: 400,000 changes.

mod blocking;
mod joint_parameters;
mod layouts;
mod parameters;
mod previous;
mod record;
mod sealed;
mod sectors;
mod set;

use core::marker::PhantomData;

use embedded_storage::nor_flash::{NorFlash, NorFlashErrorKind};
use wire::Fault;

pub use joint_parameters::{JOINT_LAYOUT, JointParameters};
pub use layouts::LAYOUT;
pub use parameters::Parameters;
pub use record::RECORD_BYTES;
pub use sealed::{Lines, Sealed};
pub use set::{BoardState, Set};

use record::Record;
use sectors::{Failure, Sector, Sectors};

/// Why there is no set to be read; the board then has that of a new one ([`Set::NEW`]) and a fault
/// to report.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum LoadError {
    /// The newest set has a layout that this firmware does not know: a later one, or that of
    /// another kind of board ([`Set`]).
    Layout(u16),
    /// Something was stored, and nothing of it is readable.
    Corrupt,
    /// The flash cannot be read.
    Flash(NorFlashErrorKind),
}

/// Why a set was not saved; the old one is still there.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum SaveError {
    /// A valve is not vented.
    Driven,
    /// A parameter is not a number: no controller takes such a set.
    NotANumber,
    /// The set is longer than a record may be.
    TooLong,
    /// The flash cannot be erased or written.
    Flash(NorFlashErrorKind),
    /// What was written does not read back: the flash is worn out.
    NotKept,
    /// The firmware is on trial: the one before may not be able to read what this one writes.
    OnTrial,
}

/// The store of sets of a kind, in a flash whose first two sectors are its own.
#[derive(Debug)]
pub struct ParameterStore<F, P> {
    sectors: Sectors<F>,
    buffer: [u8; RECORD_BYTES],
    of: PhantomData<P>,
}

/// A record and the sector that it stands in.
struct Found<P> {
    record: Record<P>,
    sector: Sector,
}

impl<F: NorFlash, P: Set> ParameterStore<F, P> {
    /// The store in this flash, which is neither read nor written yet.
    pub const fn new(flash: F) -> Self {
        Self { sectors: Sectors::new(flash), buffer: [0; RECORD_BYTES], of: PhantomData }
    }

    /// The flash.
    pub fn flash(&self) -> &F {
        self.sectors.flash()
    }

    /// The flash, to be changed beyond the sectors of the store.
    pub fn flash_mut(&mut self) -> &mut F {
        self.sectors.flash_mut()
    }

    /// The flash, given back.
    pub fn into_flash(self) -> F {
        self.sectors.into_flash()
    }

    /// The newest set, [`Set::NEW`] if none was ever stored.
    ///
    /// # Errors
    /// Something was stored, but there is no set of it to be had.
    pub fn load(&mut self) -> Result<P, LoadError> {
        self.newest()?.map_or(Ok(P::NEW), |found| found.record.parameters)
    }

    /// Keeps a set. `state`: the board's, in which it stays meanwhile.
    ///
    /// # Errors
    /// The state is not vented; the set is not valid; the flash fails. The old set is then still
    /// the newest; after a failure of the flash the new one may be.
    pub fn save(&mut self, state: impl BoardState, parameters: &P) -> Result<(), SaveError> {
        if state.is_driven() {
            return Err(SaveError::Driven);
        }
        // What was written is compared with what it should be.
        if !parameters.eq(parameters) {
            return Err(SaveError::NotANumber);
        }
        match self.newest() {
            Ok(Some(Found { record, .. })) if record.holds(parameters) => Ok(()),
            Ok(Some(Found { record, sector })) => self
                .append(sector, record.next_sequence(), parameters)
                .or_else(|_| self.begin(Sector::First, parameters)),
            // What cannot be read is replaced.
            Ok(None) | Err(_) => {
                self.begin(Sector::First, parameters).or_else(|_| self.begin(Sector::Second, parameters))
            }
        }
    }

    /// Erases the sector without the newest record (`sector`, where no record is stored) and makes
    /// the set its first record.
    fn begin(&mut self, sector: Sector, parameters: &P) -> Result<(), SaveError> {
        let (sector, sequence) = match self.newest() {
            Ok(Some(Found { record, sector })) => (sector.other(), record.next_sequence()),
            Ok(None) | Err(_) => (sector, 0),
        };
        self.sectors.erase(sector)?;
        self.append(sector, sequence, parameters)
    }

    /// Appends the set, and makes sure that it is the newest.
    fn append(&mut self, sector: Sector, sequence: u32, parameters: &P) -> Result<(), SaveError> {
        let bytes = record::encode(sequence, parameters, &mut self.buffer).ok_or(SaveError::TooLong)?;
        self.sectors.append(sector, bytes)?;
        // Its number is above all that were found in the other sector.
        let kept = self.newest_in(&[sector]).0.is_some_and(|found| found.record.holds(parameters));
        if kept { Ok(()) } else { Err(SaveError::NotKept) }
    }

    /// The newest record, `None` in a blank flash.
    fn newest(&mut self) -> Result<Option<Found<P>>, LoadError> {
        match self.newest_in(&Sector::BOTH) {
            (Some(found), _) => Ok(Some(found)),
            (None, Some(Failure::Flash(kind))) => Err(LoadError::Flash(kind)),
            (None, None) if self.sectors.are_blank()? => Ok(None),
            (None, _) => Err(LoadError::Corrupt),
        }
    }

    /// The newest record of these sectors, if there is one, and what has kept others from being
    /// read.
    fn newest_in(&mut self, sectors: &[Sector]) -> (Option<Found<P>>, Option<Failure>) {
        let mut newest: Option<(u32, Sector)> = None;
        let mut failure = None;
        for &sector in sectors {
            let read = self.sectors.for_each(sector, &mut self.buffer, |bytes| {
                if let Some(sequence) = record::sequence(bytes)
                    && newest.is_none_or(|(highest, _)| sequence > highest)
                {
                    newest = Some((sequence, sector));
                }
            });
            failure = failure.or(read.err());
        }
        let found = newest.and_then(|(sequence, sector)| self.found(sequence, sector));
        (found, failure)
    }

    /// The record with a number. Only it is decoded: with all that are in the way, a full store
    /// would take the board half a second.
    fn found(&mut self, sequence: u32, sector: Sector) -> Option<Found<P>> {
        let mut found = None;
        // What cannot be read is behind it.
        let _ = self.sectors.for_each(sector, &mut self.buffer, |bytes| {
            if found.is_none() && record::sequence(bytes) == Some(sequence) {
                found = record::decode(bytes).map(|record| Found { record, sector });
            }
        });
        found
    }
}

impl LoadError {
    /// What the board reports.
    pub fn fault(self) -> Fault {
        match self {
            Self::Layout(_) => Fault::ConfigurationVersion,
            Self::Corrupt | Self::Flash(_) => Fault::ConfigurationCorrupt,
        }
    }
}

impl From<Failure> for SaveError {
    fn from(failure: Failure) -> Self {
        match failure {
            Failure::Flash(kind) => Self::Flash(kind),
            Failure::TooLong => Self::TooLong,
            Failure::Full | Failure::Damaged => Self::NotKept,
        }
    }
}
