//! The tick as the board runs it, whole: samples, monitors, controller, output, record, timing. The image is only linked,
//! never run, and shows one thing: in whatever state the control is, and whatever the converter reads, a tick cannot panic,
//! when nothing of the panic machinery is linked.
#![no_std]
#![no_main]

use core::hint::black_box;
use core::panic::PanicInfo;

use firmware::timing::TickEnd;
use firmware::{AcquisitionError, Board, Control, DacCode, Samples};
// The table of interrupts that the linker asks for.
use stm32f4::stm32f405 as _;

/// A board of which the compiler knows nothing.
struct Unknown;

impl Board for Unknown {
    fn read(&mut self) -> Result<Samples, AcquisitionError> {
        black_box(Err(AcquisitionError))
    }

    fn drive(&mut self, code: DacCode) {
        black_box(code);
    }
}

#[cortex_m_rt::entry]
fn main() -> ! {
    // SAFETY: none, but nobody runs it. An address that the compiler does not know stands for a control in any state.
    let control: &mut Control = unsafe { &mut *(black_box(0x2001_0000_usize) as *mut Control) };
    loop {
        control.tick(&mut Unknown);
        control.close_tick(black_box(TickEnd { elapsed_cycles: 0, is_overrun: false }));
        #[cfg(feature = "deliberate_panic")]
        black_box([0])[black_box(1_usize)];
    }
}

/// Recognisable in the linked image, under whatever name the compiler gives the handler.
#[panic_handler]
fn panic(_: &PanicInfo) -> ! {
    panicked()
}

#[inline(never)]
fn panicked() -> ! {
    loop {
        cortex_m::asm::udf();
    }
}
