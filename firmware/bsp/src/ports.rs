//! Link and bus wait until the start-up has given its stack back.
//!
//! RTIC lets interrupts come while the stack still holds all that `init` made. A tick fits on top
//! of that; a host's configuration does not, if it arrives at that moment. So the tasks of priority
//! 1 are masked from `init` to the idle task.

use cortex_m::register::basepri;
use stm32f4::stm32f405::NVIC_PRIO_BITS;

/// RTIC's priority 1, and all below, as the processor counts: the greatest number that its bits can
/// hold.
const LOWEST: u8 = !0 << (8 - NVIC_PRIO_BITS);

/// Keeps the ports' interrupts waiting. For `init`.
pub fn hold() {
    // SAFETY: it masks more than RTIC expects, never less: no lock can be broken.
    unsafe { basepri::write(LOWEST) };
}

/// Lets them come. For the idle task, which holds no lock and masks nothing.
pub fn release() {
    // SAFETY: the idle task has priority 0, for which RTIC's mask is 0.
    unsafe { basepri::write(0) };
}
