//! The clock of the control: the processor's SysTick, each millisecond.
//!
//! It also tells how long a tick has taken: its counter runs down from one tick to the next.

use cortex_m::peripheral::syst::SystClkSource;
use cortex_m::peripheral::{SCB, SYST};
use firmware::TickClock;
use firmware::timing::TickEnd;

/// Unit: Hz. The controller's `period_s` has to agree with it.
pub const TICKS_PER_SECOND: u32 = 1_000;

/// The running clock.
pub struct Tick {
    registers: SYST,
    period_cycles: u32,
}

impl Tick {
    /// Starts it; the first tick comes after a period. `core_hz`: the processor's clock.
    pub fn start(mut registers: SYST, core_hz: u32) -> Self {
        let period_cycles = core_hz / TICKS_PER_SECOND;
        registers.set_clock_source(SystClkSource::Core);
        registers.set_reload(period_cycles - 1);
        registers.clear_current();
        registers.enable_interrupt();
        registers.enable_counter();
        Self { registers, period_cycles }
    }

    /// What the control has to know of it. The valve has to be written in the first half of the period.
    pub fn clock(&self) -> TickClock {
        TickClock { period_s: 1.0 / TICKS_PER_SECOND as f32, deadline_cycles: self.period_cycles / 2 }
    }

    /// How long the tick has taken until now.
    pub fn end(&self) -> TickEnd {
        // In this order: a counter that wraps between the two is then taken for a tick that has ended just in time.
        let left = self.registers.cvr.read();
        let is_overrun = SCB::is_pendst_pending();
        let elapsed = self.period_cycles - 1 - left.min(self.period_cycles - 1);
        TickEnd {
            elapsed_cycles: if is_overrun { elapsed + self.period_cycles } else { elapsed },
            is_overrun,
        }
    }
}
