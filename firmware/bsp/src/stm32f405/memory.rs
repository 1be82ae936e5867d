//! The memory that a reset leaves alone, why the processor has started, and which one it is.
//!
//! The black box is written by the tick, and sealed by whatever ends the program; a program that
//! ends does not go on, so that no two of them ever work on it.

use core::mem::MaybeUninit;

use firmware::BlackBox;
use firmware::faults::black_box::Reset;
use firmware::identity::Identity;
use stm32f4::stm32f405::{DBGMCU, FLASH, RCC};
use wire::Fault;

/// Level of the brown-out reset in the option bytes (RM0090, 3.9.10): below 1.8 V only.
const BROWN_OUT_OFF: u8 = 3;

/// Where the processor's number stands (RM0090, 39.1), and the first word of the area that is
/// written once (3.9.9).
const UNIQUE_ID: *const u16 = 0x1FFF_7A10 as *const u16;
const WRITTEN_ONCE: *const u16 = 0x1FFF_7800 as *const u16;
/// What nobody has written yet.
const BLANK: u16 = u16::MAX;

// SAFETY: the section is one of memory.x, large enough, and used for nothing else.
#[unsafe(link_section = ".fault_record")]
static mut RECORD: MaybeUninit<BlackBox> = MaybeUninit::uninit();

/// The black box as the reset has left it, made ready to go on in. To be called once, at the start.
pub fn black_box(reset: Reset) -> &'static mut BlackBox {
    let record = &raw mut RECORD;
    // SAFETY: the words were written before the reset or are what power-on left there: the linker
    // does not know them, a volatile read takes them as they are, and any words make up a black
    // box. Nobody else has a reference yet.
    unsafe {
        let found = record.cast::<BlackBox>().read_volatile();
        (*record).write(BlackBox::after(reset, found))
    }
}

/// Seals the black box with what ends the program.
pub fn seal(fault: Fault, detail: u32) {
    // SAFETY: any words make up a black box; whoever has the other reference does not go on.
    unsafe { &mut *(&raw mut RECORD).cast::<BlackBox>() }.crash(fault, detail);
}

/// Whether the chip's option bytes leave the brown-out reset off, as they do when it is delivered:
/// below 2.7 V the program would then run on without anybody's knowing what it does.
pub fn lacks_brown_out_reset(flash: &FLASH) -> bool {
    brown_out_level(flash) == 0
}

/// The level of the brown-out reset in the option bytes: 0, off, to 3, below 2.7 V.
pub fn brown_out_level(flash: &FLASH) -> u8 {
    BROWN_OUT_OFF - flash.optcr().read().bor_lev().bits()
}

/// The number of the line of chips that this board has; an emulator tells none, and has nothing in
/// their memory.
pub const DEVICE: u16 = 0x413;

/// Which board it is.
pub fn identity(debug: &DBGMCU) -> Identity {
    let code = debug.idcode().read();
    if code.dev_id().bits() != DEVICE {
        return Identity::default();
    }
    // SAFETY: the addresses are in the system's memory of every chip of the line, aligned, and
    // nobody's variables.
    let word = |place: *const u16, offset: usize| unsafe { place.add(offset).read_volatile() };
    // The number of 96 bits stands there with its lowest word first.
    let unique_id = core::array::from_fn(|index| word(UNIQUE_ID, 5 - index));
    let revision = word(WRITTEN_ONCE, 0);
    Identity {
        unique_id,
        processor: code.bits(),
        hardware_revision: if revision == BLANK { 0 } else { revision },
    }
}

/// Why the processor has started; the next reset finds the flags cleared.
pub fn reset_cause(rcc: &RCC) -> Reset {
    let flags = rcc.csr().read();
    rcc.csr().modify(|_, w| w.rmvf().set_bit());
    // In this order: power-on sets the flag of low voltage too, and every reset that of the pin.
    if flags.porrstf().bit_is_set() {
        Reset::PowerOn
    } else if flags.borrstf().bit_is_set() {
        Reset::BrownOut
    } else if flags.wdgrstf().bit_is_set() || flags.wwdgrstf().bit_is_set() {
        Reset::Watchdog
    } else if flags.sftrstf().bit_is_set() {
        Reset::Software
    } else {
        Reset::Pin
    }
}
