//! The upload's buffer: a configuration that comes in blocks, or is read back.
//!
//! Only a commit looks at what it holds; whatever stands there before does nothing.

use serde::Deserialize;
use wire::registers::{Exception, UPLOAD_BYTES, UPLOAD_REGISTERS, UploadResult, checksum};
use wire::{BoardParameters, Configuration, VERSION};

/// The buffer.
#[derive(Clone, Debug)]
pub struct Upload {
    buffer: [u8; UPLOAD_BYTES],
    /// Unit: byte.
    pub length: u16,
    /// Over the first `length` bytes.
    pub checksum: u32,
    /// Of the window. Unit: byte.
    pub offset: u16,
}

impl Upload {
    /// An empty buffer.
    pub const fn new() -> Self {
        Self { buffer: [0; UPLOAD_BYTES], length: 0, checksum: 0, offset: 0 }
    }

    /// The register of the window with this number, 0 beyond the end.
    pub fn word(&self, index: u16) -> u16 {
        let at = usize::from(self.offset) + 2 * usize::from(index);
        let byte = |at: usize| self.buffer.get(at).copied().unwrap_or(0);
        u16::from_be_bytes([byte(at), byte(at + 1)])
    }

    /// Moves the window to an offset, and writes it from the register of this number on.
    ///
    /// # Errors
    /// It does not fit in the buffer.
    pub fn write(&mut self, offset: u16, index: u16, words: &[u16]) -> Result<(), Exception> {
        let start = usize::from(offset) + 2 * usize::from(index);
        let room = self.buffer.get_mut(start..start + 2 * words.len()).ok_or(Exception::IllegalValue)?;
        for (place, word) in room.chunks_exact_mut(2).zip(words) {
            place.copy_from_slice(&word.to_be_bytes());
        }
        self.offset = offset;
        Ok(())
    }

    /// The configuration that the buffer holds.
    ///
    /// # Errors
    /// It holds none.
    pub fn content(&self) -> Result<BoardParameters, UploadResult> {
        let bytes = self.buffer.get(..self.length.into()).unwrap_or_default();
        if bytes.is_empty() || checksum(bytes) != self.checksum {
            return Err(UploadResult::Checksum);
        }
        // The version stands first, and tells how to read the rest.
        match read::<u16>(bytes) {
            Some((VERSION, _)) => {}
            Some(_) => return Err(UploadResult::Version),
            None => return Err(UploadResult::Unreadable),
        }
        match read::<Configuration>(bytes) {
            Some((configuration, [])) => Ok(configuration.tracking),
            _ => Err(UploadResult::Unreadable),
        }
    }

    /// Fills the buffer with a configuration.
    ///
    /// # Errors
    /// It does not fit; no valid one is so long.
    pub fn fill(&mut self, tracking: &BoardParameters) -> Result<(), Exception> {
        let configuration = Configuration { version: VERSION, tracking: tracking.clone() };
        let bytes =
            postcard::to_slice(&configuration, &mut self.buffer).map_err(|_| Exception::DeviceFailure)?;
        (self.length, self.checksum, self.offset) = (bytes.len() as u16, checksum(bytes), 0);
        Ok(())
    }
}

impl Default for Upload {
    fn default() -> Self {
        Self::new()
    }
}

fn read<'a, T: Deserialize<'a>>(bytes: &'a [u8]) -> Option<(T, &'a [u8])> {
    postcard::take_from_bytes(bytes).ok()
}

const _: () = assert!(2 * UPLOAD_REGISTERS as usize <= UPLOAD_BYTES);
