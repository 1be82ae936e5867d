//! Two sectors, each a log of records: `sequential-storage`'s queue of one page.

use embedded_storage::nor_flash::{NorFlash, NorFlashError, NorFlashErrorKind};
use sequential_storage::Error;
use sequential_storage::cache::{Cache, Uncached};
use sequential_storage::queue::{QueueConfig, QueueStorage};

use super::LoadError;
use super::blocking::{Blocking, ready};

/// One of the two.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Sector {
    /// At the beginning of the flash.
    First,
    /// The next.
    Second,
}

impl Sector {
    /// In the order in which they are read.
    pub const BOTH: [Self; 2] = [Self::First, Self::Second];

    /// The one that this is not.
    pub fn other(self) -> Self {
        match self {
            Self::First => Self::Second,
            Self::Second => Self::First,
        }
    }
}

/// Why a sector does not do what it should.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Failure {
    /// The sector has no room for the record.
    Full,
    /// No sector has room for the record.
    TooLong,
    /// The contents are not a log.
    Damaged,
    /// The flash does not read, write or erase.
    Flash(NorFlashErrorKind),
}

/// The flash.
#[derive(Debug)]
pub struct Sectors<F>(F);

type Log<'a, F> = QueueStorage<Blocking<'a, F>, Cache<Uncached, Uncached, Uncached>>;

/// How much is read at a time to see whether a sector is blank. Unit: byte.
const CHUNK: usize = 64;

impl<F: NorFlash> Sectors<F> {
    pub const fn new(flash: F) -> Self {
        Self(flash)
    }

    pub fn flash(&self) -> &F {
        &self.0
    }

    pub fn flash_mut(&mut self) -> &mut F {
        &mut self.0
    }

    pub fn into_flash(self) -> F {
        self.0
    }

    /// Shows every readable record of a sector, the oldest first, up to the last one, or to one
    /// that is longer than the buffer.
    pub fn for_each(
        &mut self,
        sector: Sector,
        buffer: &mut [u8],
        mut show: impl FnMut(&[u8]),
    ) -> Result<(), Failure> {
        let mut log = log(Blocking::to_read(&mut self.0), sector);
        let reading = async {
            let mut records = log.iter().await?;
            // At most as often as records fit in a sector.
            while let Some(record) = records.next(buffer).await? {
                show(&record);
            }
            Ok(())
        };
        finish(reading)
    }

    /// Writes a record after the others of a sector.
    pub fn append(&mut self, sector: Sector, record: &[u8]) -> Result<(), Failure> {
        finish(log(Blocking::to_change(&mut self.0), sector).push(record, false))
    }

    /// Erases a sector.
    pub fn erase(&mut self, sector: Sector) -> Result<(), Failure> {
        finish(log(Blocking::to_change(&mut self.0), sector).erase_all())
    }

    /// Whether nothing was ever written to either sector.
    pub fn are_blank(&mut self) -> Result<bool, LoadError> {
        let mut bytes = [0; CHUNK];
        for address in (0..2 * F::ERASE_SIZE as u32).step_by(CHUNK) {
            self.0.read(address, &mut bytes).map_err(|error| LoadError::Flash(error.kind()))?;
            if bytes != [0xFF; CHUNK] {
                return Ok(false);
            }
        }
        Ok(true)
    }
}

fn log<F: NorFlash>(flash: Blocking<'_, F>, sector: Sector) -> Log<'_, F> {
    let config = match sector {
        Sector::First => const { QueueConfig::new(0..F::ERASE_SIZE as u32) },
        Sector::Second => const { QueueConfig::new(F::ERASE_SIZE as u32..2 * F::ERASE_SIZE as u32) },
    };
    QueueStorage::new(flash, config, Cache::new_uncached())
}

/// The outcome of work on a log.
fn finish<E: NorFlashError>(work: impl Future<Output = Result<(), Error<E>>>) -> Result<(), Failure> {
    ready(work).ok_or(Failure::Damaged)?.map_err(|error| match error {
        Error::FullStorage => Failure::Full,
        Error::ItemTooBig => Failure::TooLong,
        Error::Storage { value } => Failure::Flash(value.kind()),
        _ => Failure::Damaged,
    })
}
