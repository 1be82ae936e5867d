//! The clock of the control: the processor's SysTick, each millisecond.
//!
//! It also tells how long a tick has taken: its counter runs down from one tick to the next.

use core::sync::atomic::{AtomicU32, Ordering};

use cortex_m::peripheral::syst::SystClkSource;
use cortex_m::peripheral::{SCB, SYST};
use firmware::TickClock;
use firmware::timing::TickEnd;

/// Unit: Hz. The controller's `period_s` has to agree with it.
pub const TICKS_PER_SECOND: u32 = 1_000;

/// In the processor's register of handlers: SysTick's is at work.
const SYSTICK_ACTIVE: u32 = 1 << 11;

/// Ticks that have ended.
static TICKS: AtomicU32 = AtomicU32::new(0);
static CYCLES_PER_US: AtomicU32 = AtomicU32::new(1);

/// The running clock.
pub struct Tick {
    registers: SYST,
    period_cycles: u32,
}

impl Tick {
    /// Starts it; the first tick comes after a period. `core_hz`: the processor's clock.
    pub fn start(mut registers: SYST, core_hz: u32) -> Self {
        let period_cycles = core_hz / TICKS_PER_SECOND;
        CYCLES_PER_US.store(core_hz / 1_000_000, Ordering::Relaxed);
        registers.set_clock_source(SystClkSource::Core);
        registers.set_reload(period_cycles - 1);
        registers.clear_current();
        registers.enable_interrupt();
        registers.enable_counter();
        Self { registers, period_cycles }
    }

    /// To be called last in a tick.
    pub fn finish(&self) {
        TICKS.store(TICKS.load(Ordering::Relaxed).wrapping_add(1), Ordering::Relaxed);
    }

    /// What the control has to know of it. The valve has to be written in the first half of the
    /// period.
    pub fn clock(&self) -> TickClock {
        TickClock { period_s: 1.0 / TICKS_PER_SECOND as f32, deadline_cycles: self.period_cycles / 2 }
    }

    /// How long the tick has taken until now.
    pub fn end(&self) -> TickEnd {
        // In this order: a counter that wraps between the two is then taken for a tick that has
        // ended just in time.
        let left = self.registers.cvr.read();
        let is_overrun = SCB::is_pendst_pending();
        let elapsed = self.period_cycles - 1 - left.min(self.period_cycles - 1);
        TickEnd {
            elapsed_cycles: if is_overrun { elapsed + self.period_cycles } else { elapsed },
            is_overrun,
        }
    }
}

/// Time since the start, on a clock that wraps after 71 minutes, whatever interrupt or lock is at
/// work; one that comes behind a tick's last instructions sees it a period late. Unit: µs.
pub fn moment_us() -> u32 {
    let ticks = TICKS.load(Ordering::Relaxed);
    let moment = moment_behind(ticks);
    match TICKS.load(Ordering::Relaxed) {
        same if same == ticks => moment,
        // A tick has interrupted the caller; the next one is far.
        other => moment_behind(other),
    }
}

/// The same, where so many ticks have ended.
fn moment_behind(ticks: u32) -> u32 {
    // SAFETY: reading the counter has no side effect.
    let left = || unsafe { (*SYST::PTR).cvr.read() };
    // SAFETY: neither has reading which handlers are at work.
    let is_in_tick = unsafe { (*SCB::PTR).shcsr.read() } & SYSTICK_ACTIVE != 0;
    let before = left();
    // A tick that is due may have to wait.
    let (begun, left) = match (is_in_tick, SCB::is_pendst_pending()) {
        (true, _) => (1, before),
        (false, true) => (1, left()),
        (false, false) => (0, before),
    };
    let period_us = 1_000_000 / TICKS_PER_SECOND;
    let elapsed_us = period_us.saturating_sub(left / CYCLES_PER_US.load(Ordering::Relaxed).max(1));
    ticks.wrapping_add(begun).wrapping_mul(period_us).wrapping_add(elapsed_us)
}
