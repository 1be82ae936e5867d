//! The flash of the parameter store: sectors 1 and 2 of 16 KB, between the starter and its log
//! (`memory.x`).
//!
//! # Limits
//! The sectors are erased together with the rest when a tool erases the whole chip. The emulator's
//! flash is read-only: there, nothing is kept.

use embedded_storage::nor_flash::{ErrorType, NorFlash, ReadNorFlash, check_erase, check_read, check_write};

use super::flash::{Flash, FlashError, WORD};

/// Number of the first sector.
const FIRST_SECTOR: usize = 1;
/// Unit: byte.
const SECTOR: usize = 16 * 1024;

unsafe extern "C" {
    /// Where the first sector begins, by the linker (`memory.x`).
    static _parameters_start: u8;
}

/// The address of an offset within the sectors.
fn address(offset: usize) -> usize {
    (&raw const _parameters_start) as usize + offset
}

impl ErrorType for Flash {
    type Error = FlashError;
}

impl ReadNorFlash for Flash {
    const READ_SIZE: usize = WORD;

    fn read(&mut self, offset: u32, bytes: &mut [u8]) -> Result<(), FlashError> {
        check_read(self, offset, bytes.len()).map_err(FlashError::Arguments)?;
        for (place, byte) in (address(offset as usize)..).zip(bytes) {
            // SAFETY: the address is within the sectors, which are flash and nobody's variables;
            // volatile, since they change behind the compiler's back.
            *byte = unsafe { (place as *const u8).read_volatile() };
        }
        Ok(())
    }

    fn capacity(&self) -> usize {
        2 * SECTOR
    }
}

impl NorFlash for Flash {
    const WRITE_SIZE: usize = WORD;
    const ERASE_SIZE: usize = SECTOR;

    fn erase(&mut self, from: u32, to: u32) -> Result<(), FlashError> {
        check_erase(self, from, to).map_err(FlashError::Arguments)?;
        let [from, to] = [from, to].map(|offset| offset as usize);
        let number = |offset: usize| (FIRST_SECTOR + offset / SECTOR) as u8;
        self.erase_sectors(number(from)..number(to), address(from)..address(to))
    }

    fn write(&mut self, offset: u32, bytes: &[u8]) -> Result<(), FlashError> {
        check_write(self, offset, bytes.len()).map_err(FlashError::Arguments)?;
        self.program(address(offset as usize), bytes)
    }
}
