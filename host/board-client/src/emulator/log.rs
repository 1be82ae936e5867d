//! The firmware's log: numbers that defmt sends, and the strings in the firmware's ELF file that
//! they stand for.

use std::io::{self, Read};
use std::path::{Path, PathBuf};

use defmt_decoder::{DecodeError, Table};
use thiserror::Error;

/// The firmware's file has no log strings.
#[derive(Debug, Error)]
#[allow(missing_docs, reason = "the messages say what the variants and their fields are")]
pub enum LogError {
    #[error("{}: cannot be read: {source}", file.display())]
    Unreadable { file: PathBuf, source: io::Error },
    #[error("{}: not the firmware: {problem}", file.display())]
    NotFirmware { file: PathBuf, problem: String },
}

/// Turns the log of one firmware into text.
#[derive(Debug)]
pub struct LogDecoder {
    table: Table,
}

impl LogDecoder {
    /// The decoder of a firmware's ELF file.
    ///
    /// # Errors
    /// The file cannot be read or holds no defmt strings.
    pub fn of(elf: &Path) -> Result<Self, LogError> {
        let file = || elf.to_owned();
        let bytes = std::fs::read(elf).map_err(|source| LogError::Unreadable { file: file(), source })?;
        let refuse = |problem| LogError::NotFirmware { file: file(), problem };
        match Table::parse(&bytes) {
            Ok(Some(table)) => Ok(Self { table }),
            Ok(None) => Err(refuse("it has no log strings".to_owned())),
            Err(error) => Err(refuse(error.to_string())),
        }
    }

    /// Shows the entries of a log as they come, until its end. An entry that is cut off or damaged
    /// is left out.
    ///
    /// # Errors
    /// The log cannot be read.
    pub fn follow(&self, mut log: impl Read, mut show: impl FnMut(&str)) -> io::Result<()> {
        let mut decoder = self.table.new_stream_decoder();
        let mut bytes = [0; 1024];
        loop {
            let count = log.read(&mut bytes)?;
            if count == 0 {
                return Ok(());
            }
            decoder.received(&bytes[..count]);
            loop {
                match decoder.decode() {
                    Ok(entry) => show(&entry.display(false).to_string()),
                    Err(DecodeError::UnexpectedEof) => break,
                    Err(DecodeError::Malformed) => {}
                }
            }
        }
    }
}
