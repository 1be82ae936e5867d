//! A recording that grows in a file beside its place, so that an interruption costs nothing but the
//! way back.
//!
//! # Going on
//! An interruption vents the muscle, and what it did before matters for what it does after. So a
//! recording goes on from the last moment at which the excitation was at its lowest command, where
//! a vented muscle is anyway; what was recorded after that is played again.

use std::fs;
use std::path::{Path, PathBuf};

use super::error::{BoardError, PartProblem};
use super::play::{POINTS_PER_S, Tick};
use crate::part::{Finished, Part, PartError, time_s};

/// The columns of a recording.
const COLUMNS: &str = "time_s,command_bar,pressure_bar,contraction_mm";
/// How far from the lowest point of an excitation is still lowest. Unit: bar.
const LOWEST_BAR: f32 = 1e-3;

/// A recording that grows.
#[derive(Debug)]
pub struct Growing {
    file: PathBuf,
    part: Part,
    /// Where in the excitation it goes on. Unit: s.
    from_s: f64,
}

impl Growing {
    /// Begins a recording; `head` are its first lines, comments.
    ///
    /// # Errors
    /// There is a part with rows already, or it cannot be written.
    pub fn begin(recording: &Path, head: &[String], force: bool) -> Result<Self, BoardError> {
        let part = Part::begin(recording, &begin(head), force).map_err(|error| match error {
            PartError::Exists(file) => problem(&file)(PartProblem::Exists),
            other => other.into(),
        })?;
        Ok(Self { part, file: Part::path(recording), from_s: 0.0 })
    }

    /// Goes on with a part that begins with the same comments, of the excitation with these points
    /// (bar).
    ///
    /// # Errors
    /// There is no part, it is another excitation's, or cannot be written.
    pub fn resume(recording: &Path, head: &[String], points: &[f32]) -> Result<Self, BoardError> {
        let file = Part::path(recording);
        if !file.exists() {
            return Err(problem(&file)(PartProblem::Missing));
        }
        let text = fs::read_to_string(&file).map_err(|error| problem(&file)(error.into()))?;
        if !text.starts_with(&begin(head)) {
            return Err(problem(&file)(PartProblem::OtherExcitation));
        }
        let reached_s = text.lines().filter_map(time_s).fold(0.0, f64::max);
        let from_s = rest_before(points, reached_s);
        let keep = |line: &&str| time_s(line).is_none_or(|time_s| time_s < from_s) && !line.is_empty();
        // A row that the interruption has cut short has a later time or none, and is no comment.
        let kept: String = text
            .lines()
            .filter(keep)
            .filter(|line| line.starts_with('#') || line.split(',').count() == COLUMNS.split(',').count())
            .map(|line| format!("{line}\n"))
            .collect();
        let seam =
            if from_s > 0.0 { format!("# interrupted, resumed at {from_s} s\n") } else { String::new() };
        Ok(Self { part: Part::write(recording, &(kept + &seam))?, file, from_s })
    }

    /// Where in the excitation it goes on. Unit: s.
    pub fn from_s(&self) -> f64 {
        self.from_s
    }

    /// Number of the point at which it goes on.
    pub fn from_point(&self) -> usize {
        (self.from_s * POINTS_PER_S).round() as usize
    }

    /// Adds ticks, and gives them to the file.
    ///
    /// # Errors
    /// They cannot be written.
    pub fn add(&mut self, ticks: &[Tick]) -> Result<(), BoardError> {
        let mut rows = String::new();
        for Tick { time_s, pressure_bar, contraction_mm, command_bar, .. } in ticks {
            // Six digits of a second, as the ticks have.
            let time_s = ((time_s + self.from_s) * 1e6).round() / 1e6;
            rows += &format!("{time_s},{command_bar},{pressure_bar},{contraction_mm}\n");
        }
        Ok(self.part.add(&rows)?)
    }

    /// Leaves it as it is; answers the part, if there are rows to go on from.
    pub fn abandon(self) -> Option<PathBuf> {
        if self.from_s > 0.0 { Some(self.file) } else { self.part.keep() }
    }

    /// The whole recording, to be put in its place; the part goes by [`Finished::remove`].
    ///
    /// # Errors
    /// It cannot be read.
    pub fn finish(self) -> Result<Finished, BoardError> {
        Ok(self.part.finish()?)
    }
}

fn problem(file: &Path) -> impl Fn(PartProblem) -> BoardError {
    let file = file.to_owned();
    move |problem| BoardError::Part { file: file.clone(), problem }
}

/// How a recording begins.
fn begin(head: &[String]) -> String {
    let lines: String = head.iter().map(|line| format!("# {line}\n")).collect();
    format!("{lines}{COLUMNS}\n")
}

/// The last time up to which an excitation has been played and at which it was lowest. Unit: s.
fn rest_before(points: &[f32], reached_s: f64) -> f64 {
    let lowest = points.iter().copied().fold(f32::INFINITY, f32::min) + LOWEST_BAR;
    let reached = points.iter().take((reached_s * POINTS_PER_S) as usize + 1);
    reached.into_iter().rposition(|&point| point <= lowest).map_or(0.0, |place| place as f64 / POINTS_PER_S)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_recording_goes_on_from_its_last_rest() {
        let mut points = vec![0.0; 100];
        points.extend((0..100).map(|point| point as f32 / 50.0));
        points.extend([0.0; 100]);
        for (reached_s, from_s) in [(0.0, 0.0), (0.5, 0.5), (1.7, 1.0), (2.0, 2.0), (2.5, 2.5), (9.0, 2.99)] {
            assert_eq!(rest_before(&points, reached_s), from_s, "after {reached_s} s");
        }
        assert_eq!(rest_before(&[1.0, 2.0], 0.01), 0.0);
    }

    #[test]
    fn what_an_interruption_has_cut_short_is_dropped() {
        let directory = tempfile::tempdir().expect("a temporary directory");
        let (recording, head) = (directory.path().join("rec.csv"), ["excitation: one".to_owned()]);
        let text = begin(&head) + "0,0,0,1\n0.5,1,1,2\n0.51,1,1\n";
        fs::write(Part::path(&recording), text).expect("written");
        let points: Vec<f32> = (0..100).map(|point| if point < 51 { 0.0 } else { 1.0 }).collect();
        let mut growing = Growing::resume(&recording, &head, &points).expect("the same excitation");
        assert_eq!((growing.from_s(), growing.from_point()), (0.5, 50));
        growing.add(&[Tick { command_bar: 1.0, ..Tick::default() }]).expect("written");
        let whole = growing.finish().expect("read").content;
        let expected = begin(&head) + "0,0,0,1\n# interrupted, resumed at 0.5 s\n0.5,1,0,0\n";
        assert_eq!(String::from_utf8(whole).expect("UTF-8"), expected);
        assert!(Growing::resume(&recording, &["excitation: two".to_owned()], &points).is_err());
    }
}
