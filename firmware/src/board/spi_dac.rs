//! A 12-bit converter of the MCP4921 kind on a bus: one word of 16 bits a set point, the four
//! highest of which configure.
//!
//! An example of another output than the processor's own. Its output is 0 V after power-on, as the
//! safe state needs.

use embedded_hal::spi::SpiDevice;

use super::{DacCode, Valve};
use crate::scaling::COMMAND;

/// Reference unbuffered, gain 1, output on (MCP4921 data sheet, register 5-1).
const CONFIGURATION: u16 = 0b0011 << 12;

/// A converter on a bus.
#[derive(Debug)]
pub struct SpiDac<S>(pub S);

impl<S: SpiDevice> Valve for SpiDac<S> {
    type Error = S::Error;

    fn set(&mut self, code: DacCode) -> Result<(), S::Error> {
        self.0.write(&(CONFIGURATION | code.0.min(COMMAND.code_max)).to_be_bytes())
    }
}
