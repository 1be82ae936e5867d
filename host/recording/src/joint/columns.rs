//! A recording of a joint.
//!
//! | column | meaning |
//! |---|---|
//! | `time_s` | increasing |
//! | `command_a_bar`, `command_b_bar` | what either regulator was told, held since the row before |
//! | `pressure_a_bar`, `pressure_b_bar` | in the muscle that turns the joint to larger angles, and in the other one |
//! | `angle_deg` | of the joint |
//! | `torque_newton_metre` | that acts on the joint from outside, towards larger angles |
//! | `valid` | 0: history only, as while the joint is being filled |
//!
//! A gap of more than half a second, for which no board is driven without its host, ends what was
//! recorded in one go: what comes behind it is taken as another recording, whose joint was vented.
//!
//! Several recordings of one joint, as without a weight and with one, are put behind each other.
//!
//! Other units of the same quantity are converted, other names are said by `--columns`.

use std::ops::Range;

use crate::table::{DataError, Table};
use crate::unit::Unit;
use crate::{Choice, Drive, Source};

/// The column that is looked for first: with it a file is a joint's.
const FIRST: &str = "pressure_a_bar";
/// A recording goes on behind a longer gap as another one: the joint was vented. Unit: s.
const GAP_S: f64 = 0.5;
/// But not where its rows are that far apart anyway: that many times the median step.
const GAP_STEPS: f64 = 10.0;
const RAD: &str = "rad";
const TORQUE: &str = "newton_metre";

/// All columns: the first line of a recording.
pub const COLUMNS: &str = "time_s,command_a_bar,command_b_bar,pressure_a_bar,pressure_b_bar,angle_deg,\
                           torque_newton_metre,valid";

/// A recording of a joint.
#[derive(Clone, Debug)]
pub struct JointRecording {
    /// The file.
    pub source: Source,
    /// Unit: s.
    pub time_s: Vec<f64>,
    /// Unit: bar.
    pub commands_bar: [Vec<f64>; 2],
    /// Unit: bar.
    pub pressures_bar: [Vec<f64>; 2],
    /// Unit: rad.
    pub angle_rad: Vec<f64>,
    /// Unit: N m.
    pub torque_nm: Vec<f64>,
    /// Which rows count.
    pub scored: Vec<bool>,
    /// The first row of each recording that was put together.
    pub begins: Vec<usize>,
    /// What was done to read it, a sentence each.
    pub notes: Vec<String>,
}

impl JointRecording {
    /// Takes a recording from a table.
    ///
    /// # Errors
    /// A column is missing, or is not what it should be.
    pub fn of(table: &Table, choice: &Choice) -> Result<Self, DataError> {
        // Its columns have names of their own: no option names an input.
        let choice = Choice { input: Some(FIRST.to_owned()), has_options: false, ..choice.clone() };
        let drive = Drive::of(table, &choice)?;
        let mut notes = drive.notes.clone();
        let unit = |suffix| Unit::of_symbol(suffix).unwrap_or(Unit::BAR);
        let mut column = |name: &str, unit: Unit| {
            let found = drive.beside(table, name, unit)?;
            let found = found.ok_or_else(|| table.missing(name, String::new()))?;
            notes.extend(found.note);
            Ok::<_, DataError>(found.values)
        };
        let commands_bar = [column("command_a_bar", Unit::BAR)?, column("command_b_bar", Unit::BAR)?];
        let pressures_bar = [column(FIRST, Unit::BAR)?, column("pressure_b_bar", Unit::BAR)?];
        let angle_rad = column("angle_deg", unit(RAD))?;
        let torque_nm = column("torque_newton_metre", unit(TORQUE))?;
        let source = Source { file: drive.file.display().to_string(), sha256: drive.sha256.clone() };
        let Drive { time_s, timing, scored, .. } = drive;
        let apart_s = GAP_S.max(GAP_STEPS * timing.median_step_s);
        let is_begin = |row: &usize| time_s[*row] - time_s[row - 1] > apart_s;
        let begins: Vec<usize> = std::iter::once(0).chain((1..time_s.len()).filter(is_begin)).collect();
        Ok(Self { source, time_s, commands_bar, pressures_bar, angle_rad, torque_nm, scored, begins, notes })
    }

    /// This recording with another one of the same joint behind it, a mean step later.
    #[must_use]
    pub fn followed_by(mut self, other: Self) -> Self {
        let count = self.time_s.len();
        let (first_s, last_s) = (self.time_s[0], self.time_s[count - 1]);
        let step_s = (last_s - first_s) / (count.max(2) - 1) as f64;
        let shift_s = last_s + step_s - other.time_s[0];
        self.source.file += &format!(", {}", other.source.file);
        self.source.sha256 += &format!(", {}", other.source.sha256);
        self.time_s.extend(other.time_s.iter().map(|time_s| time_s + shift_s));
        for (mine, others) in
            [(&mut self.commands_bar, other.commands_bar), (&mut self.pressures_bar, other.pressures_bar)]
        {
            mine.iter_mut().zip(others).for_each(|(mine, others)| mine.extend(others));
        }
        self.angle_rad.extend(other.angle_rad);
        self.torque_nm.extend(other.torque_nm);
        self.scored.extend(other.scored);
        self.begins.extend(other.begins.iter().map(|begin| begin + count));
        self.notes.extend(other.notes);
        self
    }

    /// The rows of each recording that was put together.
    pub fn parts(&self) -> impl Iterator<Item = Range<usize>> {
        let ends = self.begins.iter().skip(1).copied().chain([self.time_s.len()]);
        self.begins.iter().copied().zip(ends).map(|(begin, end)| begin..end)
    }
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use super::*;

    fn refused(header: &str) -> String {
        let csv = format!("{header}\n0,1,2\n1,2,3\n");
        let table = Table::parse(Path::new("one.csv"), csv.as_bytes()).expect("a table");
        let choice = Choice { has_options: true, ..Choice::default() };
        JointRecording::of(&table, &choice).expect_err("no joint").to_string()
    }

    #[test]
    fn a_recording_goes_behind_another_by_a_step() {
        let read = |name: &str, begin_s: f64| {
            let row = |row: u32| format!("{},1,2,3,4,5,6,{}\n", begin_s + 0.5 * f64::from(row), row.min(1));
            let csv = format!("{COLUMNS}\n{}{}{}", row(0), row(1), row(2));
            let table = Table::parse(Path::new(name), csv.as_bytes()).expect("a table");
            JointRecording::of(&table, &Choice::default()).expect("a recording")
        };
        let both = read("one.csv", 0.0).followed_by(read("other.csv", 7.0));
        assert_eq!(both.time_s, [0.0, 0.5, 1.0, 1.5, 2.0, 2.5]);
        assert_eq!(both.scored, [false, true, true, false, true, true]);
        assert_eq!(both.parts().collect::<Vec<_>>(), [0..3, 3..6]);
        assert!(both.source.file == "one.csv, other.csv" && both.pressures_bar[1] == [4.0; 6]);
    }

    #[test]
    fn what_was_not_recorded_in_one_go_is_several_recordings() {
        let parts = |times: &[f64]| {
            let rows: String = times.iter().map(|time_s| format!("{time_s},1,2,3,4,5,6,1\n")).collect();
            let csv = format!("{COLUMNS}\n{rows}");
            let table = Table::parse(Path::new("one.csv"), csv.as_bytes()).expect("a table");
            let recording = JointRecording::of(&table, &Choice::default()).expect("a recording");
            recording.parts().collect::<Vec<_>>()
        };
        assert_eq!(parts(&[0.0, 0.01, 0.02, 0.42, 0.43, 1.43, 1.44]), [0..5, 5..7]);
        assert_eq!(parts(&[0.0, 0.1, 0.2, 1.1, 1.2]).len(), 1, "rows that are far apart anyway");
    }

    #[test]
    fn a_recording_of_one_muscle_is_refused_with_the_column_that_may_be_meant() {
        let of_muscle = refused("time_s,pressure_bar,contraction_mm");
        assert!(of_muscle.contains("no column pressure_a_bar"), "{of_muscle}");
        assert!(of_muscle.contains("say --columns pressure_a=pressure_bar"), "{of_muscle}");
        let of_lengths = refused("time_s,length_mm,contraction_mm");
        assert!(!of_lengths.contains("is meant"), "{of_lengths}");
    }
}
