//! Moments in microseconds: TIM5, which counts them through all 32 bits, whatever interrupt or lock is at work.

use stm32f4::stm32f405::TIM5;

/// Starts it, clocked by `timer_hz`.
pub fn start(timer: &TIM5, timer_hz: u32) {
    timer.psc().write(|w| w.psc().set((timer_hz / 1_000_000 - 1) as u16));
    // The prescaler acts from an update on.
    timer.egr().write(|w| w.ug().update());
    timer.cr1().write(|w| w.cen().enabled());
}

/// The moment, on a clock that wraps after 71 minutes. Unit: µs.
pub fn moment_us() -> u32 {
    // SAFETY: reading the counter has no side effect.
    unsafe { &*TIM5::ptr() }.cnt().read().cnt().bits()
}
