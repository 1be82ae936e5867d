//! Reading a command's files, of which one may be standard input, named `-`.

use std::borrow::Cow;
use std::fs::{self, File};
use std::io::{self, Read, Seek, SeekFrom};
use std::path::Path;
use std::sync::Arc;

/// The name of standard input and standard output.
const STANDARD: &str = "-";

/// Whether a path stands for standard input or standard output.
pub fn is_standard(path: &Path) -> bool {
    path == Path::new(STANDARD)
}

/// A file's name for people.
pub fn name(path: &Path) -> Cow<'_, str> {
    if is_standard(path) { "standard input".into() } else { path.display().to_string().into() }
}

/// The bytes of a file, or of standard input.
///
/// # Errors
/// It cannot be read.
pub fn bytes(path: &Path) -> io::Result<Vec<u8>> {
    if !is_standard(path) {
        return fs::read(path);
    }
    let mut bytes = Vec::new();
    io::stdin().lock().read_to_end(&mut bytes)?;
    Ok(bytes)
}

/// The text of a file, or of standard input.
///
/// # Errors
/// It cannot be read, or is not UTF-8.
pub fn text(path: &Path) -> io::Result<String> {
    String::from_utf8(bytes(path)?).map_err(|error| io::Error::new(io::ErrorKind::InvalidData, error))
}

/// Reads an open file from a place on; others may read it meanwhile.
#[derive(Clone, Debug)]
pub struct FromPlace {
    file: Arc<File>,
    /// Bytes before what is read next.
    place: u64,
}

impl FromPlace {
    /// The bytes behind so many.
    pub fn new(file: &Arc<File>, place: u64) -> Self {
        Self { file: Arc::clone(file), place }
    }
}

impl Read for FromPlace {
    fn read(&mut self, buffer: &mut [u8]) -> io::Result<usize> {
        // Who else reads the file has moved its only cursor.
        let mut file = &*self.file;
        file.seek(SeekFrom::Start(self.place))?;
        let count = file.read(buffer)?;
        self.place += count as u64;
        Ok(count)
    }
}
