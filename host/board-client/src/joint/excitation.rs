//! What a joint is recorded with: both pressures over time.
//!
//! It begins at a vented joint, which is filled and swung through its range: rows until then do not
//! count, since nobody knows where friction is. A file says so by its column `valid`.

use std::path::Path;

use recording::Choice;
use recording::table::{DataError, DataProblem, Table, VALID};
use recording::unit::Unit;
use wire::Protection;

use super::run::PERIOD_S;
use super::start::APPROACH_S;
use crate::pil::PilError;
use crate::pil::reference::Reference;

/// The columns of a file.
const COMMANDS: [&str; 2] = ["command_a_bar", "command_b_bar"];

/// What is played.
#[derive(Clone, Debug)]
pub struct Excitation {
    /// Both pressures at each tick; at least one pair. Unit: bar.
    pub pressures_bar: Vec<[f32; 2]>,
    /// Which of these ticks count, one each; the others are history only.
    pub counts: Vec<bool>,
    /// Torque that acts on the joint from outside, towards larger angles. Unit: N m.
    pub torque_nm: f64,
    /// Every Nth tick is a row.
    pub every: u16,
}

impl Excitation {
    /// That of a file with `time_s`, `command_a_bar`, `command_b_bar` and `valid`, straight between
    /// its rows, and the file's SHA-256. What was done to read it is said on standard error.
    ///
    /// # Errors
    /// The file is no such table; a pressure is outside what a board takes; the first row counts
    /// already.
    pub fn read(
        file: &Path,
        choice: &Choice,
        torque_nm: f64,
        every: u16,
    ) -> Result<(Self, String), PilError> {
        let table = choice.table(file)?;
        let [a, b] = COMMANDS.map(|column| Reference::of(&table, column, choice.clone(), PERIOD_S.recip()));
        let (a, b) = (a?, b?);
        a.say_notes(file);
        for column in COMMANDS {
            check_range(&table, column)?;
        }
        if table.flags()?.is_none() {
            let cure =
                "; it is 0 while the joint is filled and swung through its range, 1 from then on".to_owned();
            return Err(table.missing(VALID, cure).into());
        }
        let counts: Vec<bool> = a.counts().collect();
        if counts[0] {
            return Err(table.place(0, VALID).error(DataProblem::CountsVented).into());
        }
        let pressures_bar = a.points(0.0).zip(b.points(0.0)).map(|(a, b)| [a as f32, b as f32]).collect();
        Ok((Self { pressures_bar, counts, torque_nm, every }, table.sha256().to_owned()))
    }

    /// Its length. Unit: s.
    pub fn duration_s(&self) -> f64 {
        (self.pressures_bar.len() - 1) as f64 * PERIOD_S
    }

    /// Number of the first tick that counts.
    pub fn filled(&self) -> usize {
        self.counts.iter().position(|counts| *counts).unwrap_or(self.counts.len())
    }

    /// Number of ticks that come before what is left, where it goes on after an interruption.
    pub fn lead(&self) -> usize {
        self.filled() + (APPROACH_S / PERIOD_S).round() as usize
    }

    /// What is left of it from a tick on: a vented joint is filled and swung again, and goes to
    /// where it was, none of which counts.
    #[must_use]
    pub fn from_tick(&self, tick: usize) -> Self {
        let tick = tick.min(self.pressures_bar.len() - 1);
        let filled = self.filled();
        let swung = self.pressures_bar[filled.saturating_sub(1)];
        let (there, ticks) = (self.pressures_bar[tick], self.lead() - filled);
        let way = (1..=ticks).map(|passed| {
            let share = passed as f32 / ticks as f32;
            [0, 1].map(|muscle| swung[muscle] + share * (there[muscle] - swung[muscle]))
        });
        let before = self.pressures_bar[..filled].iter().copied().chain(way);
        Self {
            pressures_bar: before.chain(self.pressures_bar[tick..].iter().copied()).collect(),
            counts: std::iter::repeat_n(false, self.lead())
                .chain(self.counts[tick..].iter().copied())
                .collect(),
            ..*self
        }
    }
}

/// Whether a board takes every pressure of a column.
fn check_range(table: &Table, column: &str) -> Result<(), DataError> {
    let Some(found) = table.find(column)? else { return Ok(()) };
    let highest_bar = (f64::from(Protection::STANDARD.overpressure_soft_bar) * 1e4).round() / 1e4;
    let of_bar = |bar| Unit::BAR.convert(bar, found.unit).unwrap_or(bar);
    let (min, max, unit) = (of_bar(0.0), of_bar(highest_bar), found.unit.symbol());
    for (row, value) in table.numbers(found.index)?.numbers.iter().copied().enumerate() {
        if value < min || value > max {
            let why = "what a board of a joint takes";
            let problem = DataProblem::OutOfRange { value, min, max, unit, why };
            return Err(table.place(row, &found.name).error(problem));
        }
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn read(csv: &str) -> Result<Excitation, PilError> {
        let file = tempfile::NamedTempFile::new().expect("a temporary file");
        std::fs::write(&file, csv).expect("written");
        Ok(Excitation::read(file.path(), &Choice::default(), 0.0, 10)?.0)
    }

    #[test]
    fn what_is_left_begins_with_the_filling_and_goes_to_where_it_was() {
        let csv = "time_s,command_a_bar,command_b_bar,valid\n0,0,0,0\n1,2,3,0\n2,3,2,1\n6,5,1,1\n";
        let whole = read(csv).expect("an excitation");
        assert_eq!((whole.filled(), whole.lead(), whole.duration_s()), (2000, 6000, 6.0));
        let left = whole.from_tick(4000);
        assert_eq!(left.pressures_bar[..2000], whole.pressures_bar[..2000]);
        assert_eq!(left.pressures_bar[5999], whole.pressures_bar[4000]);
        assert_eq!(left.pressures_bar[6000..], whole.pressures_bar[4000..]);
        assert_eq!(left.counts.iter().position(|counts| *counts), Some(6000));
        let largest = left.pressures_bar[2000..6000].windows(2).map(|pair| (pair[1][0] - pair[0][0]).abs());
        assert!(largest.fold(0.0, f32::max) < 1e-3, "slowly");
        assert_eq!(whole.from_tick(9000).pressures_bar.len(), 6001, "nothing is left but the end");
    }

    #[test]
    fn what_a_board_does_not_take_is_said_with_line_value_and_limit() {
        for (csv, message) in [
            (
                "time_s,command_a_bar,command_b_bar,valid\n0,0,0,0\n1,2,7,1\n",
                "line 3, column command_b_bar: 7 bar is outside 0 to 6.6 bar, what a board of a joint takes",
            ),
            (
                "time_s,command_a_kpa,command_b_kpa,valid\n0,0,0,0\n1,-2,70,1\n",
                "line 3, column command_a_kpa: -2 kPa is outside 0 to 660 kPa",
            ),
            ("time_s,command_a_bar,command_b_bar\n0,0,0\n1,2,2\n", "no column valid"),
            (
                "time_s,command_a_bar,command_b_bar,valid\n0,0,0,1\n1,2,2,1\n",
                "line 2, column valid: counts from the first row on",
            ),
            ("time_s,command_a_bar,command_b_bar,valid\n0,0,0,0\n1,2,2,0\n", "no row is valid"),
            ("time_s,command_bar\n0,0\n1,2\n", "no column command_a_bar"),
        ] {
            let said = read(csv).expect_err("refused").to_string();
            assert!(said.contains(message), "{said}");
        }
    }
}
