//! USART2, byte by byte and without interrupts.

use stm32f4::stm32f405::USART2;

/// The open port.
pub struct Port(());

impl Port {
    /// Enables sending and reception.
    pub fn open() -> Self {
        registers().cr1().write(|w| w.ue().enabled().te().enabled().re().enabled());
        Self(())
    }

    /// Waits for a byte.
    pub fn receive_byte(&self) -> u8 {
        while registers().sr().read().rxne().bit_is_clear() {}
        registers().dr().read().dr().bits() as u8
    }

    /// Waits for a number.
    pub fn receive(&self) -> f32 {
        f32::from_le_bytes([(); 4].map(|()| self.receive_byte()))
    }

    /// Sends a byte.
    pub fn send_byte(&self, byte: u8) {
        while registers().sr().read().txe().bit_is_clear() {}
        registers().dr().write(|w| w.dr().set(byte.into()));
    }

    /// Sends a number.
    pub fn send(&self, value: f32) {
        value.to_le_bytes().into_iter().for_each(|byte| self.send_byte(byte));
    }
}

fn registers() -> &'static stm32f4::stm32f405::usart1::RegisterBlock {
    // SAFETY: a device's registers, valid for ever; the image has one thread and no interrupts.
    unsafe { &*USART2::ptr() }
}
