//! The places of the images in the flash, and the log of the starter: sectors 4 to 7, 8 to 11,
//! and 3 (`memory.x`).

use core::slice::from_raw_parts;

use crc::{CRC_32_ISO_HDLC, Crc, Table};
use firmware::update::{Failure, Images};
use wire::image::Place;

use super::flash::{Flash, FlashError, WORD};

/// By sixteen bytes at a time: a third of a megabyte in some 25 ms, 0.3 s on the internal
/// oscillator.
const CRC: Crc<u32, Table<16>> = Crc::<u32, Table<16>>::new(&CRC_32_ISO_HDLC);
/// Number of the first sector of A, and of B.
const FIRST_SECTORS: [u8; 2] = [4, 8];
/// Number of the log's sector.
pub(super) const LOG_SECTOR: u8 = 3;
/// Words of the log.
const LOG_WORDS: usize = 16 * 1024 / WORD;

unsafe extern "C" {
    /// Where the image begins that runs, by cortex-m-rt's linker script.
    static __vector_table: u8;
    /// Where the log begins, by memory.x.
    static _start_log: u32;
}

/// The place whose image this is.
pub fn running() -> Place {
    let begin = (&raw const __vector_table) as u32;
    if begin == Place::B.begin() { Place::B } else { Place::A }
}

/// What stands in a place.
pub fn read(place: Place) -> &'static [u8] {
    // SAFETY: it is flash, and nobody's variables. It changes by the drivers only, by volatile
    // stores, while nobody holds it.
    unsafe { from_raw_parts(place.begin() as *const u8, place.bytes() as usize) }
}

/// The words of the log.
pub fn log() -> &'static [u32] {
    // SAFETY: as above.
    unsafe { from_raw_parts(&raw const _start_log, LOG_WORDS) }
}

impl From<FlashError> for Failure {
    fn from(_: FlashError) -> Self {
        Self
    }
}

impl Images for Flash {
    fn running(&self) -> Place {
        running()
    }

    fn read(&self, place: Place) -> &[u8] {
        read(place)
    }

    fn log(&self) -> &[u32] {
        log()
    }

    fn erase(&mut self, sector: usize) -> Result<(), Failure> {
        let place = running().other();
        let ends = place.sectors();
        let end = *ends.get(sector).ok_or(Failure)?;
        let begin = sector.checked_sub(1).and_then(|before| ends.get(before)).copied().unwrap_or(0);
        let [first_of_a, first_of_b] = FIRST_SECTORS;
        let first = if place == Place::A { first_of_a } else { first_of_b };
        let number = first + sector as u8;
        let address = |offset: u32| (place.begin() + offset) as usize;
        Ok(self.erase_sectors(number..number + 1, address(begin)..address(end))?)
    }

    fn program(&mut self, offset: u32, bytes: &[u8]) -> Result<(), Failure> {
        let place = running().other();
        let is_within = offset as usize + bytes.len() <= place.bytes() as usize;
        if !is_within || !(offset as usize).is_multiple_of(WORD) {
            return Err(Failure);
        }
        Ok(Self::program(self, (place.begin() + offset) as usize, bytes)?)
    }

    fn program_log(&mut self, index: usize, word: u32) -> Result<(), Failure> {
        program_log(self, index, word)
    }

    fn checksum(&self, show: impl FnOnce(&mut dyn FnMut(&[u8]))) -> u32 {
        let mut digest = CRC.digest();
        show(&mut |bytes| digest.update(bytes));
        digest.finalize()
    }

    fn alone<R>(&self, work: impl FnOnce(&Self) -> R) -> R {
        cortex_m::interrupt::free(|_| work(self))
    }

    fn restart(&mut self) {
        cortex_m::peripheral::SCB::sys_reset()
    }
}

/// Programs the word of the log with this number.
///
/// # Errors
/// The log has no such word, or the flash refuses.
pub fn program_log(flash: &mut Flash, index: usize, word: u32) -> Result<(), Failure> {
    let place = log().get(index).ok_or(Failure)?;
    Ok(flash.program((&raw const *place) as usize, &word.to_le_bytes())?)
}
