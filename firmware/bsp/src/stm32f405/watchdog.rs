//! The hardware watchdog, IWDG, on its own oscillator of some 32 kHz (17 to 47 kHz, data sheet
//! DS8626, table 35).
//!
//! While the valve is driven it waits 50 ms (34 to 94 ms). While vented it waits 4 s, since erasing
//! a sector of the flash stops the processor for up to 0.5 s, and of the largest for 2.6 s.

use stm32f4::stm32f405::{DBGMCU, IWDG};

/// At one count a millisecond.
const DRIVEN: u16 = 50;
const VENTED: u16 = 4000;

/// The running watchdog.
pub struct HardwareWatchdog {
    registers: IWDG,
    reload: u16,
}

impl HardwareWatchdog {
    /// Starts it; nothing stops it any more, a debugger that halts the processor neither: the valve
    /// would stay as it is. With the feature `debug` it waits with the processor. Pulses wait in
    /// any case.
    pub fn start(registers: IWDG, debug: &DBGMCU) -> Self {
        // Said both ways: what a debugger has set stays until power is lost.
        debug
            .apb1_fz()
            .modify(|_, w| w.dbg_iwdg_stop().bit(cfg!(feature = "debug")).dbg_tim3_stop().set_bit());
        registers.kr().write(|w| w.key().start());
        registers.kr().write(|w| w.key().unlock());
        registers.pr().write(|w| w.pr().divide_by32());
        registers.rlr().write(|w| w.rl().set(VENTED));
        Self { registers, reload: VENTED }
    }

    /// Feeds it, to wait as long as the state of the valve allows.
    pub fn feed(&mut self, is_driven: bool) {
        let reload = if is_driven { DRIVEN } else { VENTED };
        // An update takes some of its own clocks; until it is over the next one would be lost, and
        // is left to a later tick.
        if reload != self.reload && self.registers.sr().read().rvu().bit_is_clear() {
            self.registers.kr().write(|w| w.key().unlock());
            self.registers.rlr().write(|w| w.rl().set(reload));
            self.reload = reload;
        }
        self.registers.kr().write(|w| w.key().feed());
    }
}
