//! The service link to a host: USART2, 8 data bits, no parity, one stop bit.
//!
//! # Contract
//! Reception raises the interrupt `USART2`; sending waits, a byte at a time, and a wait is bounded. Host and board
//! take turns (a response follows each request), so nothing arrives while the board sends.
//! Clock and pins are the caller's business: an emulated board has neither.

use stm32f4::stm32f405::USART2;
use wire::Response;

/// Unit: bit/s. At 42 MHz and at 16 MHz the divider is within 0.9 % of it.
pub const BAUD: u32 = 460_800;

/// Polls of the status register before a byte is given up. A byte takes 22 µs, at most 3,700 core cycles.
const POLLS_PER_BYTE: u32 = 10_000;

/// The serial port.
pub struct Usart {
    registers: USART2,
}

impl Usart {
    /// Enables the port, reception and its interrupt. `clock_hz`: the peripheral's clock.
    pub fn new(registers: USART2, clock_hz: u32) -> Self {
        let divider = ((clock_hz + BAUD / 2) / BAUD) as u16;
        // SAFETY: mantissa and fraction together are the divider in sixteenths; any value is allowed.
        registers.brr().write(|w| unsafe { w.bits(divider) });
        registers.cr1().write(|w| w.ue().enabled().te().enabled().re().enabled().rxneie().enabled());
        Self { registers }
    }

    /// The byte that arrived, if any. Reading it ends the interrupt.
    pub fn read(&mut self) -> Option<u8> {
        let status = self.registers.sr().read();
        // Reading the data register also clears an overrun, which would raise the interrupt for ever.
        (status.rxne().bit_is_set() || status.ore().bit_is_set())
            .then(|| self.registers.dr().read().dr().bits() as u8)
    }

    /// Sends a response, framed in `buffer`. One too long for the buffer is not sent; none of ours is.
    pub fn send(&mut self, buffer: &mut [u8], response: &Response) {
        if let Ok(frame) = wire::encode(response, buffer) {
            self.write(frame);
        }
    }

    /// A port that does not get rid of its bytes loses them; the frame's checksum tells the host.
    fn write(&mut self, bytes: &[u8]) {
        for &byte in bytes {
            let _ = (0..POLLS_PER_BYTE).find(|_| self.registers.sr().read().txe().bit_is_set());
            self.registers.dr().write(|w| w.dr().set(byte.into()));
        }
    }
}
