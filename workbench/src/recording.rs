//! Recordings of a muscle: an input, an output and the time.
//!
//! | column | meaning |
//! |---|---|
//! | `time_s` | strictly increasing; gaps and jitter are allowed and measured ([`Timing`]) |
//! | `pressure_bar`, `command_bar` | the input, the first of them that there is, or the column that is named |
//! | `contraction_mm` | the output, positive when the muscle shortens, or the column that is named |
//! | `length_mm` | instead of the contraction, with the muscle's length at rest |
//! | `valid` | 0: history of the input only, never scored; without the column every row is scored |
//!
//! Further columns (`load_n`, `temperature_c`, `supply_bar`, …) are read with the same strictness and not used
//! here.
//!
//! # Limits
//! An input in bar below -1.1 or above 100 is refused: no muscle sees such a pressure, and a recording in
//! kPa does.

use std::path::{Path, PathBuf};

use crate::figures::{Figures, stroke};
use crate::identification::Problem;
use crate::model_file::{ModelFile, Source};
use crate::table::{DataError, DataProblem, Place, Table, VALID};
use crate::unit::Channel;

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
    /// The muscle's length at rest: the contraction is then this less `length_mm`. Unit: mm.
    pub rest_length_mm: Option<f64>,
    /// The valve's range, checked if given. Unit: that of the input.
    pub input_range: Option<(f64, f64)>,
}

impl Choice {
    /// The columns that a model was identified with.
    pub fn of_model(model: &ModelFile, rest_length_mm: Option<f64>) -> Self {
        Self {
            input: Some(model.input.name.clone()),
            output: Some(model.output.name.clone()),
            rest_length_mm,
            input_range: None,
        }
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
}

/// A recording to learn from or to compare with.
#[derive(Clone, Debug)]
pub struct Recording {
    /// Times and input.
    pub drive: Drive,
    /// The measured output.
    pub output: Series,
}

impl Recording {
    /// Reads a recording with its output.
    ///
    /// # Errors
    /// The file is no table ([`Table::read`]), lacks a column, or breaks the module's contract.
    pub fn read(path: &Path, choice: &Choice) -> Result<Self, DataError> {
        Self::of(&Table::read(path)?, choice)
    }

    /// Takes a recording from a table.
    ///
    /// # Errors
    /// The table lacks a column, or breaks the module's contract.
    pub fn of(table: &Table, choice: &Choice) -> Result<Self, DataError> {
        Ok(Self { drive: Drive::of(table, choice)?, output: output(table, choice)? })
    }

    /// What is to be identified.
    pub fn problem(&self) -> Problem<'_> {
        let Self { drive, output } = self;
        Problem { input: &drive.input.values, output: &output.values, scored: &drive.scored }
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
    /// A column is missing; time does not increase; an input is outside its range; a `valid` is neither 0
    /// nor 1, or none is 1.
    pub fn of(table: &Table, choice: &Choice) -> Result<Self, DataError> {
        let (_, time_s) = table.first_column(&[TIME])?;
        check_times(table, time_s)?;
        let input = match &choice.input {
            Some(name) => series(table, &[name])?,
            None => series(table, &INPUTS)?,
        };
        check_input(table, &input, choice)?;
        Ok(Self {
            file: table.file().to_owned(),
            sha256: table.sha256().to_owned(),
            timing: Timing::of(time_s),
            time_s: time_s.to_vec(),
            input,
            scored: scored(table, time_s.len())?,
        })
    }
}

impl Timing {
    fn of(time_s: &[f64]) -> Self {
        let mut steps: Vec<(f64, f64)> = time_s.windows(2).map(|pair| (pair[1] - pair[0], pair[0])).collect();
        steps.sort_by(|a, b| a.0.total_cmp(&b.0));
        let (median_step_s, _) = steps.get(steps.len() / 2).copied().unwrap_or_default();
        let (largest_step_s, largest_step_at_s) = steps.last().copied().unwrap_or_default();
        let gaps = steps.iter().filter(|(step, _)| *step > GAP_STEPS * median_step_s).count();
        Self { median_step_s, largest_step_s, largest_step_at_s, gaps }
    }
}

/// The measured output of a table.
///
/// # Errors
/// There is no such column; `length_mm` alone, without a rest length.
pub fn output(table: &Table, choice: &Choice) -> Result<Series, DataError> {
    let name = choice.output.as_deref().unwrap_or(CONTRACTION);
    let rest_length_mm = match choice.rest_length_mm {
        Some(rest_length_mm) if name == CONTRACTION => rest_length_mm,
        None if name == CONTRACTION && table.column(name).is_none() && table.column(LENGTH).is_some() => {
            let place = Place { column: Some(LENGTH.to_owned()), ..Place::file(table.file()) };
            return Err(place.error(DataProblem::NoRestLength));
        }
        _ => return series(table, &[name]),
    };
    let length = series(table, &[LENGTH])?;
    Ok(Series {
        channel: Channel { name: CONTRACTION.to_owned(), ..length.channel },
        values: length.values.iter().map(|length_mm| rest_length_mm - length_mm).collect(),
    })
}

fn series(table: &Table, names: &[&str]) -> Result<Series, DataError> {
    let (name, values) = table.first_column(names)?;
    // Only `valid` has no unit: the header was checked.
    let channel = Channel::of_column(name).ok_or_else(|| {
        let column = Some(name.to_owned());
        Place { column, ..Place::file(table.file()) }.error(DataProblem::UnknownUnit)
    })?;
    Ok(Series { channel, values: values.to_vec() })
}

fn check_times(table: &Table, time_s: &[f64]) -> Result<(), DataError> {
    match time_s.windows(2).position(|pair| pair[1] <= pair[0]) {
        None => Ok(()),
        Some(row) => {
            let (previous, value) = (time_s[row], time_s[row + 1]);
            Err(table.place(row + 1, TIME).error(DataProblem::TimeNotIncreasing { value, previous }))
        }
    }
}

fn check_input(table: &Table, input: &Series, choice: &Choice) -> Result<(), DataError> {
    let plausible = (input.channel.unit.suffix() == "bar").then_some(PLAUSIBLE_BAR);
    let ranges = [
        (choice.input_range, "the range of --input-range"),
        (plausible, "the pressures of a muscle: is the column in kPa?"),
    ];
    for (range, why) in ranges {
        let Some((min, max)) = range else { continue };
        if let Some(row) = input.values.iter().position(|value| !(min..=max).contains(value)) {
            let (value, unit) = (input.values[row], input.channel.unit);
            let problem = DataProblem::OutOfRange { value, min, max, unit, why };
            return Err(table.place(row, &input.channel.name).error(problem));
        }
    }
    Ok(())
}

fn scored(table: &Table, rows: usize) -> Result<Vec<bool>, DataError> {
    let Some(flags) = table.column(VALID) else { return Ok(vec![true; rows]) };
    if let Some(row) = flags.iter().position(|flag| ![0.0, 1.0].contains(flag)) {
        return Err(table.place(row, VALID).error(DataProblem::NotAFlag { value: flags[row] }));
    }
    if !flags.contains(&1.0) {
        let place = Place { column: Some(VALID.to_owned()), ..Place::file(table.file()) };
        return Err(place.error(DataProblem::NoValidRow));
    }
    Ok(flags.iter().map(|&flag| flag == 1.0).collect())
}
