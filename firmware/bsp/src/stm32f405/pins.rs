//! Pins, the status light and the voltage detector; the wiring table is in `docs/board.md`.

use core::sync::atomic::{AtomicBool, Ordering};

use stm32f4::stm32f405::{EXTI, GPIOA, GPIOB, GPIOC, PWR, gpiob};

use super::clock::within;
use super::valve::vent;

/// Threshold of the voltage detector: 2.93 V falling, 2.84 to 2.99 V from chip to chip (data sheet
/// DS8626, "Embedded reset and power control block"). The next one, 3.03 V, would trip on a supply
/// of 3.3 V less 5 %.
const THRESHOLD: u8 = 6;

/// Connects the pins to the peripherals. The receivers' pins are pulled up: without a cable they
/// would float, and see bytes that nobody has sent. `drives`: whether the dump valve's output is to
/// be one.
pub fn route(a: &GPIOA, b: &GPIOB, c: &GPIOC, drives: bool) {
    a.pupdr().modify(|_, w| w.pupdr3().pull_up().pupdr10().pull_up());
    a.moder().modify(|_, w| {
        w.moder0().analog().moder1().analog().moder2().alternate().moder3().alternate().moder4().analog();
        w.moder6().alternate().moder9().alternate().moder10().alternate()
    });
    a.afrl().modify(|_, w| w.afrl2().af7().afrl3().af7().afrl6().af2());
    a.afrh().modify(|_, w| w.afrh9().af7().afrh10().af7());
    b.pupdr().modify(|_, w| w.pupdr14().pull_up().pupdr15().pull_up());
    b.moder().modify(|_, w| w.moder12().output());
    if drives {
        b.moder().modify(|_, w| w.moder13().output());
    }
    c.moder().modify(|_, w| w.moder0().analog());
}

/// Connects what a board with two channels has beyond that: the second set point at PA5, and the
/// second pressure at PC1.
pub fn route_second(a: &GPIOA, c: &GPIOC) {
    a.moder().modify(|_, w| w.moder5().analog());
    c.moder().modify(|_, w| w.moder1().analog());
}

/// The status light at PB12, lit when high.
pub struct Light;

impl Light {
    /// Lights it, or not.
    pub fn set(&mut self, is_lit: bool) {
        port_b().bsrr().write(|w| if is_lit { w.bs12().set_bit() } else { w.br12().set_bit() });
    }
}

/// What keeps the dump valve closed: PB13, which changes its level in each tick that wants that. A
/// charge pump makes of the changes what holds the valve; a level that stays, high or low, lets it
/// open.
#[derive(Default)]
pub struct DumpValve {
    is_high: bool,
}

impl DumpValve {
    /// Once a tick.
    pub fn tick(&mut self, keeps_closed: bool) {
        self.is_high = keeps_closed && !self.is_high;
        let is_high = self.is_high;
        port_b().bsrr().write(|w| if is_high { w.bs13().set_bit() } else { w.br13().set_bit() });
    }
}

/// Whether the second contact of the emergency stop, from PB14 to ground, is open; a cable that is
/// broken is.
pub fn is_stop_open() -> bool {
    port_b().idr().read().idr14().bit_is_set()
}

/// Whether the dump valve's coil has a voltage: PB15 is closed to ground while it has none; a cable
/// that is broken counts as a voltage.
pub fn has_coil_voltage() -> bool {
    port_b().idr().read().idr15().bit_is_set()
}

/// Light, dump valve and emergency stop share it.
fn port_b() -> &'static gpiob::RegisterBlock {
    // SAFETY: reading has no side effect, and a store to the register of bits that are set and
    // reset touches its own pin only.
    unsafe { &*GPIOB::ptr() }
}

/// Whether PA8, the bus's driver, is high.
pub fn is_bus_driver_high() -> bool {
    // SAFETY: reading has no side effect.
    unsafe { &*GPIOA::ptr() }.idr().read().idr8().bit_is_set()
}

/// The driver of the bus at PA8, enabled when high.
pub struct BusDriver(GPIOA);

impl BusDriver {
    /// Not enabled.
    pub fn listening(port: GPIOA) -> Self {
        port.moder().modify(|_, w| w.moder8().output());
        Self(port)
    }

    /// Drives, or listens.
    pub fn set(&mut self, drives: bool) {
        self.0.bsrr().write(|w| if drives { w.bs8().set_bit() } else { w.br8().set_bit() });
    }
}

/// The detector of low voltage. It is looked at in each tick, and raises an interrupt above it,
/// which vents at once.
pub struct VoltageDetector(PWR);

/// Whether the voltage was low since the last tick.
static WAS_LOW: AtomicBool = AtomicBool::new(false);

impl VoltageDetector {
    /// Starts it, and its interrupt by line 16. It has to be clocked.
    pub fn start(power: PWR, lines: &EXTI) -> Self {
        begin(&power);
        lines.rtsr().modify(|_, w| w.tr16().enabled());
        lines.imr().modify(|_, w| w.mr16().unmasked());
        Self(power)
    }

    /// Waits for the supply to come up; whether it has.
    pub fn wait(&self) -> bool {
        is_up(&self.0)
    }

    /// The same without an interrupt, for the starter.
    pub fn watch(power: &PWR) -> bool {
        begin(power);
        is_up(power)
    }

    /// Whether the voltage is below the threshold, or was since the last call.
    pub fn is_low(&self) -> bool {
        // In this order, and without an exchange, which the tick need not wait for.
        let was_low = was_supply_low();
        if was_low {
            WAS_LOW.store(false, Ordering::Relaxed);
        }
        was_low || is_supply_low()
    }
}

/// Starts the detector.
fn begin(power: &PWR) {
    power.cr().modify(|_, w| w.pls().set(THRESHOLD).pvde().enabled());
}

/// Waits for the supply to come up; whether it has.
fn is_up(power: &PWR) -> bool {
    within(|| power.csr().read().pvdo().bit_is_clear()).is_some()
}

/// Whether the detector's interrupt has vented since the tick looked last.
pub fn was_supply_low() -> bool {
    WAS_LOW.load(Ordering::Relaxed)
}

/// Whether the voltage is below the threshold now, for those who do not own the detector.
pub fn is_supply_low() -> bool {
    // SAFETY: reading has no side effect.
    unsafe { &*PWR::ptr() }.csr().read().pvdo().bit_is_set()
}

/// What the detector's interrupt does: vents, and leaves the rest to the tick.
pub fn on_low_voltage() {
    vent();
    // SAFETY: ones clear the lines that they stand for, zeros leave the others alone.
    unsafe { &*EXTI::ptr() }.pr().write(|w| w.pr16().clear());
    WAS_LOW.store(true, Ordering::Relaxed);
}
