//! The flash of the parameter store: sectors 1 and 2 of 16 KB, between the vector table and the
//! code (`memory.x`).
//!
//! # Timing
//! At 2.7 V and more, 32 bits at a time, a word takes 16 µs to program (at most 0.1 ms) and a
//! sector 0.25 s to erase (at most 0.5 s; DS8626, "Flash memory programming"). Whoever fetches from
//! the flash meanwhile waits, which is the whole program: ticks are late, the watchdog is not fed.
//! So the store writes while the valve is vented only.
//!
//! # Contract
//! Every wait is bounded; what the flash refuses is an error, and so is a sector that is not blank
//! behind its erasure. The flash is locked but during a change, so that a program gone astray
//! cannot write. After an erasure the data cache is emptied, which would still hold the old
//! contents (RM0090, 3.5.4).
//!
//! The control register's value at a reset has LOCK set, and so has whatever `write` puts there:
//! each write of it says what LOCK becomes.
//!
//! # Limits
//! The sectors are erased together with the rest when a tool erases the whole chip. The emulator's
//! flash is read-only: there, nothing is kept.

use core::ops::Range;

use embedded_storage::nor_flash::{
    ErrorType, NorFlash, NorFlashError, NorFlashErrorKind, ReadNorFlash, check_erase, check_read, check_write,
};
use stm32f4::stm32f405::FLASH;

use super::pins::is_supply_low;

/// Opens the control register (RM0090, 3.6.1).
const KEYS: [u32; 2] = [0x4567_0123, 0xCDEF_89AB];
/// Number of the first sector.
const FIRST_SECTOR: usize = 1;
/// Unit: byte.
const SECTOR: usize = 16 * 1024;
/// What is programmed at a time. Unit: byte.
const WORD: usize = 4;
/// Polls before an operation is given up: an erasure takes at most 84 million core cycles, a poll
/// at least 4.
const POLLS: u32 = 42_000_000;

unsafe extern "C" {
    /// Where the first sector begins, by the linker (`memory.x`).
    static _parameters_start: u8;
}

/// Why the flash did not do what it was asked to.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum FlashError {
    /// An address or a length is outside the sectors or within a word.
    Arguments(NorFlashErrorKind),
    /// It is busy for longer than any operation takes.
    TimeOut,
    /// It is protected, or refuses the keys or the sequence of operations.
    Rejected,
    /// A sector is not blank behind its erasure.
    NotErased,
    /// The supply is too low for 32 bits at a time.
    LowVoltage,
}

impl NorFlashError for FlashError {
    fn kind(&self) -> NorFlashErrorKind {
        match self {
            Self::Arguments(kind) => *kind,
            Self::TimeOut | Self::Rejected | Self::NotErased | Self::LowVoltage => NorFlashErrorKind::Other,
        }
    }
}

/// The two sectors, from address 0 on.
pub struct ParameterFlash {
    registers: FLASH,
}

impl ParameterFlash {
    /// The sectors, by way of the flash's registers.
    pub fn new(registers: FLASH) -> Self {
        Self { registers }
    }

    /// The place of an address within the sectors.
    fn place(address: u32) -> *mut u8 {
        (&raw const _parameters_start).cast_mut().wrapping_add(address as usize)
    }

    /// Waits until nothing is being done.
    fn wait(&self) -> Result<(), FlashError> {
        let is_idle = (0..POLLS).any(|_| self.registers.sr().read().bsy().is_not_busy());
        if is_idle { Ok(()) } else { Err(FlashError::TimeOut) }
    }

    /// Waits for the end of an operation, and how it went.
    fn finish(&self) -> Result<(), FlashError> {
        self.wait()?;
        let status = self.registers.sr().read();
        let failed = status.operr().bit()
            || status.wrperr().bit()
            || status.pgaerr().bit()
            || status.pgperr().bit()
            || status.pgserr().bit();
        if failed { Err(FlashError::Rejected) } else { Ok(()) }
    }

    /// Does work on the open flash, and locks it again.
    fn change(&mut self, work: impl FnOnce(&Self) -> Result<(), FlashError>) -> Result<(), FlashError> {
        if is_supply_low() {
            return Err(FlashError::LowVoltage);
        }
        self.wait()?;
        // SAFETY: ones clear the marks of errors that were; other bits are without effect.
        self.registers.sr().write(|w| unsafe { w.bits(0xF3) });
        self.open()?;
        let done = work(self);
        // A register that is written while the flash is busy would stop the processor until it is
        // not.
        if done != Err(FlashError::TimeOut) {
            self.registers.cr().write(|w| w.lock().locked());
        }
        done
    }

    /// Opens the control register. Keys for an open one would lock it until the next reset (RM0090,
    /// 3.6.1).
    fn open(&self) -> Result<(), FlashError> {
        if self.registers.cr().read().lock().is_locked() {
            KEYS.iter().for_each(|&key| {
                self.registers.keyr().write(|w| w.key().set(key));
            });
        }
        if self.registers.cr().read().lock().is_locked() { Err(FlashError::Rejected) } else { Ok(()) }
    }

    /// Erases a sector of the store.
    fn erase_sector(&self, sector: usize) -> Result<(), FlashError> {
        let number = (FIRST_SECTOR + sector) as u8;
        // SAFETY: the number is that of one of the store's sectors, by the check of the caller.
        self.registers
            .cr()
            .write(|w| unsafe { w.lock().unlocked().ser().set_bit().snb().bits(number).psize().psize32() });
        self.registers.cr().modify(|_, w| w.strt().start());
        self.finish()
    }

    /// Whether addresses hold nothing.
    fn is_blank(addresses: Range<u32>) -> bool {
        // SAFETY: the addresses are within the sectors, and aligned, by the check of the caller;
        // volatile, as in `read`.
        addresses
            .step_by(WORD)
            .all(|address| unsafe { Self::place(address).cast::<u32>().read_volatile() } == !0)
    }

    /// Empties the data cache.
    fn forget_cached(&mut self) {
        let control = self.registers.acr();
        control.modify(|_, w| w.dcen().disabled());
        control.modify(|_, w| w.dcrst().reset());
        control.modify(|_, w| w.dcrst().no_reset());
        control.modify(|_, w| w.dcen().enabled());
    }
}

impl ErrorType for ParameterFlash {
    type Error = FlashError;
}

impl ReadNorFlash for ParameterFlash {
    const READ_SIZE: usize = WORD;

    fn read(&mut self, offset: u32, bytes: &mut [u8]) -> Result<(), FlashError> {
        check_read(self, offset, bytes.len()).map_err(FlashError::Arguments)?;
        for (address, byte) in (offset..).zip(bytes) {
            // SAFETY: the address is within the sectors, which are flash and nobody's variables;
            // volatile, since they change behind the compiler's back.
            *byte = unsafe { Self::place(address).read_volatile() };
        }
        Ok(())
    }

    fn capacity(&self) -> usize {
        2 * SECTOR
    }
}

impl NorFlash for ParameterFlash {
    const WRITE_SIZE: usize = WORD;
    const ERASE_SIZE: usize = SECTOR;

    fn erase(&mut self, from: u32, to: u32) -> Result<(), FlashError> {
        check_erase(self, from, to).map_err(FlashError::Arguments)?;
        let mut sectors = from as usize / SECTOR..to as usize / SECTOR;
        let done = self.change(|flash| sectors.try_for_each(|sector| flash.erase_sector(sector)));
        self.forget_cached();
        done?;
        if Self::is_blank(from..to) { Ok(()) } else { Err(FlashError::NotErased) }
    }

    fn write(&mut self, offset: u32, bytes: &[u8]) -> Result<(), FlashError> {
        check_write(self, offset, bytes.len()).map_err(FlashError::Arguments)?;
        self.change(|flash| {
            flash.registers.cr().write(|w| w.lock().unlocked().pg().program().psize().psize32());
            (offset..).step_by(WORD).zip(bytes.as_chunks().0).try_for_each(|(address, &word)| {
                // SAFETY: a whole word within the sectors, aligned, both by the check above; the
                // flash is open for it.
                unsafe { Self::place(address).cast::<u32>().write_volatile(u32::from_le_bytes(word)) };
                cortex_m::asm::dsb();
                flash.finish()
            })
        })
    }
}
