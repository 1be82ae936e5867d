//! Where panics, hard faults and unexpected interrupts end: interrupts off, the output safe, then
//! the image's own [`SafeEnd::end`], which is told what happened.
//!
//! # Limits
//! The image gets control after at most a few tens of instructions, whatever state the program is
//! in: the hard fault starts with a fresh stack, since the old one may be the cause.

use core::panic::PanicInfo;

use wire::Fault;

/// What an image does when its program cannot continue. [`crate::end_safely`] installs it.
pub trait SafeEnd {
    /// Vents, whatever state the program is in.
    fn make_safe();

    /// Ends the program. `detail`: the fault status, or the number of the interrupt.
    fn end(fault: Fault, detail: u32) -> !;
}

unsafe extern "C" {
    /// The lowest address of the stack, from memory.x.
    static _stack_end: u32;
}

/// Makes the output safe with the interrupts off.
fn stop<E: SafeEnd>() {
    cortex_m::interrupt::disable();
    E::make_safe();
}

/// Ends the program after a panic.
pub fn on_panic<E: SafeEnd>(info: &PanicInfo) -> ! {
    stop::<E>();
    defmt::error!("panic: {}", defmt::Display2Format(info));
    E::end(Fault::Panic, 0)
}

/// Ends the program after a hard fault. `stack`: the stack pointer at the fault.
pub extern "C" fn on_hard_fault<E: SafeEnd>(stack: u32) -> ! {
    stop::<E>();
    // SAFETY: reading the fault status has no side effect.
    let status = unsafe { (*cortex_m::peripheral::SCB::PTR).cfsr.read() };
    // What the processor saved on entry went below the stack if there was no room left.
    let has_overflown = (stack as usize) < &raw const _stack_end as usize;
    defmt::error!("hard fault, status {=u32:#010x}, stack {=u32:#010x}", status, stack);
    E::end(if has_overflown { Fault::StackOverflow } else { Fault::HardFault }, status)
}

/// Ends the program after an interrupt that no task expects.
pub fn on_interrupt<E: SafeEnd>(number: i16) -> ! {
    stop::<E>();
    defmt::error!("unexpected interrupt {=i16}", number);
    E::end(Fault::HardFault, number.cast_unsigned().into())
}

/// Makes panics, hard faults and unexpected interrupts of an image end by a [`SafeEnd`].
#[macro_export]
macro_rules! end_safely {
    ($ending:ty) => {
        #[panic_handler]
        fn panic(info: &core::panic::PanicInfo) -> ! {
            $crate::safe_end::on_panic::<$ending>(info)
        }

        /// Starts over at the top of the stack, and continues with the place where the stack was.
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
                "b {on_hard_fault}",
                on_hard_fault = sym $crate::safe_end::on_hard_fault::<$ending>,
            )
        }

        #[cortex_m_rt::exception]
        unsafe fn DefaultHandler(interrupt: i16) -> ! {
            $crate::safe_end::on_interrupt::<$ending>(interrupt)
        }
    };
}
