//! Copies of what can be read once only, or not from any place: pipes, and what is compressed.

use std::env;
use std::fs::File;
use std::io::{self, BufWriter, Read, Seek, Write};
use std::path::Path;
use std::sync::Arc;

/// A file without a name, which is gone when nobody reads it any more.
///
/// # Errors
/// It cannot be made, or `write` says so.
pub fn file(folder: Option<&Path>, write: impl FnOnce(&mut dyn Write) -> io::Result<()>) -> io::Result<File> {
    let folder = folder.map_or_else(env::temp_dir, Path::to_owned);
    let mut buffered = BufWriter::new(tempfile::tempfile_in(folder)?);
    write(&mut buffered)?;
    let mut file = buffered.into_inner().map_err(io::IntoInnerError::into_error)?;
    file.rewind()?;
    Ok(file)
}

/// A copy.
///
/// # Errors
/// It cannot be made, or `bytes` not be read.
pub fn copy(folder: Option<&Path>, bytes: &mut dyn Read) -> io::Result<Arc<File>> {
    file(folder, |target| io::copy(bytes, target).map(drop)).map(Arc::new)
}
