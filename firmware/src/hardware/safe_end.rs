//! Where panics, hard faults and unexpected interrupts end: interrupts off, then the image's own
//! `crate::end`, which is told what happened.
//!
//! # Limits
//! The image gets control after at most a few tens of instructions, whatever state the program is
//! in: the hard fault starts with a fresh stack, since the old one may be the cause.

use core::panic::PanicInfo;

use cortex_m_rt::exception;
use wire::Fault;

unsafe extern "C" {
    /// The lowest address of the stack, from memory.x.
    static _stack_end: u32;
}

#[panic_handler]
fn panic(info: &PanicInfo) -> ! {
    cortex_m::interrupt::disable();
    crate::make_safe();
    defmt::error!("panic: {}", defmt::Display2Format(info));
    crate::end(Fault::Panic, 0)
}

/// Starts over at the top of the stack, and goes on in [`hard_fault`] with the place where the
/// stack was.
///
/// # Safety
/// Called by the processor only.
#[unsafe(naked)]
#[unsafe(export_name = "HardFault")]
unsafe extern "C" fn hard_fault_entry() -> ! {
    core::arch::naked_asm!(
        "mrs r0, msp",
        "ldr r1, =_stack_start",
        "msr msp, r1",
        "b {go_on}",
        go_on = sym hard_fault,
    )
}

extern "C" fn hard_fault(stack: u32) -> ! {
    cortex_m::interrupt::disable();
    crate::make_safe();
    // SAFETY: reading the fault status has no side effect.
    let status = unsafe { (*cortex_m::peripheral::SCB::PTR).cfsr.read() };
    // What the processor saved on entry went below the stack if there was no room left.
    let has_overflown = (stack as usize) < &raw const _stack_end as usize;
    defmt::error!("hard fault, status {=u32:#010x}, stack {=u32:#010x}", status, stack);
    crate::end(if has_overflown { Fault::StackOverflow } else { Fault::HardFault }, status)
}

#[exception]
unsafe fn DefaultHandler(interrupt: i16) -> ! {
    cortex_m::interrupt::disable();
    crate::make_safe();
    defmt::error!("unexpected interrupt {=i16}", interrupt);
    crate::end(Fault::HardFault, interrupt.cast_unsigned().into())
}
