//! Bytes into frames.
//!
//! A frame is complete as soon as it is as long as its function says and its CRC fits, so that an answer need not wait; one
//! of a function that the board does not know is complete when nothing follows. What does not become a frame is dropped
//! after [`Receiver::silence_ticks`] without a byte, or as soon as it is longer than any frame: that is how a receiver
//! that joins in the middle gets into step.

use heapless::Vec;
use wire::registers::FRAME_BYTES;

/// The CRC-16 of Modbus.
const CRC: crc::Crc<u16> = crc::Crc::<u16>::new(&crc::CRC_16_MODBUS);

/// Gathers bytes.
#[derive(Debug)]
pub struct Receiver {
    bytes: Vec<u8, FRAME_BYTES>,
    /// How long the bus has to be still before a frame begins. At least 3.5 characters. Unit: tick.
    silence_ticks: u32,
    last_tick: u32,
    is_overlong: bool,
    /// Whether `bytes` is a frame that was handed over.
    is_taken: bool,
    damaged: u32,
}

impl Receiver {
    /// A receiver at the start of a frame.
    pub const fn new(silence_ticks: u32) -> Self {
        let bytes = Vec::new();
        Self { bytes, silence_ticks, last_tick: 0, is_overlong: false, is_taken: false, damaged: 0 }
    }

    /// Runs of bytes that were no frame.
    pub fn damaged(&self) -> u32 {
        self.damaged
    }

    /// Takes a byte, if one has come, in this tick; answers the frame that is complete.
    pub fn take(&mut self, byte: Option<u8>, tick: u32) -> Option<&[u8]> {
        if core::mem::take(&mut self.is_taken) {
            self.bytes.clear();
        }
        let is_silent = tick.wrapping_sub(self.last_tick) >= self.silence_ticks;
        match byte {
            // Of a function that is known it would have been complete before.
            None if is_silent && self.expected().is_none() && self.is_whole() => self.is_taken = true,
            None if is_silent => self.drop_bytes(),
            None => {}
            Some(byte) => {
                if is_silent {
                    self.drop_bytes();
                }
                self.last_tick = tick;
                self.is_overlong |= self.bytes.push(byte).is_err();
                self.is_taken = self.expected() == Some(self.bytes.len()) && self.is_whole();
            }
        }
        self.is_taken.then_some(&*self.bytes)
    }

    fn drop_bytes(&mut self) {
        self.damaged = self.damaged.wrapping_add(u32::from(!self.bytes.is_empty()));
        self.bytes.clear();
        self.is_overlong = false;
    }

    /// Whether what has come ends with its CRC.
    fn is_whole(&self) -> bool {
        match self.bytes.split_last_chunk() {
            Some((content, crc)) if content.len() >= 2 && !self.is_overlong => {
                CRC.checksum(content) == u16::from_le_bytes(*crc)
            }
            _ => false,
        }
    }

    /// How long a request of the function is (Modbus application protocol 1.1b3, chapter 6), CRC included; `None` while that
    /// is not known.
    fn expected(&self) -> Option<usize> {
        match self.bytes.get(1)? {
            1..=6 => Some(8),
            15 | 16 => Some(9 + usize::from(*self.bytes.get(6)?)),
            _ => None,
        }
    }
}
