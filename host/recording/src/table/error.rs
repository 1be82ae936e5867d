//! What is wrong with a file of data, and where.

use std::fmt;
use std::io;
use std::path::{Path, PathBuf};

use model_core::InputError;
use thiserror::Error;

use crate::unit::Unit;

/// What is wrong with a file of data, and where.
///
/// ```
/// use recording::table::Table;
///
/// let csv = b"time_s,pressure_bar\n0.0,0.0\n0.1,1.5\n";
/// let table = Table::parse("rec.csv".as_ref(), csv)?;
/// let error = table.first_column(&["contraction_mm"]).unwrap_err().to_string();
/// assert!(error.contains("rec.csv") && error.contains("contraction_mm")); // it names file and column
/// # Ok::<(), Box<dyn core::error::Error>>(())
/// ```
#[derive(Debug, Error)]
#[error("{place}: {problem}")]
pub struct DataError {
    /// Where.
    pub place: Place,
    /// What; boxed, since every reader's result carries it.
    pub problem: Box<DataProblem>,
}

/// A place in a file of data.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Place {
    /// The file, as it was named.
    pub file: PathBuf,
    /// Of a file: counted from 1.
    pub line: Option<usize>,
    /// Of columns in memory: counted from 0.
    pub row: Option<usize>,
    /// Name of the column.
    pub column: Option<String>,
}

impl fmt::Display for Place {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}", crate::input::name(&self.file))?;
        if let Some(line) = self.line {
            write!(f, ", line {line}")?;
        }
        if let Some(row) = self.row {
            write!(f, ", row {row}")?;
        }
        if let Some(column) = &self.column {
            write!(f, ", column {column}")?;
        }
        Ok(())
    }
}

impl Place {
    /// A whole file.
    pub fn file(file: &Path) -> Self {
        Self { file: file.to_owned(), line: None, row: None, column: None }
    }

    /// The line, or the row of what is in memory; 0 of a whole file.
    pub fn number(&self) -> usize {
        self.line.or(self.row).unwrap_or(0)
    }

    /// The error that the problem is at this place.
    pub fn error(self, problem: DataProblem) -> DataError {
        DataError { place: self, problem: Box::new(problem) }
    }
}

/// What can be wrong with data.
#[derive(Debug, Error)]
#[allow(missing_docs, reason = "the messages say what the variants and their fields are")]
pub enum DataProblem {
    #[error("cannot be read: {0}")]
    Unreadable(io::Error),
    #[error("the file is empty")]
    Empty,
    #[error("not a text file: byte {offset} is a NUL")]
    Nul { offset: usize },
    #[error("not a text file: byte {offset} is not UTF-8")]
    NotUtf8 { offset: usize },
    #[error("not a text file: it begins as UTF-16, but is cut off or damaged")]
    NotUtf16,
    #[error("not a table of separated values: {0}")]
    Csv(csv::Error),
    #[error(
        "the file has no header: its first line is `{line}`; write the columns' names above it, such as \
         time_s,pressure_bar,contraction_mm"
    )]
    NoHeader { line: String },
    #[error("the header separates nothing: known are commas, semicolons, tabs, bars and spaces")]
    OneColumn,
    #[error("the name does not end in a known unit; {cure}; known are {}", Unit::known_suffixes())]
    UnknownUnit { cure: String },
    #[error("the unit may be {}; {cure}", choices.join(" or "))]
    AmbiguousUnit { choices: &'static [&'static str], cure: String },
    #[error(
        "the name says {name}, the row of units {row}; --units {column}={name} or --units {column}={row}"
    )]
    TwoUnits { column: String, name: &'static str, row: &'static str },
    #[error("{found} was meant, but the unit is {is}")]
    OtherQuantity { found: &'static str, is: &'static str },
    #[error("the column appears twice")]
    DoubledColumn,
    #[error("no column {wanted}; the file has {present}{cure}")]
    MissingColumn { wanted: String, present: String, cure: String },
    #[error("is a length; --rest-length MM is needed to turn it into a contraction")]
    NoRestLength,
    #[error("{found} fields where the header has {expected}")]
    Ragged { found: usize, expected: usize },
    #[error(
        "{found} fields where the header has {expected}: decimal commas split the numbers; export with \
         decimal points, or with semicolons between the fields"
    )]
    SplitNumbers { found: usize, expected: usize },
    #[error(
        "`{value}` may have a decimal comma or a comma between thousands; export the file without commas \
         between thousands"
    )]
    AmbiguousComma { value: String },
    #[error("`{value}` has a comma, other numbers have points; export the file with one of the two")]
    CommaAndPoint { value: String },
    #[error("`{value}` is not a number")]
    NotANumber { value: String },
    #[error("`{value}` is not a known time; write 2024-05-01T13:02:03.25, or a number with its unit")]
    NotATime { value: String },
    #[error("`{value}` is not finite")]
    NotFinite { value: String },
    #[error("no value: the field is empty, or says that there is none")]
    Hole,
    #[error("{found} values where the first column has {expected}")]
    OtherLength { found: usize, expected: usize },
    #[error("no row of data below the header")]
    NoRows,
    #[error("no row has both a time and a value of {0}")]
    NoWholeRow(String),
    #[error("the column has no value in the rows that are scored")]
    NoValue,
    #[error("{value} is neither 0 nor 1")]
    NotAFlag { value: f64 },
    #[error("no row is valid: the column is 0 everywhere")]
    NoValidRow,
    #[error(
        "counts from the first row on, where the joint is vented: let it be 0 while the joint is filled and swung \
         through its range"
    )]
    CountsVented,
    #[error("{0}")]
    Refused(InputError),
    #[error(
        "time goes back: {value} s follows {previous} s; the clock was set, or two recordings were joined: \
         split the file there, or sort its rows"
    )]
    TimeGoesBack { value: f64, previous: f64 },
    #[error("time does not increase: {0} s stands in two rows of a reference")]
    TimeRepeats(f64),
    #[error("all rows have the same time, {0} s")]
    TimeStands(f64),
    #[error(
        "the rows are {step_s} s apart in the middle: are these milliseconds? --units {column}={smaller} if so, \
         --units {column}={unit} if they are right"
    )]
    SlowRows { step_s: f64, column: String, smaller: &'static str, unit: &'static str },
    #[error(
        "{values}, in one ratio throughout: is it in {likelier}? --units {column}={likelier} if so, \
         --units {column}={said} if the name is right"
    )]
    OtherScale { values: String, column: String, said: &'static str, likelier: &'static str },
    #[error(
        "is {is}, but {} has {wanted}: recordings of one model have the same input and output, in the same units",
        crate::input::name(first)
    )]
    OtherColumn { is: String, first: PathBuf, wanted: String },
    #[error("is the same recording as {}: each counts once", crate::input::name(.0))]
    SameFile(PathBuf),
    #[error("--strict refuses what would have to be mended: {0}")]
    Mended(String),
    #[error("{value} {unit} is outside {min} to {max} {unit}, {why}")]
    OutOfRange { value: f64, min: f64, max: f64, unit: &'static str, why: &'static str },
}
