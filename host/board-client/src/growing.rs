//! A recording that grows in a file beside its place, so that an interruption costs nothing but the
//! way back: it can be resumed.
//!
//! Where it goes on in its file, and where in its excitation, is the excitation's business: one
//! muscle goes on from a rest ([`crate::bus::recording`]), a joint is filled and swung again
//! ([`crate::joint::seam`]). A comment in the file, the seam, says so.

use std::fs;
use std::io;
use std::path::{Path, PathBuf};

use crate::part::{Finished, Part, PartError, time_s};

/// How the comment of a seam begins; the time behind it is that of the first row after it. Unit: s.
const SEAM: &str = "# interrupted, resumed at ";

/// A recording that grows.
#[derive(Debug)]
pub struct Growing(Part);

/// What there is of a recording that was interrupted.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Reached {
    /// Time of the last whole row, 0 without one. Unit: s.
    pub last_s: f64,
    /// Where it has been resumed before. Unit: s.
    pub seams_s: Vec<f64>,
}

/// Where a recording goes on.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Seam {
    /// Rows from this time on are dropped. Unit: s.
    pub cut_s: f64,
    /// Time of the first row that comes; 0 where it begins from the start. Unit: s.
    pub from_s: f64,
}

/// How a recording with these columns begins; `comments` are lines without their mark.
pub fn head(comments: &[String], columns: &str) -> String {
    let lines: String = comments.iter().map(|line| format!("# {line}\n")).collect();
    format!("{lines}{columns}\n")
}

impl Growing {
    /// Begins a recording with this head.
    ///
    /// # Errors
    /// There is a part with rows already, or it cannot be written.
    pub fn begin(recording: &Path, head: &str, force: bool) -> Result<Self, PartError> {
        let part = Part::begin(recording, head, force).map_err(|error| match error {
            PartError::Exists(file) => PartError::Resumable(file),
            other => other,
        })?;
        Ok(Self(part))
    }

    /// Goes on with a part that begins with the same head, where `at` says.
    ///
    /// # Errors
    /// There is no part, it is another excitation's, or cannot be written.
    pub fn resume(
        recording: &Path,
        head: &str,
        at: impl FnOnce(&Reached) -> Seam,
    ) -> Result<(Self, Seam), PartError> {
        let file = Part::path(recording);
        let text = fs::read_to_string(&file).map_err(|source| match source.kind() {
            io::ErrorKind::NotFound => PartError::Missing(file.clone()),
            _ => PartError::Io { path: file.clone(), source },
        })?;
        let Some(rows) = text.strip_prefix(head) else { return Err(PartError::OtherExcitation(file)) };
        let fields = |line: &str| line.split(',').count();
        let columns = head.lines().last().map_or(0, fields);
        // A row that was cut short by the interruption does not count.
        let is_row = |line: &&str| time_s(line).is_some() && fields(line) == columns;
        let seam = at(&Reached {
            last_s: rows.lines().filter(is_row).filter_map(time_s).fold(0.0, f64::max),
            seams_s: rows.lines().filter_map(seam_s).collect(),
        });
        let is_kept = |line: &&str| match (seam_s(line), time_s(line)) {
            (Some(time_s), _) => time_s < seam.cut_s,
            (None, Some(time_s)) => time_s < seam.cut_s && is_row(line),
            (None, None) => line.starts_with('#'),
        };
        let kept: String = rows.lines().filter(is_kept).map(|line| format!("{line}\n")).collect();
        let said = if seam.from_s > 0.0 { format!("{SEAM}{} s\n", seam.from_s) } else { String::new() };
        let part = Part::write(recording, &format!("{head}{kept}{said}"))?;
        Ok((Self(part), seam))
    }

    /// Adds rows, and gives them to the file.
    ///
    /// # Errors
    /// Earlier ones could not be written.
    pub fn add(&mut self, rows: &str) -> Result<(), PartError> {
        self.0.add(rows)
    }

    /// Leaves it as it is; answers the part, if there are rows to go on from.
    pub fn abandon(self) -> Option<PathBuf> {
        self.0.keep()
    }

    /// The whole recording, to be put in its place; the part goes by [`Finished::remove`].
    ///
    /// # Errors
    /// It cannot be read.
    pub fn finish(self) -> Result<Finished, PartError> {
        self.0.finish()
    }
}

/// The time of a seam; none of any other line.
fn seam_s(line: &str) -> Option<f64> {
    line.strip_prefix(SEAM)?.strip_suffix(" s")?.parse().ok()
}

#[cfg(test)]
mod tests {
    use super::*;

    const HEAD: &str = "# excitation: one\ntime_s,x\n";

    #[test]
    fn what_an_interruption_has_cut_short_is_dropped() {
        let directory = tempfile::tempdir().expect("a temporary directory");
        let recording = directory.path().join("rec.csv");
        fs::write(Part::path(&recording), format!("{HEAD}0,1\n0.5,2\n0.6,3\n0.7")).expect("written");
        let (mut growing, seam) = Growing::resume(&recording, HEAD, |reached| {
            assert_eq!(*reached, Reached { last_s: 0.6, seams_s: Vec::new() });
            Seam { cut_s: 0.6, from_s: 0.6 }
        })
        .expect("the same excitation");
        assert_eq!(seam.from_s, 0.6);
        growing.add("0.6,4\n").expect("written");
        let whole = growing.finish().expect("read").content;
        let expected = format!("{HEAD}0,1\n0.5,2\n# interrupted, resumed at 0.6 s\n0.6,4\n");
        assert_eq!(String::from_utf8(whole).expect("UTF-8"), expected);
        let other = Growing::resume(&recording, "# excitation: two\ntime_s,x\n", |_| seam);
        assert!(other.expect_err("refused").to_string().contains("another excitation"));
    }

    #[test]
    fn a_seam_is_known_again_and_goes_with_the_rows_behind_it() {
        let directory = tempfile::tempdir().expect("a temporary directory");
        let recording = directory.path().join("rec.csv");
        let seams = "1,2\n# interrupted, resumed at 2.5 s\n2.5,3\n# interrupted, resumed at 4 s\n4,3\n";
        fs::write(Part::path(&recording), format!("{HEAD}{seams}")).expect("written");
        let (growing, _) = Growing::resume(&recording, HEAD, |reached| {
            assert_eq!(*reached, Reached { last_s: 4.0, seams_s: vec![2.5, 4.0] });
            Seam { cut_s: 3.0, from_s: 4.0 }
        })
        .expect("the same excitation");
        let whole = growing.finish().expect("read").content;
        assert_eq!(String::from_utf8(whole).expect("UTF-8").matches("resumed at 4 s").count(), 1);
    }

    #[test]
    fn a_part_that_was_resumed_stays_though_no_row_has_come() {
        let directory = tempfile::tempdir().expect("a temporary directory");
        let recording = directory.path().join("rec.csv");
        fs::write(Part::path(&recording), format!("{HEAD}0,1\n")).expect("written");
        let (growing, _) =
            Growing::resume(&recording, HEAD, |_| Seam { cut_s: 1.0, from_s: 1.0 }).expect("resumed");
        assert_eq!(growing.abandon(), Some(Part::path(&recording)));
        assert!(fs::read_to_string(Part::path(&recording)).expect("it is there").contains("0,1\n"));
    }
}
