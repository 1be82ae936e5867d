//! Recordings of a muscle: an input, an output and the time.
//!
//! | column | meaning |
//! |---|---|
//! | `time_s` | increasing; gaps and jitter are allowed and measured ([`Timing`]) |
//! | `pressure_bar`, `command_bar` | the input, the first of them that there is, or the column that is named |
//! | `contraction_mm` | the output, positive when the muscle shortens, or the column that is named |
//! | `length_mm` | instead of the contraction, with the muscle's length at rest |
//! | `valid` | 0: history of the input only, never scored; without the column every row is scored |
//!
//! Pressure, command and contraction may have another unit of the same quantity, which the model
//! takes over; a column that a model or another recording asks for is converted to the unit that is
//! asked for. Further columns (`load_n`, `temperature_c`, …) are looked at when they are asked for
//! ([`Drive::beside`]).
//!
//! # Holes
//! A row without a time or an input is left out: between the rows around it there is a gap. A row
//! without an output is history of the input, and not scored.
//!
//! Samples that no muscle can have made are left out, and so are the first ones where their past is
//! unknown ([`LeftOut`]).
//!
//! # Limits
//! A pressure below -1.1 bar or above 100 bar is refused: no muscle sees one, and a recording in
//! kPa that is called bar does. So are rows that are 1 to 1000 s apart, which are milliseconds
//! under another name, until it is said; and a pressure that is a fixed multiple of the command
//! beside it, which has another unit than its name says ([`scales`]).

mod scales;
mod selection;

use std::path::{Path, PathBuf};

use crate::drop_out::take_out;
use crate::figures::{Figures, stroke};
use crate::history::UnknownPast;
use crate::left_out::LeftOut;
use crate::table::clock::increasing;
use crate::table::naming::Naming;
use crate::table::rows::{Rows, fill, holes};
use crate::table::{DataError, DataProblem, Place, Table, VALID};
use crate::unit::{Channel, Unit};
use selection::Times;

/// The column of times.
pub const TIME: &str = "time_s";
/// What a recording may use as its input unless another column is named, the preferred first.
const INPUTS: [&str; 2] = ["pressure_bar", "command_bar"];
const CONTRACTION: &str = "contraction_mm";
const LENGTH: &str = "length_mm";
/// Pressures that a valve and a muscle can have. Unit: bar.
const PLAUSIBLE_BAR: (f64, f64) = (-1.1, 100.0);
/// A step of time that many times the median is a gap.
const GAP_STEPS: f64 = 1.5;

/// Which columns to use, and how.
#[derive(Clone, Debug, Default)]
pub struct Choice {
    /// Input column; by default `pressure_bar`, else `command_bar`.
    pub input: Option<String>,
    /// Output column; by default `contraction_mm`.
    pub output: Option<String>,
    /// Whether the user names input and output by options, `--input` and `--output`, which messages
    /// then tell of.
    pub has_options: bool,
    /// The muscle's length at rest: the contraction is then this less `length_mm`. Unit: mm.
    pub rest_length_mm: Option<f64>,
    /// The valve's range, checked if given. Unit: that of the input.
    pub input_range: Option<(f64, f64)>,
    /// What is said of the file's columns.
    pub naming: Naming,
    /// Whether what would have to be mended is refused.
    pub is_strict: bool,
    /// Whether rows may be far apart: points of a reference, with straight lines between them.
    pub may_be_sparse: bool,
}

impl Choice {
    /// The columns of a model or another recording, whatever else is chosen.
    pub fn like(self, input: &Channel, output: &Channel) -> Self {
        let naming = Naming { known: vec![input.clone(), output.clone()], ..self.naming };
        Self { input: Some(input.name.clone()), output: Some(output.name.clone()), naming, ..self }
    }

    /// Reads a table, and names its columns; `-` is standard input.
    ///
    /// # Errors
    /// The file is no table, or lacks a column that is named.
    pub fn table(&self, file: &Path) -> Result<Table, DataError> {
        let mut table = Table::read(file)?;
        table.name(&self.naming)?;
        Ok(table)
    }
}

/// A column with its unit.
#[derive(Clone, Debug, PartialEq)]
pub struct Series {
    /// The column.
    pub channel: Channel,
    /// A value a row, in the channel's unit.
    pub values: Vec<f64>,
}

/// A file that figures come from.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Source {
    /// The file, as it was named.
    pub file: String,
    /// SHA-256 of its bytes, in hexadecimal.
    pub sha256: String,
}

/// How regular the times of a recording are.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Timing {
    /// Median of the steps. Unit: s.
    pub median_step_s: f64,
    /// The largest step. Unit: s.
    pub largest_step_s: f64,
    /// Where the largest step begins. Unit: s.
    pub largest_step_at_s: f64,
    /// Number of steps above one and a half times the median.
    pub gaps: usize,
}

/// What drives a model: the times and the input of a recording.
#[derive(Clone, Debug)]
pub struct Drive {
    /// The file, as it was named.
    pub file: PathBuf,
    /// SHA-256 of the file's bytes, in hexadecimal.
    pub sha256: String,
    /// Strictly increasing. Unit: s.
    pub time_s: Vec<f64>,
    /// How regular the times are.
    pub timing: Timing,
    /// The input.
    pub input: Series,
    /// Which rows are scored; at least one is.
    pub scored: Vec<bool>,
    /// What was done to read it, a sentence each.
    pub notes: Vec<String>,
    /// The table's rows that it is made of.
    pub rows: Rows,
}

/// A column beside input and output.
#[derive(Clone, Debug)]
pub struct Beside {
    /// A value a row.
    pub values: Vec<f64>,
    /// What was done to read it.
    pub note: Option<String>,
}

/// A recording to learn from or to compare with.
///
/// ```
/// use recording::{Choice, Recording, table::Table};
///
/// let csv = b"time_s,pressure_bar,contraction_mm\n0.0,0.0,0.0\n0.1,1.0,8.0\n0.2,0.0,2.0\n";
/// let table = Table::parse("rec.csv".as_ref(), csv)?;
/// let recording = Recording::of(&table, &Choice { may_be_sparse: true, ..Choice::default() })?;
/// assert_eq!(recording.drive.input.values, [0.0, 1.0, 0.0]);
/// assert_eq!(recording.stroke(), 8.0); // mm
/// # Ok::<(), Box<dyn core::error::Error>>(())
/// ```
#[derive(Clone, Debug)]
pub struct Recording {
    /// Times and input.
    pub drive: Drive,
    /// The measured output.
    pub output: Series,
    /// Which samples are not scored, and why.
    pub left_out: LeftOut,
}

impl Recording {
    /// Reads a recording with its output; `-` is standard input.
    ///
    /// # Errors
    /// The file is no table ([`Table::read`]), lacks a column, or breaks the module's contract.
    pub fn read(path: &Path, choice: &Choice) -> Result<Self, DataError> {
        Self::of(&choice.table(path)?, choice)
    }

    /// Takes a recording from a table.
    ///
    /// # Errors
    /// The table lacks a column, or breaks the module's contract.
    pub fn of(table: &Table, choice: &Choice) -> Result<Self, DataError> {
        let mut drive = Drive::unchecked(table, choice)?;
        let mut output = drive.measured(table, choice)?;
        let Drive { time_s, input, scored, rows, .. } = &mut drive;
        let line = |row: usize| table.place(rows.source(row), TIME).number();
        let drop_outs = take_out(time_s, input, &mut output, line);
        drop_outs.iter().for_each(|drop_out| scored[drop_out.samples.clone()].fill(false));
        check_input(table, input, choice, rows)?;
        let unknown_past = UnknownPast::take_out(time_s, &input.values, &output.values, scored);
        Ok(Self { drive, output, left_out: LeftOut { drop_outs, unknown_past } })
    }

    /// The same with other scored rows.
    pub fn with_scored(&self, scored: Vec<bool>) -> Self {
        Self { drive: Drive { scored, ..self.drive.clone() }, ..self.clone() }
    }

    /// Highest less lowest scored output. Output unit.
    pub fn stroke(&self) -> f64 {
        stroke(&self.output.values, &self.drive.scored)
    }

    /// The figures of a model that answers the input with `simulated`, a value a row, output unit.
    pub fn figures(&self, simulated: &[f64]) -> Figures {
        Figures::of(&self.output.values, simulated, &self.drive.scored)
    }

    /// The file, for the files of models that come from it.
    pub fn source(&self) -> Source {
        Source { file: self.drive.file.display().to_string(), sha256: self.drive.sha256.clone() }
    }

    /// Names of the input and output columns, as words.
    pub fn columns(&self) -> String {
        format!("{} to {}", self.drive.input.channel.name, self.output.channel.name)
    }
}

impl Drive {
    /// Takes times, input and validity from a table.
    ///
    /// # Errors
    /// A column is missing; time goes back; an input is outside its range; a `valid` is neither 0
    /// nor 1, or none is 1.
    pub fn of(table: &Table, choice: &Choice) -> Result<Self, DataError> {
        let drive = Self::unchecked(table, choice)?;
        check_input(table, &drive.input, choice, &drive.rows)?;
        Ok(drive)
    }

    /// The same, the input not yet checked: it may have drop-outs.
    fn unchecked(table: &Table, choice: &Choice) -> Result<Self, DataError> {
        let times = Times::of(table)?;
        let chosen = selection::input(table, choice)?;
        let values = table.numbers(chosen.index)?.numbers;
        let rows = Rows::whole(&[&times.seconds, values]);
        let mut notes = table.notes().to_vec();
        notes.extend(table.decimal_commas(&[times.index, chosen.index]));
        notes.extend(times.note.clone());
        notes.extend(chosen.note());
        notes.extend(selection::left_out(table, &[(&times.seconds, times.column), (values, &chosen.column)]));
        let stamps_s = rows.take(&times.seconds);
        if stamps_s.is_empty() {
            let problem = DataProblem::NoWholeRow(chosen.column.clone());
            return Err(Place::file(table.file()).error(problem));
        }
        let at_time = |row: usize| table.place(rows.source(row), times.column);
        let goes_back = |row: usize| {
            let before = rows.source(row - 1);
            let (previous, value) = (times.seconds[before], times.seconds[rows.source(row)]);
            at_time(row).error(DataProblem::TimeGoesBack { value, previous })
        };
        let first_s = stamps_s[0];
        let count = stamps_s.len();
        // What is written on purpose repeats a time by mistake, not by a logger's habit.
        let repeats = |row: &usize| stamps_s[*row] == stamps_s[row - 1];
        if choice.may_be_sparse
            && let Some(row) = (1..count).find(repeats)
        {
            return Err(at_time(row).error(DataProblem::TimeRepeats(stamps_s[row])));
        }
        let found = increasing(stamps_s).map_err(goes_back)?;
        if found.time_s.len() == 1 && count > 1 {
            return Err(at_time(0).error(DataProblem::TimeStands(first_s)));
        }
        notes.extend(found.note);
        let timing = Timing::of(&found.time_s);
        if !choice.may_be_sparse {
            times.check_step(table, &timing)?;
        }
        let rows = rows.brought_together(found.begins);
        let input = chosen.series(rows.take(values));
        let scored = scored(table, &rows, found.time_s.len())?;
        notes.extend(selection::not_used(table, times.index));
        let drive = Self {
            file: table.file().to_owned(),
            sha256: table.sha256().to_owned(),
            timing,
            time_s: found.time_s,
            input,
            scored,
            notes,
            rows,
        };
        drive.check_strictly(table, choice)?;
        Ok(drive)
    }

    /// Takes the measured output from the same table; rows without one are no longer scored.
    ///
    /// # Errors
    /// There is no such column; `length_mm` alone, without a rest length; no row that is scored has
    /// a value.
    pub fn measured(&mut self, table: &Table, choice: &Choice) -> Result<Series, DataError> {
        let (chosen, rest_length_mm) = selection::output(table, choice)?;
        let mut series = chosen.series(self.rows.take(table.numbers(chosen.index)?.numbers));
        let decimal = table.decimal_commas(&[chosen.index]).filter(|note| !self.notes.contains(note));
        self.notes.extend(decimal.into_iter().chain(chosen.note()));
        let missing = holes(&series.values);
        let count: usize = missing.iter().map(ExactSizeIterator::len).sum();
        missing.into_iter().flatten().for_each(|row| self.scored[row] = false);
        if !self.scored.contains(&true) {
            return Err(table.heading_place(chosen.index).error(DataProblem::NoValue));
        }
        if count > 0 {
            self.notes.push(format!(
                "{count} rows without a value of {} are history of the input only, and are not scored",
                chosen.column
            ));
            fill(&self.time_s, &mut series.values);
        }
        if let Some(rest_length_mm) = rest_length_mm {
            series.channel.name = CONTRACTION.to_owned();
            series.values.iter_mut().for_each(|length_mm| *length_mm = rest_length_mm - *length_mm);
        }
        self.check_strictly(table, choice)?;
        Ok(series)
    }

    /// A column beside input and output, in this unit; `None` if there is no such column.
    ///
    /// # Errors
    /// A field is no number; values are missing, but not as in a column that is sampled more
    /// slowly.
    pub fn beside(&self, table: &Table, name: &str, unit: Unit) -> Result<Option<Beside>, DataError> {
        let found = table.find(name).ok().flatten();
        let Some(found) = found.filter(|found| found.unit.quantity() == unit.quantity()) else {
            return Ok(None);
        };
        let source = table.numbers(found.index)?.numbers;
        let convert = |value: f64| found.unit.convert(value, unit).unwrap_or(value);
        let mut values: Vec<f64> = self.rows.take(source).into_iter().map(convert).collect();
        let missing = holes(&values);
        if missing.is_empty() {
            return Ok(Some(Beside { values, note: None }));
        }
        if !selection::is_sampled_slowly(&values) {
            let row = source.iter().position(|value| value.is_nan()).unwrap_or(0);
            return Err(table.place(row, &found.name).error(DataProblem::Hole));
        }
        fill(&self.time_s, &mut values);
        let note =
            format!("{} is sampled more slowly: straight lines were put between its values", found.name);
        Ok(Some(Beside { values, note: Some(note) }))
    }

    /// Tells the user what was done to read it.
    pub fn announce(&self) {
        for note in &self.notes {
            eprintln!("note: {}: {note}", crate::input::name(&self.file));
        }
    }

    fn check_strictly(&self, table: &Table, choice: &Choice) -> Result<(), DataError> {
        if !choice.is_strict {
            return Ok(());
        }
        match self.notes.first() {
            Some(note) => Err(Place::file(&self.file).error(DataProblem::Mended(note.clone()))),
            None => table.strictly(),
        }
    }
}

impl Timing {
    pub(crate) fn of(time_s: &[f64]) -> Self {
        let mut steps: Vec<(f64, f64)> = time_s.windows(2).map(|pair| (pair[1] - pair[0], pair[0])).collect();
        steps.sort_by(|a, b| a.0.total_cmp(&b.0));
        let (median_step_s, _) = steps.get(steps.len() / 2).copied().unwrap_or_default();
        let (largest_step_s, largest_step_at_s) = steps.last().copied().unwrap_or_default();
        let gaps = steps.iter().filter(|(step, _)| *step > GAP_STEPS * median_step_s).count();
        Self { median_step_s, largest_step_s, largest_step_at_s, gaps }
    }
}

fn check_input(table: &Table, input: &Series, choice: &Choice, rows: &Rows) -> Result<(), DataError> {
    scales::check(table)?;
    let unit = input.channel.unit;
    let (low, high) = PLAUSIBLE_BAR;
    let plausible = Unit::BAR.convert(low, unit).zip(Unit::BAR.convert(high, unit));
    let question = match unit == Unit::BAR {
        true => "the pressures of a muscle: is the column in kPa?",
        false => "the pressures of a muscle: is the unit right?",
    };
    let ranges = [(choice.input_range, "the range of --input-range"), (plausible, question)];
    for (range, why) in ranges {
        let Some((min, max)) = range else { continue };
        if let Some(row) = input.values.iter().position(|value| !(min..=max).contains(value)) {
            let (value, unit) = (input.values[row], unit.symbol());
            let problem = DataProblem::OutOfRange { value, min, max, unit, why };
            return Err(table.place(rows.source(row), &input.channel.name).error(problem));
        }
    }
    Ok(())
}

/// Which of the recording's rows are scored: those whose table's rows are all valid.
fn scored(table: &Table, rows: &Rows, count: usize) -> Result<Vec<bool>, DataError> {
    let Some(index) = table.flags()? else { return Ok(vec![true; count]) };
    let flags = table.numbers(index)?.numbers;
    if let Some(row) = flags.iter().position(|flag| ![0.0, 1.0].contains(flag)) {
        let value = flags[row];
        let problem = if value.is_nan() { DataProblem::Hole } else { DataProblem::NotAFlag { value } };
        return Err(table.place(row, VALID).error(problem));
    }
    let scored: Vec<bool> = rows.take(flags).into_iter().map(|flag| flag >= 1.0).collect();
    if !scored.contains(&true) {
        let place = Place { column: Some(VALID.to_owned()), ..Place::file(table.file()) };
        return Err(place.error(DataProblem::NoValidRow));
    }
    Ok(scored)
}
