//! What is to be tracked or played: `time_s, reference_mm` (or another column) from a file,
//! linearly interpolated at the instants of the ticks.

use std::path::Path;

use super::PilError;
use super::lock_step::Wanted;
use recording::table::Table;
use recording::{Choice, Drive};

/// The column of the reference.
const COLUMN: &str = "reference_mm";
/// The longest run: 10,000 s at 1 kHz. Three logs of it still fit in a small machine's memory.
pub const MOST_TICKS: usize = 10_000_000;

/// A reference, and how often it is sampled.
#[derive(Clone, Debug)]
pub struct Reference {
    /// Strictly increasing. Unit: s.
    time_s: Vec<f64>,
    /// One a time. Unit: that of the column.
    values: Vec<f64>,
    /// Which rows count.
    scored: Vec<bool>,
    rate_hz: f64,
    ticks: usize,
    /// What a board is given beside the values, one a tick; none where that is nothing.
    correction: Vec<f64>,
    /// What was done to read it, a sentence each.
    notes: Vec<String>,
}

impl Reference {
    /// Reads a reference that is sampled `rate_hz` (above 0) times a second, from its first time to
    /// its last. `choice`: what is said of the file's columns.
    ///
    /// # Errors
    /// The file is no table, lacks a column, its time does not increase, or it has more than
    /// [`MOST_TICKS`] ticks.
    pub fn read(file: &Path, choice: Choice, rate_hz: f64) -> Result<Self, PilError> {
        let reference = Self::of(&choice.table(file)?, COLUMN, choice, rate_hz)?;
        reference.say_notes(file);
        Ok(reference)
    }

    /// Says on standard error what was done to read a file.
    pub fn say_notes(&self, file: &Path) {
        for note in &self.notes {
            eprintln!("note: {}: {note}", recording::input::name(file));
        }
    }

    /// Takes a column of a table, which has been named.
    ///
    /// # Errors
    /// The table lacks a column, its time does not increase, or it has more than [`MOST_TICKS`]
    /// ticks.
    pub fn of(table: &Table, column: &str, choice: Choice, rate_hz: f64) -> Result<Self, PilError> {
        let choice = Choice { input: Some(column.to_owned()), may_be_sparse: true, ..choice };
        let Drive { file, time_s, input, scored, notes, .. } = Drive::of(table, &choice)?;
        // A table has at least one row. The margin is for a last tick that rounding puts behind the
        // last row.
        let duration_s = time_s[time_s.len() - 1] - time_s[0];
        let ticks = (duration_s * rate_hz + 1e-6).floor() + 1.0;
        if ticks > MOST_TICKS as f64 {
            return Err(PilError::TooLong { file, ticks });
        }
        let correction = Vec::new();
        Ok(Self { time_s, values: input.values, scored, rate_hz, ticks: ticks as usize, correction, notes })
    }

    /// Number of ticks, at least 1.
    pub fn ticks(&self) -> usize {
        self.ticks
    }

    /// Lowest and highest value.
    pub fn range(&self) -> (f64, f64) {
        let ends = (f64::INFINITY, f64::NEG_INFINITY);
        self.values.iter().fold(ends, |(lowest, highest), &value| (lowest.min(value), highest.max(value)))
    }

    /// The values from the first time on, so long after it (s, not falling); the last row lasts.
    pub fn values(&self, after_s: impl Iterator<Item = f64>) -> impl Iterator<Item = f64> {
        let mut cursor = Cursor::new(self);
        after_s.map(move |after_s| cursor.at(self.time_s[0] + after_s))
    }

    /// Whether the row at or before every tick counts: whether its `valid` is 1.
    pub fn counts(&self) -> impl Iterator<Item = bool> {
        let mut row = 0;
        (0..self.ticks).map(move |tick| {
            // The margin is for a tick that rounding puts before its row.
            let time_s = self.time_s[0] + (tick as f64 + 1e-6) / self.rate_hz;
            while self.time_s.get(row + 1).is_some_and(|next_s| *next_s <= time_s) {
                row += 1;
            }
            self.scored[row]
        })
    }

    /// The same reference, of which a board is given this much more (one a tick, its unit): what
    /// was learnt for it. What it is measured by stays.
    #[must_use]
    pub fn corrected(&self, correction: &[f64]) -> Self {
        Self { correction: correction.to_vec(), ..self.clone() }
    }

    /// Ticks a second. Unit: Hz.
    pub fn rate_hz(&self) -> f64 {
        self.rate_hz
    }

    /// The correction so long (s) after the first time: straight between ticks, at last the last.
    fn correction(&self, after_s: f64) -> f64 {
        let Some(last) = self.correction.len().checked_sub(1) else { return 0.0 };
        let place = (after_s * self.rate_hz).clamp(0.0, last as f64);
        let from = place.floor();
        let (tick, share) = (from as usize, place - from);
        let (begin, end) = (self.correction[tick], self.correction[(tick + 1).min(last)]);
        begin + share * (end - begin)
    }

    /// What a board is given at every tick, `ahead_s` (0 or more) before it is due; the last row
    /// lasts.
    pub fn points(&self, ahead_s: f64) -> impl Iterator<Item = f64> {
        let times = move |tick: usize| tick as f64 / self.rate_hz + ahead_s;
        let values = self.values((0..self.ticks).map(times));
        values.enumerate().map(move |(tick, value)| value + self.correction(times(tick)))
    }

    /// What is wanted at every tick, and `ahead_s` (0 or more) later; the last row lasts.
    pub fn samples(&self, ahead_s: f64) -> impl Iterator<Item = Wanted> {
        let (mut now, mut ahead) = (Cursor::new(self), Cursor::new(self));
        (0..self.ticks).map(move |tick| {
            let time_s = self.time_s[0] + tick as f64 / self.rate_hz;
            let after_s = tick as f64 / self.rate_hz + ahead_s;
            let ahead_mm = ahead.at(time_s + ahead_s) + self.correction(after_s);
            Wanted { time_s, reference_mm: now.at(time_s), ahead_mm }
        })
    }
}

/// Reads a reference at times that do not fall.
struct Cursor<'a> {
    reference: &'a Reference,
    /// The row before the time.
    row: usize,
}

impl<'a> Cursor<'a> {
    fn new(reference: &'a Reference) -> Self {
        Self { reference, row: 0 }
    }

    /// On the line from the row to the next, not beyond its end; the row itself if it is the last.
    fn at(&mut self, time_s: f64) -> f64 {
        let Reference { time_s: times_s, values, .. } = self.reference;
        while self.row + 2 < times_s.len() && times_s[self.row + 1] <= time_s {
            self.row += 1;
        }
        let (from_s, from) = (times_s[self.row], values[self.row]);
        let Some(to) = values.get(self.row + 1) else { return from };
        let share = (time_s - from_s) / (times_s[self.row + 1] - from_s);
        from + share.min(1.0) * (to - from)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn samples(csv: &str, rate_hz: f64) -> Result<Vec<(f64, f64)>, PilError> {
        let file = tempfile::NamedTempFile::new().expect("a temporary file");
        std::fs::write(&file, csv).expect("written");
        let wanted = |wanted: Wanted| {
            assert_eq!(wanted.ahead_mm, wanted.reference_mm);
            (wanted.time_s, wanted.reference_mm)
        };
        Ok(Reference::read(file.path(), Choice::default(), rate_hz)?.samples(0.0).map(wanted).collect())
    }

    #[test]
    fn a_reference_may_have_other_columns_and_units() -> Result<(), PilError> {
        let file = tempfile::NamedTempFile::new().expect("a temporary file");
        std::fs::write(&file, "t,x\n0,1\n2000,3\n").expect("written");
        let columns = ["time=t:ms", "reference=x:cm"].map(|asked| asked.parse().expect("a column")).to_vec();
        let naming = recording::table::naming::Naming { columns, ..Default::default() };
        let reference = Reference::read(file.path(), Choice { naming, ..Choice::default() }, 1.0)?;
        assert_eq!(reference.points(0.0).collect::<Vec<_>>(), [10.0, 20.0, 30.0]);
        Ok(())
    }

    #[test]
    fn a_reference_ahead_is_the_one_of_later_and_at_last_the_last() {
        let file = tempfile::NamedTempFile::new().expect("a temporary file");
        std::fs::write(&file, "time_s,reference_mm\n0,0\n1,8\n2,4\n").expect("written");
        let reference = Reference::read(file.path(), Choice::default(), 2.0).expect("valid");
        let ahead: Vec<f64> = reference.samples(0.75).map(|wanted| wanted.ahead_mm).collect();
        assert_eq!(ahead, [6.0, 7.0, 5.0, 4.0, 4.0]);
    }

    #[test]
    fn a_tick_counts_if_the_row_before_it_does() {
        let file = tempfile::NamedTempFile::new().expect("a temporary file");
        std::fs::write(&file, "time_s,reference_mm,valid\n0.1,0,0\n0.3,8,1\n0.4,4,0\n").expect("written");
        let reference = Reference::read(file.path(), Choice::default(), 20.0).expect("valid");
        assert_eq!(reference.counts().collect::<Vec<_>>(), [false, false, false, false, true, true, false]);
    }

    #[test]
    fn a_correction_reaches_the_board_ahead_and_not_the_figures() {
        let file = tempfile::NamedTempFile::new().expect("a temporary file");
        std::fs::write(&file, "time_s,reference_mm\n0,0\n1,8\n2,4\n").expect("written");
        let reference = Reference::read(file.path(), Choice::default(), 1.0).expect("valid");
        let corrected = reference.corrected(&[1.0, 2.0, 4.0]);
        let wanted: Vec<(f64, f64)> =
            corrected.samples(0.5).map(|wanted| (wanted.reference_mm, wanted.ahead_mm)).collect();
        assert_eq!(wanted, [(0.0, 5.5), (8.0, 9.0), (4.0, 8.0)]);
        assert_eq!(corrected.points(0.0).collect::<Vec<_>>(), [1.0, 10.0, 8.0]);
    }

    #[test]
    fn a_reference_is_interpolated_between_uneven_rows() {
        let found = samples("time_s,reference_mm\n1,0\n1.5,10\n1.75,10\n2,0\n", 8.0).expect("valid");
        let expected =
            [(1.0, 0.0), (1.125, 2.5), (1.25, 5.0), (1.375, 7.5), (1.5, 10.0), (1.625, 10.0), (1.75, 10.0)];
        assert_eq!(found[..7], expected);
        assert_eq!(found[7..], [(1.875, 5.0), (2.0, 0.0)]);
    }

    #[test]
    fn a_single_row_is_a_single_tick() {
        assert_eq!(samples("time_s,reference_mm\n3,7\n", 1000.0).expect("valid"), [(3.0, 7.0)]);
    }

    #[test]
    fn the_last_row_is_reached_though_its_time_is_no_binary_fraction() {
        let found = samples("time_s,reference_mm\n0,0\n0.3,3\n", 10.0).expect("valid");
        assert_eq!(found.len(), 4);
        assert!((found[3].1 - 3.0).abs() < 1e-12, "{found:?}");
    }

    #[test]
    fn a_reference_longer_than_memory_is_refused() {
        let message =
            samples("time_s,reference_mm\n0,0\n1e12,1\n", 1000.0).expect_err("too long").to_string();
        assert!(message.contains("10000000"), "{message}");
    }
}
