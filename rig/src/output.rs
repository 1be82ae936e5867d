//! Writing a file whole or not at all, and never over another one unasked.

use std::io::{BufWriter, Write};
use std::path::Path;

use anyhow::{Context, Result, ensure};

/// Lets `write` fill a file beside `path`, then gives it that name; with `force` in place of an
/// existing file.
///
/// # Errors
/// The name is taken and `force` is not set, is not a file's, or the folder or the medium refuses.
/// Whatever fails, `path` is as it was and nothing is left beside it.
pub fn write_whole(
    path: &Path,
    force: bool,
    write: impl FnOnce(&mut dyn Write) -> std::io::Result<()>,
) -> Result<()> {
    let name = path.display();
    ensure!(!path.exists() || path.is_file(), "{name}: not a file");
    ensure!(force || !path.exists(), "{name}: exists already; --force overwrites it");
    let folder = path.parent().filter(|folder| !folder.as_os_str().is_empty()).unwrap_or(Path::new("."));
    let mut builder = tempfile::Builder::new();
    // Temporary files are private by default; the finished one is an ordinary file under the user's
    // umask.
    #[cfg(unix)]
    builder.permissions(std::os::unix::fs::PermissionsExt::from_mode(0o666));
    let mut file =
        builder.tempfile_in(folder).with_context(|| format!("cannot write in {}", folder.display()))?;
    let mut buffered = BufWriter::new(&mut file);
    write(&mut buffered).and_then(|()| buffered.flush()).with_context(|| format!("cannot write {name}"))?;
    drop(buffered);
    let named = if force { file.persist(path) } else { file.persist_noclobber(path) };
    named.with_context(|| format!("cannot write {name}"))?;
    Ok(())
}
