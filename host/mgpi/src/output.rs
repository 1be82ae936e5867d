//! Writing a command's files: all of them at the end, each at once, none over an existing file.
//!
//! A command claims its outputs before it begins to work, so that an hour of work is not lost to a
//! file that is in the way. Contents are written beside their place under another name;
//! [`Outputs::commit`] renames them. A command that fails before that leaves nothing behind. One
//! output may be standard output, named `-`: what is said for people then goes to standard error.

use std::io::{self, BufWriter, Seek, Write};
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicBool, Ordering};

use tempfile::{Builder, NamedTempFile, SpooledTempFile, spooled_tempfile};
use thiserror::Error;

use recording::input::is_standard;

/// How much of a file for standard output is held. Unit: bytes.
const HELD: usize = 1 << 20;
/// Its name in messages.
const STANDARD_OUTPUT: &str = "standard output";

/// Whether standard output carries a file.
static IS_STANDARD_OUTPUT_TAKEN: AtomicBool = AtomicBool::new(false);

/// Why an output was not written.
#[derive(Debug, Error)]
#[allow(missing_docs, reason = "the messages say what the variants and their fields are")]
pub enum OutputError {
    #[error("{}: exists already; --force overwrites it", .0.display())]
    Exists(PathBuf),
    #[error("{}: named for two outputs", .0.display())]
    NamedTwice(PathBuf),
    #[error("standard input (-): named for two inputs, and can be read once only")]
    ReadTwice,
    #[error("{}: is an input of this command; not even --force overwrites it", .0.display())]
    IsInput(PathBuf),
    #[error("{}: cannot be written: {source}", path.display())]
    Unwritable { path: PathBuf, source: io::Error },
}

/// Prints what another program is to read, whole.
///
/// # Errors
/// Standard output takes it not, or is closed.
pub fn print(content: &[u8]) -> Result<(), OutputError> {
    io::stdout().write_all(content).map_err(unwritable(Path::new(STANDARD_OUTPUT)))
}

/// Says a line for people: on standard output, unless that carries a file. That nobody reads on (a
/// closed pipe) is no reason to fail.
pub fn say(line: std::fmt::Arguments<'_>) {
    let _ = match IS_STANDARD_OUTPUT_TAKEN.load(Ordering::Relaxed) {
        true => writeln!(io::stderr(), "{line}"),
        false => writeln!(io::stdout(), "{line}"),
    };
}

/// The outputs of a command.
#[derive(Debug)]
pub struct Outputs {
    force: bool,
    staged: Vec<(NamedTempFile, PathBuf)>,
    /// What goes to standard output; from a size on in a file, since it may be a night's recording.
    standard: SpooledTempFile,
}

impl Outputs {
    /// Claims the files that a command is going to write; `inputs` are those that it reads.
    ///
    /// # Errors
    /// A file exists and `force` is not set, is an input, is named twice, or its directory does not
    /// exist.
    pub fn claim<'a>(
        paths: impl IntoIterator<Item = &'a PathBuf>,
        inputs: &[&Path],
        force: bool,
    ) -> Result<Self, OutputError> {
        if inputs.iter().filter(|input| is_standard(input)).count() > 1 {
            return Err(OutputError::ReadTwice);
        }
        let inputs: Vec<PathBuf> = inputs.iter().filter_map(|input| input.canonicalize().ok()).collect();
        let mut claimed: Vec<&Path> = Vec::new();
        for path in paths {
            if claimed.contains(&path.as_path()) {
                return Err(OutputError::NamedTwice(path.clone()));
            }
            claimed.push(path);
            if is_standard(path) {
                IS_STANDARD_OUTPUT_TAKEN.store(true, Ordering::Relaxed);
                continue;
            }
            if path.canonicalize().is_ok_and(|path| inputs.contains(&path)) {
                return Err(OutputError::IsInput(path.clone()));
            }
            if path.is_dir() {
                return Err(unwritable(path)(io::ErrorKind::IsADirectory.into()));
            }
            if path.exists() && !force {
                return Err(OutputError::Exists(path.clone()));
            }
            if !directory(path).is_dir() {
                return Err(unwritable(path)(io::Error::new(
                    io::ErrorKind::NotFound,
                    format!("there is no directory {}", directory(path).display()),
                )));
            }
        }
        Ok(Self { force, staged: Vec::new(), standard: spooled_tempfile(HELD) })
    }

    /// Writes the content of a claimed file beside its place.
    ///
    /// # Errors
    /// The file cannot be written.
    pub fn stage(&mut self, path: &Path, content: &[u8]) -> Result<(), OutputError> {
        self.stage_by(path, |target| target.write_all(content))
    }

    /// The same of a content that is not held whole: `write` writes it.
    ///
    /// # Errors
    /// The file cannot be written.
    pub fn stage_by(
        &mut self,
        path: &Path,
        write: impl FnOnce(&mut (dyn Write + Send)) -> io::Result<()>,
    ) -> Result<(), OutputError> {
        if is_standard(path) {
            self.standard = spooled_tempfile(HELD);
            let mut buffered = BufWriter::new(&mut self.standard);
            return write(&mut buffered).and_then(|()| buffered.flush()).map_err(unwritable(path));
        }
        let mut file = new_file(directory(path)).map_err(unwritable(path))?;
        let mut buffered = BufWriter::new(file.as_file_mut());
        write(&mut buffered).and_then(|()| buffered.flush()).map_err(unwritable(path))?;
        drop(buffered);
        self.staged.push((file, path.to_owned()));
        Ok(())
    }

    /// Puts all staged files into their places, and at last writes what goes to standard output.
    ///
    /// # Errors
    /// A file cannot be renamed, or has come into being meanwhile without `force`.
    pub fn commit(mut self) -> Result<(), OutputError> {
        for (file, path) in self.staged {
            let persisted = if self.force { file.persist(&path) } else { file.persist_noclobber(&path) };
            persisted.map_err(|error| match error.error.kind() {
                io::ErrorKind::AlreadyExists => OutputError::Exists(path.clone()),
                _ => unwritable(&path)(error.error),
            })?;
        }
        let copy = |content: &mut SpooledTempFile| {
            content.rewind()?;
            io::copy(content, &mut io::stdout().lock())
        };
        copy(&mut self.standard).map(drop).map_err(unwritable(Path::new(STANDARD_OUTPUT)))
    }
}

/// The directory that a file stands in.
pub fn directory(path: &Path) -> &Path {
    match path.parent() {
        Some(parent) if parent != Path::new("") => parent,
        _ => Path::new("."),
    }
}

/// A file under another name, readable by whom the user's mask allows.
fn new_file(directory: &Path) -> io::Result<NamedTempFile> {
    let mut builder = Builder::new();
    builder.prefix(".mgpi-");
    #[cfg(unix)]
    builder.permissions(std::os::unix::fs::PermissionsExt::from_mode(0o666));
    builder.tempfile_in(directory)
}

fn unwritable(path: &Path) -> impl FnOnce(io::Error) -> OutputError {
    move |source| OutputError::Unwritable { path: path.to_owned(), source }
}
