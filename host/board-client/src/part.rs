//! A log that grows in a file beside its place, under its name with `.part` behind it, so that an
//! interruption loses nothing.
//!
//! A thread of its own writes: a disk that is busy may keep a writer waiting for longer than a
//! board bears its host to be silent.

use std::fs::{self, File};
use std::io::{self, Write};
use std::panic::resume_unwind;
use std::path::{Path, PathBuf};
use std::sync::mpsc::{Receiver, Sender, channel};
use std::thread::{self, JoinHandle};

use thiserror::Error;

use recording::input::is_standard;

/// What a log for standard output is called while it grows.
const UNNAMED: &str = "standard-output";

/// Why a log does not grow.
#[derive(Debug, Error)]
#[allow(missing_docs, reason = "the messages say what the variants and their fields are")]
pub enum PartError {
    #[error("{}: there is a part of an earlier run already; --force overwrites it", .0.display())]
    Exists(PathBuf),
    #[error("{}: there is a part of a recording already; --resume continues it, --force replaces it", .0.display())]
    Resumable(PathBuf),
    #[error("{}: no part of a recording to go on with", .0.display())]
    Missing(PathBuf),
    #[error("{}: is a part of the recording of another excitation", .0.display())]
    OtherExcitation(PathBuf),
    #[error("{}: {source}", path.display())]
    Io { path: PathBuf, source: io::Error },
}

/// A log that grows.
#[derive(Debug)]
pub struct Part {
    path: PathBuf,
    rows: usize,
    /// To the writer; none behind the last row.
    sender: Option<Sender<String>>,
    writer: Option<JoinHandle<io::Result<()>>>,
}

impl Part {
    /// Where a log grows.
    pub fn path(log: &Path) -> PathBuf {
        let log = if is_standard(log) { Path::new(UNNAMED) } else { log };
        let mut name = log.as_os_str().to_owned();
        name.push(".part");
        name.into()
    }

    /// Begins a log with these lines. One of an earlier run is overwritten if that is wanted, or if
    /// it has no row.
    ///
    /// # Errors
    /// There is one with rows already, or it cannot be written.
    pub fn begin(log: &Path, head: &str, force: bool) -> Result<Self, PartError> {
        let path = Self::path(log);
        let has_rows =
            || fs::read_to_string(&path).is_ok_and(|text| text.lines().any(|line| time_s(line).is_some()));
        if !force && has_rows() {
            return Err(PartError::Exists(path));
        }
        Self::write(log, head)
    }

    /// Begins a log with these lines, among which may be rows, whatever is in its place.
    ///
    /// # Errors
    /// It cannot be written.
    pub fn write(log: &Path, head: &str) -> Result<Self, PartError> {
        let path = Self::path(log);
        let mut file = File::create(&path).map_err(failed(&path))?;
        file.write_all(head.as_bytes()).map_err(failed(&path))?;
        let (sender, receiver) = channel();
        let writer = thread::spawn(move || write_all(file, &receiver));
        let rows = head.lines().filter(|line| time_s(line).is_some()).count();
        Ok(Self { path, rows, sender: Some(sender), writer: Some(writer) })
    }

    /// Adds rows, which are on their way to the file then.
    ///
    /// # Errors
    /// Earlier ones could not be written.
    pub fn add(&mut self, rows: &str) -> Result<(), PartError> {
        self.rows += rows.lines().count();
        match self.sender.as_ref().map(|sender| sender.send(rows.to_owned())) {
            Some(Ok(())) => Ok(()),
            // A writer that does not listen has failed.
            _ => self.end(),
        }
    }

    /// Waits until all is written.
    fn end(&mut self) -> Result<(), PartError> {
        self.sender = None;
        let written =
            self.writer.take().map(|writer| writer.join().unwrap_or_else(|panic| resume_unwind(panic)));
        written.unwrap_or(Ok(())).map_err(failed(&self.path))
    }

    /// Leaves it where it is; answers the place, if there are rows.
    pub fn keep(mut self) -> Option<PathBuf> {
        // What could be written is there.
        let _ = self.end();
        if self.rows > 0 {
            return Some(self.path);
        }
        // One that stays is no harm: it has no row.
        let _ = fs::remove_file(self.path);
        None
    }

    /// The whole log, to be put in its place; the part goes by [`Finished::remove`].
    ///
    /// # Errors
    /// It cannot be read.
    pub fn finish(mut self) -> Result<Finished, PartError> {
        self.end()?;
        Ok(Finished { content: fs::read(&self.path).map_err(failed(&self.path))?, path: self.path })
    }
}

/// Writes rows as they come, to the last.
fn write_all(mut file: File, rows: &Receiver<String>) -> io::Result<()> {
    rows.iter().try_for_each(|rows| file.write_all(rows.as_bytes()))
}

fn failed(path: &Path) -> impl FnOnce(io::Error) -> PartError {
    move |source| PartError::Io { path: path.to_owned(), source }
}

/// A log that is whole.
#[derive(Debug)]
pub struct Finished {
    path: PathBuf,
    /// The log.
    pub content: Vec<u8>,
}

impl Finished {
    /// Removes the part, when its content is elsewhere.
    pub fn remove(self) {
        // One that stays is no harm: the next run asks what to do with it.
        let _ = fs::remove_file(self.path);
    }
}

/// The time of a row; none of a comment or the header.
pub fn time_s(line: &str) -> Option<f64> {
    line.split(',').next()?.parse().ok()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_part_with_rows_is_kept_and_not_overwritten_unless_forced() {
        let directory = tempfile::tempdir().expect("a temporary directory");
        let log = directory.path().join("log.csv");
        let begin = |force| Part::begin(&log, "time_s,x\n", force);
        assert_eq!(begin(false).expect("begun").keep(), None, "it has no row");
        assert!(!Part::path(&log).exists());
        let mut part = begin(false).expect("begun");
        part.add("0,1\n").expect("written");
        assert_eq!(part.keep(), Some(directory.path().join("log.csv.part")));
        assert!(begin(false).expect_err("refused").to_string().contains("--force overwrites it"));
        let mut part = begin(true).expect("forced");
        part.add("0,2\n").expect("written");
        part.add("1,3\n").expect("written");
        let finished = part.finish().expect("read");
        assert_eq!(finished.content, b"time_s,x\n0,2\n1,3\n");
        finished.remove();
        assert!(!Part::path(&log).exists());
    }
}
