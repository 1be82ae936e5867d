//! The clock of the control: TIM2 raises its interrupt each millisecond.

use stm32f4::stm32f405::TIM2;

/// The period of the control. Unit: Hz. The controller's `period_s` has to agree with it.
const TICKS_PER_SECOND: u32 = 1_000;

/// The running timer.
pub struct TickTimer {
    registers: TIM2,
}

impl TickTimer {
    /// Starts the timer, which is clocked with `clock_hz`; the first interrupt comes after a period.
    pub fn start(registers: TIM2, clock_hz: u32) -> Self {
        registers.arr().write(|w| w.arr().set(clock_hz / TICKS_PER_SECOND - 1));
        registers.dier().write(|w| w.uie().enabled());
        registers.cr1().write(|w| w.cen().enabled());
        Self { registers }
    }

    /// Ends the interrupt.
    pub fn acknowledge(&mut self) {
        // The bits of the register are cleared by zeros and kept by ones.
        self.registers.sr().modify(|_, w| w.uif().clear());
    }

    /// Whether another tick is due.
    pub fn is_due(&self) -> bool {
        self.registers.sr().read().uif().is_update_pending()
    }
}
