//! Bytes into frames.
//!
//! A frame is complete as soon as it is as long as its function says and its CRC fits, so that an
//! answer need not wait, and so that a request behind another board's answer is heard whatever the
//! silence between them; one of a function that the board does not know is complete when nothing
//! follows. What does not become a frame is dropped after a silence without a byte, or as soon as
//! it is longer than any frame: that is how a receiver that joins in the middle gets into step.
//!
//! Between a pause within a frame and the silence between two there is no sharp limit in practice:
//! after a shorter pause a frame may begin, or the one before go on. Whichever becomes complete was
//! it.

use heapless::Vec;
use wire::registers::FRAME_BYTES;
use wire::slots;

use super::functions::{
    DEVICE_IDENTIFICATION, DIAGNOSTICS, ENCAPSULATED, MASK_WRITE, READ_WRITE, REPORT_SERVER_ID,
};

/// The CRC-16 of Modbus.
pub(super) const CRC: crc::Crc<u16> = crc::Crc::<u16>::new(&crc::CRC_16_MODBUS);

/// The number that all boards listen to.
pub(super) const BROADCAST: u8 = 0;

/// Gathers bytes.
#[derive(Debug)]
pub struct Receiver {
    bytes: Vec<u8, FRAME_BYTES>,
    /// The board's number.
    unit: u8,
    /// From the end of a byte to the end of the first one of the next frame, at the least. Unit:
    /// that of the moments.
    pause: u32,
    /// The same, where a frame does begin.
    silence: u32,
    /// Of the last byte.
    last: u32,
    is_overlong: bool,
    /// Where a frame may begin, behind the last pause.
    begin: usize,
    /// Where the frame begins that was handed over.
    taken: Option<usize>,
    damaged: u32,
}

impl Receiver {
    /// A receiver at the start of a frame, which [`Receiver::set`] has told nothing yet.
    pub const fn new() -> Self {
        let bytes = Vec::new();
        Self {
            bytes,
            unit: BROADCAST,
            pause: u32::MAX,
            silence: u32::MAX,
            last: 0,
            is_overlong: false,
            begin: 0,
            taken: None,
            damaged: 0,
        }
    }

    /// Sets the board's number, and the times behind which a frame may begin, and does. What has
    /// come by others is forgotten.
    pub fn set(&mut self, unit: u8, [pause, silence]: [u32; 2]) {
        (self.unit, self.pause, self.silence, self.taken) = (unit, pause, silence, None);
        self.clear();
    }

    /// Runs of bytes that were no frame.
    pub fn damaged(&self) -> u32 {
        self.damaged
    }

    /// Takes a byte, if one has come, at this moment of a clock that wraps; answers the frame that
    /// is complete.
    pub fn take(&mut self, byte: Option<u8>, moment: u32) -> Option<&[u8]> {
        if self.taken.take().is_some() {
            self.clear();
        }
        // A moment before the last one is no silence.
        let elapsed = u32::try_from(moment.wrapping_sub(self.last).cast_signed()).unwrap_or(0);
        let is_silent = elapsed >= self.silence;
        match byte {
            // Of a function that is known it would have been complete before.
            None if is_silent && lengths(&self.bytes, self.unit).is_none() && self.is_whole(0) => {
                self.taken = Some(0)
            }
            None if is_silent => self.drop_bytes(),
            None => {}
            Some(byte) => {
                if is_silent {
                    self.drop_bytes();
                } else if elapsed >= self.pause && self.is_whole(0) {
                    // Of a function that is not known, or it would have been handed over.
                    self.clear();
                } else if elapsed >= self.pause {
                    self.begin = self.bytes.len();
                }
                self.last = moment;
                self.push(byte);
                self.taken = [0, self.begin].into_iter().find(|&begin| self.is_complete(begin));
                let is_behind_damaged = self.taken.is_some_and(|begin| begin > 0);
                self.damaged = self.damaged.wrapping_add(u32::from(is_behind_damaged));
            }
        }
        self.taken.and_then(|begin| self.bytes.get(begin..))
    }

    fn push(&mut self, byte: u8) {
        if self.bytes.is_full() && self.begin > 0 {
            // What was before the pause is longer than a frame together with what is behind it.
            self.bytes.drain(..self.begin);
            self.begin = 0;
        }
        self.is_overlong |= self.bytes.push(byte).is_err();
    }

    fn clear(&mut self) {
        self.bytes.clear();
        self.begin = 0;
        self.is_overlong = false;
    }

    fn drop_bytes(&mut self) {
        self.damaged = self.damaged.wrapping_add(u32::from(!self.bytes.is_empty()));
        self.clear();
    }

    /// Whether what has come from a byte on is as long as its function says, and ends with its CRC.
    fn is_complete(&self, begin: usize) -> bool {
        let bytes = self.bytes.get(begin..).unwrap_or_default();
        lengths(bytes, self.unit).is_some_and(|lengths| lengths.contains(&bytes.len()))
            && self.is_whole(begin)
    }

    /// Whether what has come from a byte on ends with its CRC.
    fn is_whole(&self, begin: usize) -> bool {
        !self.is_overlong && self.bytes.get(begin..).is_some_and(ends_with_crc)
    }
}

fn ends_with_crc(bytes: &[u8]) -> bool {
    bytes
        .split_last_chunk()
        .is_some_and(|(content, crc)| content.len() >= 2 && CRC.checksum(content) == u16::from_le_bytes(*crc))
}

/// How long a frame of the function is (Modbus application protocol 1.1b3, chapter 6), CRC
/// included: a request, and another board's answer, behind which the next request need not wait for
/// a silence. `None` while that is not known.
fn lengths(bytes: &[u8], unit: u8) -> Option<[usize; 2]> {
    let at = |place: usize| bytes.get(place).map(|&byte| usize::from(byte));
    if *bytes.get(1)? == slots::FUNCTION {
        // Asked is by all members at once alone; whoever has a number answers.
        let is_request = bytes.first() == Some(&BROADCAST);
        let length = if is_request { slots::request_bytes(bytes)? } else { slots::ANSWER_BYTES };
        return Some([length; 2]);
    }
    let [request, answer] = match *bytes.get(1)? {
        1..=4 => [8, 5 + at(2)?],
        5 | 6 | DIAGNOSTICS => [8, 8],
        15 | 16 => [9 + at(6)?, 8],
        REPORT_SERVER_ID => [4, 5 + at(2)?],
        MASK_WRITE => [10, 10],
        // The answer may be shorter than the place that tells the request's length.
        READ_WRITE => [at(10).map_or(usize::MAX, |bytes| 13 + bytes), 5 + at(2)?],
        ENCAPSULATED if *bytes.get(2)? == DEVICE_IDENTIFICATION => {
            [7, identification(bytes).unwrap_or(usize::MAX)]
        }
        0x80.. => [5, 5],
        _ => return None,
    };
    // Nobody but this board answers by its number.
    let is_others = bytes.first().is_some_and(|of| ![BROADCAST, unit].contains(of));
    Some([request, if is_others { answer } else { request }])
}

/// How long another board's answer is by which it identifies itself: behind eight bytes, of which
/// the last is their number, objects of a number, a length and as many bytes each; CRC included.
fn identification(bytes: &[u8]) -> Option<usize> {
    let objects = *bytes.get(7)?;
    let end = (0..objects).try_fold(8, |place, _| Some(place + 2 + usize::from(*bytes.get(place + 1)?)))?;
    Some(end + 2)
}
