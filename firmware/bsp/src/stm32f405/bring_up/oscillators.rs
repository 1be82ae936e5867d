//! The oscillators against each other, by timers that capture the edges of one while they count
//! those of the other (RM0090, 7.2.11).

use stm32f4::stm32f405::{RCC, TIM5, TIM11};

use crate::stm32f405::clock::within;

/// The internal oscillator. Unit: Hz.
const INTERNAL_HZ: f32 = 16_000_000.0;
/// Of the crystal's clock before it is captured, the most that there is.
const CRYSTAL_DIVIDER: u8 = 31;
/// Of what is captured: each eighth edge.
const EDGES: u32 = 8;
/// Captures of the crystal: 3.1 ms, a count in 50,000, within the 16 bits of its timer.
const CRYSTAL_CAPTURES: u32 = 100;
/// Captures of the watchdog's oscillator: some 10 ms.
const SLOW_CAPTURES: u32 = 40;

/// The crystal's frequency, by the internal oscillator; none if it does not start. To be called
/// while the processor runs from the latter, behind a reset. Unit: Hz.
pub fn crystal_hz(rcc: &RCC, timer: &TIM11) -> Option<f32> {
    rcc.apb2enr().modify(|_, w| w.tim11en().enabled());
    rcc.cr().modify(|_, w| w.hseon().on());
    within(|| rcc.cr().read().hserdy().is_ready())?;
    rcc.cfgr().modify(|_, w| w.rtcpre().set(CRYSTAL_DIVIDER));
    // SAFETY: 2 connects the crystal's divided clock (RM0090, 19.5.11).
    timer.or().write(|w| unsafe { w.rmp().bits(2) });
    timer.ccmr1_input().write(|w| w.cc1s().ti1().ic1psc().set(3));
    timer.ccer().write(|w| w.cc1e().set_bit());
    timer.cr1().write(|w| w.cen().enabled());
    let capture = || {
        within(|| timer.sr().read().cc1if().bit_is_set())?;
        Some(timer.ccr1().read().ccr().bits())
    };
    let first = capture();
    let last = (0..CRYSTAL_CAPTURES).try_fold(0, |_, _| capture());
    let is_lost = timer.sr().read().cc1of().bit_is_set();
    timer.cr1().reset();
    rcc.cfgr().modify(|_, w| w.rtcpre().set(0));
    let counts = f32::from(last?.wrapping_sub(first?));
    let edges = (CRYSTAL_CAPTURES * EDGES * u32::from(CRYSTAL_DIVIDER)) as f32;
    (!is_lost).then_some(edges * INTERNAL_HZ / counts)
}

/// A clock that counts at the rate of the timers, and wraps after 51 s or more.
pub struct Stopwatch {
    timer: TIM5,
    timer_hz: f32,
}

impl Stopwatch {
    /// Starts it.
    pub fn start(rcc: &RCC, timer: TIM5, timer_hz: u32) -> Self {
        rcc.apb1enr().modify(|_, w| w.tim5en().enabled());
        timer.cr1().write(|w| w.cen().enabled());
        Self { timer, timer_hz: timer_hz as f32 }
    }

    /// Where it stands. Unit: count.
    pub fn now(&self) -> u32 {
        self.timer.cnt().read().bits()
    }

    /// The time since a count. Unit: s.
    pub fn seconds_since(&self, count: u32) -> f32 {
        self.now().wrapping_sub(count) as f32 / self.timer_hz
    }

    /// The frequency of the watchdog's oscillator, by this clock; none if it does not start. Unit:
    /// Hz.
    pub fn watchdog_hz(&self, rcc: &RCC) -> Option<f32> {
        let timer = &self.timer;
        rcc.csr().modify(|_, w| w.lsion().on());
        within(|| rcc.csr().read().lsirdy().is_ready())?;
        // SAFETY: 1 connects that oscillator (RM0090, 18.4.20).
        timer.or().write(|w| unsafe { w.it4_rmp().bits(1) });
        timer.ccmr2_input().write(|w| w.cc4s().ti4().ic4psc().set(3));
        timer.ccer().write(|w| w.cc4e().set_bit());
        let capture = || {
            within(|| timer.sr().read().cc4if().bit_is_set())?;
            Some(timer.ccr4().read().bits())
        };
        // What was captured before this was asked for.
        let _ = capture();
        let first = capture();
        let last = (0..SLOW_CAPTURES).try_fold(0, |_, _| capture());
        timer.ccer().reset();
        let counts = last?.wrapping_sub(first?) as f32;
        Some((SLOW_CAPTURES * EDGES) as f32 * self.timer_hz / counts)
    }
}
