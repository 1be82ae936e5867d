//! Bytes into frames.
//!
//! A frame is complete as soon as it is as long as its function says and its CRC fits, so that an answer need not wait, and
//! so that a request behind another board's answer is heard whatever the silence between them; one
//! of a function that the board does not know is complete when nothing follows. What does not become a frame is dropped
//! after [`Receiver::silence`] without a byte, or as soon as it is longer than any frame: that is how a receiver
//! that joins in the middle gets into step.

use heapless::Vec;
use wire::registers::{FRAME_BYTES, UNIT};

/// The CRC-16 of Modbus.
const CRC: crc::Crc<u16> = crc::Crc::<u16>::new(&crc::CRC_16_MODBUS);

/// The number that all boards listen to.
const BROADCAST: u8 = 0;

/// Gathers bytes.
#[derive(Debug)]
pub struct Receiver {
    bytes: Vec<u8, FRAME_BYTES>,
    /// From the end of a byte to the end of the first one of the next frame, at the least. Unit: that of the moments.
    silence: u32,
    /// Of the last byte.
    last: u32,
    is_overlong: bool,
    /// Whether `bytes` is a frame that was handed over.
    is_taken: bool,
    damaged: u32,
}

impl Receiver {
    /// A receiver at the start of a frame.
    pub const fn new(silence: u32) -> Self {
        let bytes = Vec::new();
        Self { bytes, silence, last: 0, is_overlong: false, is_taken: false, damaged: 0 }
    }

    /// Runs of bytes that were no frame.
    pub fn damaged(&self) -> u32 {
        self.damaged
    }

    /// Takes a byte, if one has come, at this moment of a clock that wraps; answers the frame that is complete.
    pub fn take(&mut self, byte: Option<u8>, moment: u32) -> Option<&[u8]> {
        if core::mem::take(&mut self.is_taken) {
            self.bytes.clear();
        }
        let is_silent = moment.wrapping_sub(self.last) >= self.silence;
        match byte {
            // Of a function that is known it would have been complete before.
            None if is_silent && self.lengths().is_none() && self.is_whole() => self.is_taken = true,
            None if is_silent => self.drop_bytes(),
            None => {}
            Some(byte) => {
                if is_silent {
                    self.drop_bytes();
                }
                self.last = moment;
                self.is_overlong |= self.bytes.push(byte).is_err();
                let is_long_enough =
                    self.lengths().is_some_and(|lengths| lengths.contains(&self.bytes.len()));
                self.is_taken = is_long_enough && self.is_whole();
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

    /// How long a frame of the function is (Modbus application protocol 1.1b3, chapter 6), CRC included: a request, and
    /// another board's answer, behind which the next request need not wait for a silence. `None` while that is not known.
    fn lengths(&self) -> Option<[usize; 2]> {
        let at = |place: usize| self.bytes.get(place).map(|&byte| usize::from(byte));
        let [request, answer] = match at(1)? {
            1..=4 => [8, 5 + at(2)?],
            5 | 6 => [8, 8],
            15 | 16 => [9 + at(6)?, 8],
            0x80.. => [5, 5],
            _ => return None,
        };
        // Nobody but this board answers by its number.
        let is_others = !matches!(self.bytes.first(), Some(&(BROADCAST | UNIT)));
        Some([request, if is_others { answer } else { request }])
    }
}
