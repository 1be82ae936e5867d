//! A log that grows in a file beside its place, under its name with `.part` behind it, so that an interruption loses nothing.

use std::fs::{self, File};
use std::io::{self, BufWriter, Write};
use std::path::{Path, PathBuf};

use thiserror::Error;

/// Why a log does not grow.
#[derive(Debug, Error)]
#[allow(missing_docs, reason = "the messages say what the variants and their fields are")]
pub enum PartError {
    #[error("{}: there is a part of an earlier run already; --force overwrites it", .0.display())]
    Exists(PathBuf),
    #[error("{}: {source}", path.display())]
    Io { path: PathBuf, source: io::Error },
}

/// A log that grows.
#[derive(Debug)]
pub struct Part {
    path: PathBuf,
    writer: BufWriter<File>,
    rows: usize,
}

impl Part {
    /// Where a log grows.
    pub fn path(log: &Path) -> PathBuf {
        let mut name = log.as_os_str().to_owned();
        name.push(".part");
        name.into()
    }

    /// Begins a log with these lines. One of an earlier run is overwritten if that is wanted, or if it has no row.
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

    /// Begins a log with these lines, whatever is in its place.
    ///
    /// # Errors
    /// It cannot be written.
    pub fn write(log: &Path, head: &str) -> Result<Self, PartError> {
        let path = Self::path(log);
        let begun = File::create(&path).map(BufWriter::new).and_then(|mut writer| {
            writer.write_all(head.as_bytes())?;
            Ok(writer)
        });
        let writer = begun.map_err(failed(&path))?;
        Ok(Self { path, writer, rows: 0 })
    }

    /// Adds rows, and gives them to the file.
    ///
    /// # Errors
    /// They cannot be written.
    pub fn add(&mut self, rows: &str) -> Result<(), PartError> {
        self.rows += rows.lines().count();
        let written = self.writer.write_all(rows.as_bytes()).and_then(|()| self.writer.flush());
        written.map_err(failed(&self.path))
    }

    /// Leaves it where it is; answers the place, if there are rows.
    pub fn keep(self) -> Option<PathBuf> {
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
        let read = self.writer.flush().and_then(|()| fs::read(&self.path));
        Ok(Finished { content: read.map_err(failed(&self.path))?, path: self.path })
    }
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
        let finished = part.finish().expect("read");
        assert_eq!(finished.content, b"time_s,x\n0,2\n");
        finished.remove();
        assert!(!Part::path(&log).exists());
    }
}
