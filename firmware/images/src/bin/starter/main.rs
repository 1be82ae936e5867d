//! The starter: what the processor begins with, in sector 0, and what is never written over the
//! bus. It starts the image that the log says (`firmware::update`), from one of two places.
//!
//! # Safety
//! It runs on the internal oscillator, with all interrupts off, and leaves everything as a reset
//! does, but for the vector table's place, the voltage detector, and, for a trial, the watchdog:
//! both outputs stay off. An image that is tried is looked at before, and its try is in the log
//! before it begins: one that hangs at once is ended by the watchdog, and is tried three times at
//! most.
//!
//! # Limits
//! It does not look at the checksum of an image that is there to stay: that image does so itself,
//! in each start.
#![no_std]
#![no_main]

use core::panic::PanicInfo;

use bsp::stm32f405::flash::Flash;
use bsp::stm32f405::image_flash::{log, program_log, read};
use bsp::stm32f405::pins::VoltageDetector;
use bsp::stm32f405::watchdog::HardwareWatchdog;
use cortex_m_rt::entry;
use crc::{CRC_32_ISO_HDLC, Crc};
use firmware::update::log::{Entry, Log};
use stm32f4::stm32f405::Peripherals;
use wire::image::{Head, Place};

const CRC: Crc<u32> = Crc::<u32>::new(&CRC_32_ISO_HDLC);
/// The SRAM, in which every image has its stack.
const RAM: core::ops::RangeInclusive<u32> = 0x2000_0000..=0x2002_0000;

#[entry]
fn main() -> ! {
    let log = Log::of(log());
    let place =
        log.to_try().filter(|place| is_whole(*place) && begin_trial(log.used)).unwrap_or(log.for_good);
    // Where nothing stands, as on a board of which a part only was flashed, the other may.
    start(if is_there(place) { place } else { place.other() })
}

/// Writes down that an image is tried, and starts the watchdog for it; whether both are done.
fn begin_trial(index: usize) -> bool {
    let Some(device) = Peripherals::take() else { return false };
    device.RCC.apb1enr().modify(|_, w| w.pwren().enabled());
    let is_supplied = VoltageDetector::watch(&device.PWR);
    let done = is_supplied && program_log(&mut Flash::new(device.FLASH), index, Entry::Tried.word()).is_ok();
    if done {
        HardwareWatchdog::start(device.IWDG, &device.DBGMCU);
    }
    done
}

/// Whether the checksum of the image in a place fits.
fn is_whole(place: Place) -> bool {
    let memory = read(place);
    Head::of(memory).is_some_and(|head| {
        let mut digest = CRC.digest();
        let shown = head.for_each(memory, place.begin(), |bytes| digest.update(bytes));
        shown.is_some() && digest.finalize() == head.checksum
    })
}

/// Whether an image may stand in a place: a stack in the memory, a beginning in the place.
fn is_there(place: Place) -> bool {
    let word = |index: usize| read(place).get(4 * index..).and_then(|bytes| bytes.first_chunk());
    let [stack, begin] = [0, 1].map(|index| word(index).map_or(0, |bytes| u32::from_le_bytes(*bytes)));
    RAM.contains(&stack) && begin.wrapping_sub(place.begin()) < place.bytes()
}

/// Goes on with the image in a place, as the processor does with the one that stands first.
fn start(place: Place) -> ! {
    // SAFETY: nothing of this program is needed any more; no interrupt is on.
    unsafe {
        (*cortex_m::peripheral::SCB::PTR).vtor.write(place.begin());
        cortex_m::asm::bootload(place.begin() as *const u32)
    }
}

/// Nothing here panics; were it to, the next reset begins again.
#[panic_handler]
fn panic(_: &PanicInfo) -> ! {
    cortex_m::peripheral::SCB::sys_reset()
}
