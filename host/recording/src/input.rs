//! Reading a command's files, of which one may be standard input, named `-`.

use std::borrow::Cow;
use std::fs;
use std::io::{self, Read};
use std::path::Path;

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
