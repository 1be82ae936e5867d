//! The flash: erasing and programming, by its registers.
//!
//! # Timing
//! At 2.7 V and more, 32 bits at a time, a word takes 16 µs to program (at most 0.1 ms), a sector
//! of 16 KB 0.25 s to erase (at most 0.5 s), one of 128 KB 1 s (at most 2 s; DS8626, "Flash memory
//! programming"). Whoever fetches from the flash meanwhile waits, which is the whole program: ticks
//! are late, the watchdog is not fed. So it is changed while the valve is vented only.
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
//! | file | what it makes of it |
//! |---|---|
//! | `parameter_flash.rs` | the sectors of the parameter store |
//! | `image_flash.rs` | the places of the images, and their log |

use core::ops::Range;

use embedded_storage::nor_flash::{NorFlashError, NorFlashErrorKind};
use stm32f4::stm32f405::FLASH;

use super::pins::is_supply_low;

/// Opens the control register (RM0090, 3.6.1).
const KEYS: [u32; 2] = [0x4567_0123, 0xCDEF_89AB];
/// What is programmed at a time. Unit: byte.
pub(super) const WORD: usize = 4;
/// Polls before an operation is given up: an erasure takes at most 336 million core cycles, a poll
/// at least 4.
const POLLS: u32 = 84_000_000;

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

/// The flash, by way of its registers.
pub struct Flash {
    registers: FLASH,
}

impl Flash {
    /// Whoever has the registers has the flash.
    pub fn new(registers: FLASH) -> Self {
        Self { registers }
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

    /// Erases sectors that are next to each other, and lie at these addresses.
    pub(super) fn erase_sectors(
        &mut self,
        mut numbers: Range<u8>,
        addresses: Range<usize>,
    ) -> Result<(), FlashError> {
        let done = self.change(|flash| numbers.try_for_each(|number| flash.erase_sector(number)));
        self.forget_cached();
        done?;
        // SAFETY: the addresses are those of the sectors, aligned; volatile, since they change
        // behind the compiler's back.
        let is_blank = |address| unsafe { (address as *const u32).read_volatile() } == !0;
        if addresses.step_by(WORD).all(is_blank) { Ok(()) } else { Err(FlashError::NotErased) }
    }

    fn erase_sector(&self, number: u8) -> Result<(), FlashError> {
        // SAFETY: the number is that of a sector, by the caller.
        self.registers
            .cr()
            .write(|w| unsafe { w.lock().unlocked().ser().set_bit().snb().bits(number).psize().psize32() });
        self.registers.cr().modify(|_, w| w.strt().start());
        self.finish()
    }

    /// Programs whole words, from an address of the flash on.
    pub(super) fn program(&mut self, address: usize, bytes: &[u8]) -> Result<(), FlashError> {
        self.change(|flash| {
            flash.registers.cr().write(|w| w.lock().unlocked().pg().program().psize().psize32());
            (address..).step_by(WORD).zip(bytes.as_chunks().0).try_for_each(|(address, &word)| {
                // SAFETY: a whole word of the flash, aligned, by the caller; the flash is open for
                // it.
                unsafe { (address as *mut u32).write_volatile(u32::from_le_bytes(word)) };
                cortex_m::asm::dsb();
                flash.finish()
            })
        })
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
