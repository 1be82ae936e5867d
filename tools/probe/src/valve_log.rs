//! What the image has written to its DAC: the emulator does not model it, and logs every access.

use std::fs::File;
use std::io::{Read, Seek, SeekFrom};

use anyhow::Result;

/// How the emulator logs a write to the data register of the converter's channel 1 (DHR12R1).
const WRITE: &str = "DAC: unimplemented device write (size 4, offset 0x008, value 0x";

/// The log, read up to a place.
pub struct ValveLog {
    file: File,
    position: u64,
    /// The begin of a line whose end is not there yet.
    rest: String,
}

impl ValveLog {
    /// Reads a log from its begin; the emulator goes on writing to it.
    pub fn new(file: File) -> Self {
        Self { file, position: 0, rest: String::new() }
    }

    /// The codes that have been written since the last call. Unit: DAC code.
    ///
    /// # Errors
    /// The log cannot be read.
    pub fn codes(&mut self) -> Result<Vec<u16>> {
        self.file.seek(SeekFrom::Start(self.position))?;
        let mut bytes = Vec::new();
        self.position += self.file.read_to_end(&mut bytes)? as u64;
        self.rest += &String::from_utf8_lossy(&bytes);
        let complete = self.rest.rfind('\n').map_or(0, |end| end + 1);
        let lines: String = self.rest.drain(..complete).collect();
        Ok(lines.lines().filter_map(code).collect())
    }
}

fn code(line: &str) -> Option<u16> {
    u16::from_str_radix(line.strip_prefix(WRITE)?.get(4..8)?, 16).ok()
}

#[cfg(test)]
mod tests {
    use super::code;

    #[test]
    fn only_writes_to_the_data_register_are_codes() {
        let line = |device: &str, offset: &str| {
            format!("{device}: unimplemented device write (size 4, offset {offset}, value 0x00000abc)")
        };
        assert_eq!(code(&line("DAC", "0x008")), Some(0xabc));
        assert_eq!(code(&line("DAC", "0x000")), None);
        assert_eq!(code(&line("PWR", "0x008")), None);
    }
}
