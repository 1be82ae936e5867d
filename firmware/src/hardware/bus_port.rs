//! The users' port: USART1 behind an RS-485 transceiver, 8 data bits, no parity, one stop bit.
//!
//! # Contract
//! No wait: [`BusPort::send`] and the interrupt hand over what the port takes at the moment. The transceiver drives the bus
//! from the first bit to the last and listens at all other times; what comes in meanwhile is an echo, and not read.
//! Clock and pins are the caller's business: an emulated board has neither.

use heapless::Vec;
use stm32f4::stm32f405::USART1;
use wire::registers::{BAUD, FRAME_BYTES};

/// What makes the transceiver drive the bus.
pub trait DriverEnable {
    /// Drives, or listens.
    fn set(&mut self, drives: bool);
}

/// The port.
pub struct BusPort<D> {
    registers: USART1,
    driver: D,
    sending: Vec<u8, FRAME_BYTES>,
    /// Of these, handed over.
    sent: usize,
}

impl<D: DriverEnable> BusPort<D> {
    /// Enables the port, reception and its interrupt. `clock_hz`: the peripheral's clock.
    pub fn new(registers: USART1, clock_hz: u32, driver: D) -> Self {
        let divider = ((clock_hz + BAUD / 2) / BAUD) as u16;
        // SAFETY: mantissa and fraction together are the divider in sixteenths; any value is allowed.
        registers.brr().write(|w| unsafe { w.bits(divider) });
        registers.cr1().write(|w| w.ue().enabled().te().enabled().re().enabled().rxneie().enabled());
        Self { registers, driver, sending: Vec::new(), sent: 0 }
    }

    /// The byte that arrived, if any. Reading it ends the interrupt. To be called before [`BusPort::go_on`], which may give
    /// the bus free: the echo of the last byte is there by then.
    pub fn read(&mut self) -> Option<u8> {
        let status = self.registers.sr().read();
        // Reading the data register also clears an overrun, which would raise the interrupt for ever.
        let byte = (status.rxne().bit_is_set() || status.ore().bit_is_set())
            .then(|| self.registers.dr().read().dr().bits() as u8);
        byte.filter(|_| !self.is_sending())
    }

    /// Whether the board has the bus.
    pub fn is_sending(&self) -> bool {
        !self.sending.is_empty()
    }

    /// Begins to send; nothing is sent if there is nothing.
    pub fn send(&mut self, bytes: &[u8]) {
        self.sending = Vec::from_slice(bytes).unwrap_or_default();
        self.sent = 0;
        if self.is_sending() {
            self.driver.set(true);
            self.go_on();
        }
    }

    /// Hands over what the port takes, and gives the bus free behind the last bit. To be called at each interrupt.
    pub fn go_on(&mut self) {
        if !self.is_sending() {
            return;
        }
        while let Some(&byte) = self.sending.get(self.sent)
            && self.registers.sr().read().txe().bit_is_set()
        {
            self.registers.dr().write(|w| w.dr().set(byte.into()));
            self.sent += 1;
        }
        let is_handed_over = self.sent == self.sending.len();
        if is_handed_over && self.registers.sr().read().tc().bit_is_set() {
            self.driver.set(false);
            self.sending.clear();
        }
        let is_sending = self.is_sending();
        // The next interrupt: room for a byte, or the end of the last one.
        self.registers.cr1().modify(|_, w| {
            w.txeie().bit(is_sending && !is_handed_over).tcie().bit(is_sending && is_handed_over)
        });
    }
}
