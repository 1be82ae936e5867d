//! The valve's output as a voltage: channel 1 of the DAC, 0 to 3.3 V at PA4, which the board
//! amplifies to 0 to 10 V for a proportional regulator.
//!
//! # Limits
//! The converter's buffer is guaranteed from 0.2 V to 0.2 V below the supply: 0.6 to 9.4 bar (data
//! sheet DS8626); mostly it reaches some 0.06 V. A code below that puts out what the buffer
//! reaches; the vented code lets go of the pin, which is then at 0 V ([`vent`]).

use core::convert::Infallible;

use firmware::DacCode;
use firmware::board::Valve;
use firmware::scaling::VENT;
use stm32f4::stm32f405::{DAC, TIM3};

use super::valve::vent;

/// Whether the converter's pin is an input of the other converter, too.
pub const IS_READ_BACK: bool = true;

/// The output.
pub struct Output(DAC);

/// Vented. The converter has to be clocked.
pub fn vented(dac: DAC, _: TIM3, _timer_hz: u32) -> Output {
    vent();
    Output(dac)
}

impl Valve for Output {
    type Error = Infallible;

    fn set(&mut self, code: DacCode) -> Result<(), Infallible> {
        dac_write(&self.0, code.0);
        Ok(())
    }
}

/// Never inlined, and with a name of its own, so that the way from the tick's interrupt to here can
/// be counted.
// SAFETY: nothing else in the image has this name.
#[unsafe(no_mangle)]
#[inline(never)]
extern "C" fn dac_write(dac: &DAC, code: u16) {
    dac.dhr12r1().write(|w| w.daccdhr().set(code));
    // It takes the pin with the first code that drives, and lets go of it with the vented one.
    dac.cr().write(|w| w.en1().bit(code != VENT.0));
}
