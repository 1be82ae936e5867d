//! Where panics, hard faults and unexpected interrupts end: interrupts off, valve vented by raw register, a log
//! line, then the image's own `crate::end`.
//!
//! # Limits
//! The output is vented after at most a few tens of instructions, whatever state the program is in: the hard fault
//! starts with a fresh stack, since the old one may be the cause.

use core::panic::PanicInfo;

use cortex_m_rt::exception;
use stm32f4::stm32f405::DAC;

/// Takes the output from whatever drives it to the vented code.
fn make_safe() {
    cortex_m::interrupt::disable();
    // SAFETY: the program does not go on, so that nobody else owns the converter any more; the store is atomic.
    let converter = unsafe { &*DAC::ptr() };
    converter.dhr12r1().write(|w| w.daccdhr().set(firmware::scaling::VENT.0));
}

#[panic_handler]
fn panic(info: &PanicInfo) -> ! {
    make_safe();
    defmt::error!("panic: {}", defmt::Display2Format(info));
    crate::end()
}

/// Starts over at the top of the stack, and goes on in [`hard_fault`].
///
/// # Safety
/// Called by the processor only.
#[unsafe(naked)]
#[unsafe(export_name = "HardFault")]
unsafe extern "C" fn hard_fault_entry() -> ! {
    core::arch::naked_asm!(
        "ldr r0, =_stack_start",
        "msr msp, r0",
        "b {go_on}",
        go_on = sym hard_fault,
    )
}

extern "C" fn hard_fault() -> ! {
    make_safe();
    // SAFETY: reading the fault status has no side effect.
    let status = unsafe { (*cortex_m::peripheral::SCB::PTR).cfsr.read() };
    defmt::error!("hard fault, status {=u32:#010x}", status);
    crate::end()
}

#[exception]
unsafe fn DefaultHandler(interrupt: i16) -> ! {
    make_safe();
    defmt::error!("unexpected interrupt {=i16}", interrupt);
    crate::end()
}
