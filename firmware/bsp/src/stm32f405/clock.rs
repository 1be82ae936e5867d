//! Clocks: 168 MHz from the board's 8 MHz crystal, or 16 MHz from the internal oscillator when the
//! crystal or the multiplier does not start in time, or the supply is too low for 168 MHz. Which
//! one it became is part of [`Clocks`], and logged.
//!
//! A crystal that stops later is seen by the clock security: the internal oscillator takes over at
//! once, and the non-maskable interrupt comes. Without it the multiplier would run on at some lower
//! frequency, and all that measures time by it with it.

use stm32f4::stm32f405::{DBGMCU, FLASH, RCC};

/// Polls of a status bit before it is given up: at 16 MHz and at least 4 cycles a poll 25 ms or
/// more, where a crystal takes 2 ms and the multiplier 0.3 ms.
const POLLS: u32 = 100_000;

/// The first chips, whose flash does not bear prefetching (errata sheet ES0182, 2.1.4).
const REVISION_A: u16 = 0x1000;

/// The frequencies that the rest of the image needs.
#[derive(Clone, Copy, Debug, defmt::Format)]
pub struct Clocks {
    /// Where they come from.
    pub source: Source,
    /// The processor. Unit: Hz.
    pub core_hz: u32,
    /// APB1, which clocks USART2. Unit: Hz.
    pub slow_bus_hz: u32,
    /// APB2, which clocks the analogue inputs and USART1. Unit: Hz.
    pub fast_bus_hz: u32,
    /// TIM2 and TIM3. Unit: Hz.
    pub timer_hz: u32,
}

/// An oscillator.
#[derive(Clone, Copy, Debug, PartialEq, Eq, defmt::Format)]
pub enum Source {
    /// The crystal, multiplied to 168 MHz.
    Crystal,
    /// The internal oscillator of 16 MHz: the crystal or the multiplier did not start, or the
    /// supply is low.
    Internal,
}

const FAST: Clocks = Clocks {
    source: Source::Crystal,
    core_hz: 168_000_000,
    slow_bus_hz: 42_000_000,
    fast_bus_hz: 84_000_000,
    timer_hz: 84_000_000,
};
const FALL_BACK: Clocks = Clocks {
    source: Source::Internal,
    core_hz: 16_000_000,
    slow_bus_hz: 16_000_000,
    fast_bus_hz: 16_000_000,
    timer_hz: 16_000_000,
};

/// Clocks the peripherals that the image uses.
pub fn feed_peripherals(rcc: &RCC) {
    rcc.ahb1enr()
        .modify(|_, w| w.gpioaen().enabled().gpioben().enabled().gpiocen().enabled().dma2en().enabled());
    rcc.apb1enr().modify(|_, w| {
        w.dacen().enabled().pwren().enabled().usart2en().enabled();
        w.tim2en().enabled().tim3en().enabled()
    });
    rcc.apb2enr().modify(|_, w| w.adc1en().enabled().usart1en().enabled());
}

/// Keeps what a valve hangs on in reset: whatever is written to it has no effect.
pub fn hold_outputs(rcc: &RCC) {
    rcc.apb1rstr().modify(|_, w| w.dacrst().reset().tim3rst().reset());
}

/// Goes from the internal oscillator, which the processor starts with, to the crystal if it can.
/// `is_supplied`: whether the supply is high enough for 168 MHz with five wait states.
pub fn start(rcc: &RCC, flash: &FLASH, debug: &DBGMCU, is_supplied: bool) -> Clocks {
    let can_prefetch = debug.idcode().read().rev_id().bits() != REVISION_A;
    if is_supplied && to_crystal(rcc, flash, can_prefetch).is_some() {
        FAST
    } else {
        // What a step that did not succeed has left: buses undivided, and no clock but the internal
        // one.
        rcc.cfgr().reset();
        FALL_BACK
    }
}

/// `None` as soon as a step does not succeed in time; the processor then still runs from the
/// internal oscillator.
fn to_crystal(rcc: &RCC, flash: &FLASH, can_prefetch: bool) -> Option<()> {
    rcc.cr().modify(|_, w| w.hseon().on());
    within(|| rcc.cr().read().hserdy().is_ready())?;
    // 8 MHz / 8 * 336 / 2 = 168 MHz; the 48 MHz output is unused, but its divider has to be legal.
    // SAFETY: the factors are within the ranges of the reference manual (RM0090, 7.3.2).
    rcc.pllcfgr()
        .write(|w| unsafe { w.pllsrc().hse().pllm().bits(8).plln().bits(336).pllp().div2().pllq().bits(7) });
    rcc.cr().modify(|_, w| w.pllon().on());
    within(|| rcc.cr().read().pllrdy().is_ready())?;
    // The flash is slower than 168 MHz: five wait states at 3.3 V (RM0090, table 10), hidden by
    // prefetch and caches.
    flash.acr().write(|w| w.latency().ws5().prften().bit(can_prefetch).icen().enabled().dcen().enabled());
    within(|| flash.acr().read().latency().is_ws5())?;
    // APB1 at most 42 MHz, APB2 at most 84 MHz; a timer on a divided bus runs at twice the bus
    // clock. The dividers first: they act some cycles after they are written.
    rcc.cfgr().write(|w| w.ppre1().div4().ppre2().div2());
    rcc.cfgr().modify(|_, w| w.sw().pll());
    within(|| rcc.cfgr().read().sws().is_pll())?;
    rcc.cr().modify(|_, w| w.csson().on());
    Some(())
}

/// Whether a condition comes true in time.
pub fn within(condition: impl Fn() -> bool) -> Option<()> {
    (0..POLLS).any(|_| condition()).then_some(())
}
