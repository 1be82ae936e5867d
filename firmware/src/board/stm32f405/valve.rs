//! The safe value of the valve's output, by raw registers.
//!
//! Both outputs of the board take it, whichever is used, since what hangs on them is not known.

use firmware::scaling::VENT;
use stm32f4::stm32f405::{DAC, TIM3};

/// Vents, whoever owns the output. The converter has to be clocked.
pub fn vent() {
    // SAFETY: each store is atomic, and puts out what every owner may put out at any time.
    let (converter, pulses) = unsafe { (&*DAC::ptr(), &*TIM3::ptr()) };
    converter.dhr12r1().write(|w| w.daccdhr().set(VENT.0));
    pulses.ccr1().write(|w| w.ccr().set(VENT.0));
}

// Before anything else, even variables: clocks the converter, and takes the output from floating to the vented code, which
// its register holds after a reset. In the processor's own language, since Rust's needs its variables.
core::arch::global_asm!(
    ".section .text.__pre_init, \"ax\"",
    ".global __pre_init",
    ".type __pre_init, %function",
    ".thumb_func",
    "__pre_init:",
    // APB1ENR of the RCC: DACEN.
    "ldr r0, =0x40023840",
    "ldr r1, [r0]",
    "orr r1, r1, #0x20000000",
    "str r1, [r0]",
    // The clock needs two cycles.
    "ldr r1, [r0]",
    // The DAC: DHR12R1, then EN1 of CR.
    "ldr r0, =0x40007400",
    "movs r1, #0",
    "str r1, [r0, #8]",
    "movs r1, #1",
    "str r1, [r0]",
    "bx lr",
    ".size __pre_init, . - __pre_init",
);
