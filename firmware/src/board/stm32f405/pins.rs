//! Pins, the status light and the voltage detector; the wiring table is in `docs/board.md`.

use stm32f4::stm32f405::{GPIOA, GPIOB, GPIOC, PWR};

use crate::bus_port::DriverEnable;

/// The highest threshold of the voltage detector, 2.9 V (RM0090, 5.4.1).
const HIGHEST_THRESHOLD: u8 = 7;

/// Connects the pins to the peripherals.
pub fn route(a: &GPIOA, c: &GPIOC) {
    a.moder().modify(|_, w| {
        w.moder0().analog().moder1().analog().moder2().alternate().moder3().alternate().moder4().analog();
        w.moder6().alternate().moder9().alternate().moder10().alternate()
    });
    a.afrl().modify(|_, w| w.afrl2().af7().afrl3().af7().afrl6().af2());
    a.afrh().modify(|_, w| w.afrh9().af7().afrh10().af7());
    c.moder().modify(|_, w| w.moder0().analog());
}

/// The status light at PB12, lit when high.
pub struct Light(GPIOB);

impl Light {
    /// Dark.
    pub fn dark(port: GPIOB) -> Self {
        port.moder().modify(|_, w| w.moder12().output());
        Self(port)
    }

    /// Lights it, or not.
    pub fn set(&mut self, is_lit: bool) {
        self.0.bsrr().write(|w| if is_lit { w.bs12().set_bit() } else { w.br12().set_bit() });
    }
}

/// The driver of the bus at PA8, enabled when high.
pub struct BusDriver(GPIOA);

impl BusDriver {
    /// Not enabled.
    pub fn listening(port: GPIOA) -> Self {
        port.moder().modify(|_, w| w.moder8().output());
        Self(port)
    }
}

impl DriverEnable for BusDriver {
    fn set(&mut self, drives: bool) {
        self.0.bsrr().write(|w| if drives { w.bs8().set_bit() } else { w.br8().set_bit() });
    }
}

/// The detector of low voltage.
pub struct VoltageDetector(PWR);

impl VoltageDetector {
    /// Starts it. It has to be clocked.
    pub fn start(power: PWR) -> Self {
        power.cr().modify(|_, w| w.pls().set(HIGHEST_THRESHOLD).pvde().enabled());
        Self(power)
    }

    /// Whether the voltage is below the threshold.
    pub fn is_low(&self) -> bool {
        self.0.csr().read().pvdo().bit_is_set()
    }
}
