//! Strict reading of a CSV file of numbers.
//!
//! # Contract
//! The first line that is neither empty nor a comment (`#`) is the header; every name in it is lower case and
//! ends in a known unit ([`Unit`]), or is `valid`. Every row has as many fields as the header, and every field
//! is a finite number. A byte-order mark and CRLF line ends are accepted. What breaks this is refused by a
//! [`DataError`] that says where.
//!
//! # Limits
//! The whole file is held in memory.

use std::fmt;
use std::fs;
use std::io;
use std::path::{Path, PathBuf};

use model_core::InputError;
use sha2::{Digest, Sha256};
use thiserror::Error;

use crate::unit::Unit;

/// The column of ones and zeros, the only name without a unit.
pub const VALID: &str = "valid";

/// What is wrong with a file of data, and where.
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
    /// Counted from 1.
    pub line: Option<usize>,
    /// Name of the column.
    pub column: Option<String>,
}

impl fmt::Display for Place {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}", self.file.display())?;
        if let Some(line) = self.line {
            write!(f, ", line {line}")?;
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
        Self { file: file.to_owned(), line: None, column: None }
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
    #[error("not a table of comma-separated values: {0}")]
    Csv(csv::Error),
    #[error("the header is separated by `{found}`; fields are separated by commas")]
    Separator { found: char },
    #[error("the name is not in lower case")]
    NotLowerCase,
    #[error("the name does not end in a known unit; known are {}", Unit::known_suffixes())]
    UnknownUnit,
    #[error("the column appears twice")]
    DoubledColumn,
    #[error("no column {wanted}; the file has {present}")]
    MissingColumn { wanted: String, present: String },
    #[error("is a length; --rest-length MM is needed to turn it into a contraction")]
    NoRestLength,
    #[error("{found} fields where the header has {expected}")]
    Ragged { found: usize, expected: usize },
    #[error("`{value}` is not a number")]
    NotANumber { value: String },
    #[error("`{value}` is not finite")]
    NotFinite { value: String },
    #[error("no row of data below the header")]
    NoRows,
    #[error("{value} is neither 0 nor 1")]
    NotAFlag { value: f64 },
    #[error("no row is valid: the column is 0 everywhere")]
    NoValidRow,
    #[error("{0}")]
    Refused(InputError),
    #[error("time does not increase: {value} s follows {previous} s")]
    TimeNotIncreasing { value: f64, previous: f64 },
    #[error("{value} {unit} is outside {min} to {max} {unit}, {why}")]
    OutOfRange { value: f64, min: f64, max: f64, unit: Unit, why: &'static str },
}

/// A table of finite numbers.
#[derive(Debug)]
pub struct Table {
    file: PathBuf,
    sha256: String,
    names: Vec<String>,
    /// By column, then by row.
    columns: Vec<Vec<f64>>,
    /// Where each row stands in the file, from 1.
    lines: Vec<usize>,
}

impl Table {
    /// Reads a file.
    ///
    /// # Errors
    /// The file cannot be read, or breaks the module's contract.
    pub fn read(path: &Path) -> Result<Self, DataError> {
        let bytes =
            fs::read(path).map_err(|error| Place::file(path).error(DataProblem::Unreadable(error)))?;
        Self::parse(path, &bytes)
    }

    /// Reads the contents of a file; `file` is its name in messages.
    ///
    /// # Errors
    /// The contents break the module's contract.
    pub fn parse(file: &Path, bytes: &[u8]) -> Result<Self, DataError> {
        let refuse = |problem| Place::file(file).error(problem);
        let text = text(bytes).map_err(refuse)?;
        // The lines that count, and where they stand: the csv crate gives a record the line of the comment
        // before it.
        let (lines, content): (Vec<usize>, Vec<&str>) = (1..)
            .zip(text.lines())
            .filter(|(_, line)| !line.starts_with('#') && !line.trim().is_empty())
            .unzip();
        let content = content.join("\n");
        let mut reader =
            csv::ReaderBuilder::new().flexible(true).trim(csv::Trim::All).from_reader(content.as_bytes());
        let names: Vec<String> = match reader.headers() {
            Ok(header) if header.is_empty() => return Err(refuse(DataProblem::Empty)),
            Ok(header) => header.iter().map(str::to_owned).collect(),
            Err(error) => return Err(refuse(DataProblem::Csv(error))),
        };
        let mut table = Self {
            file: file.to_owned(),
            sha256: sha256_hex(bytes),
            columns: vec![Vec::new(); names.len()],
            names,
            lines: Vec::new(),
        };
        table.check_header(lines[0])?;
        for record in reader.records() {
            let record = record.map_err(|error| refuse(DataProblem::Csv(error)))?;
            let first = record.position().map_or(1, csv::Position::line) as usize;
            table.push(lines[first - 1], &record)?;
        }
        if table.lines.is_empty() {
            return Err(refuse(DataProblem::NoRows));
        }
        Ok(table)
    }

    fn check_header(&self, line: usize) -> Result<(), DataError> {
        let place = |column: Option<&str>| Place {
            file: self.file.clone(),
            line: Some(line),
            column: column.map(str::to_owned),
        };
        if let [only] = self.names.as_slice()
            && let Some(found) = only.chars().find(|c| matches!(c, ';' | '\t'))
        {
            return Err(place(None).error(DataProblem::Separator { found }));
        }
        for (i, name) in self.names.iter().enumerate() {
            let problem = if name.chars().any(char::is_uppercase) {
                DataProblem::NotLowerCase
            } else if name != VALID && Unit::of_column(name).is_none() {
                DataProblem::UnknownUnit
            } else if self.names[..i].contains(name) {
                DataProblem::DoubledColumn
            } else {
                continue;
            };
            return Err(place(Some(name)).error(problem));
        }
        Ok(())
    }

    fn push(&mut self, line: usize, record: &csv::StringRecord) -> Result<(), DataError> {
        let row = self.lines.len();
        self.lines.push(line);
        if record.len() != self.names.len() {
            let (found, expected) = (record.len(), self.names.len());
            return Err(Place { line: Some(line), ..Place::file(&self.file) }
                .error(DataProblem::Ragged { found, expected }));
        }
        for (i, field) in record.iter().enumerate() {
            let value = field.to_owned();
            let problem = match field.parse::<f64>() {
                Ok(number) if number.is_finite() => {
                    self.columns[i].push(number);
                    continue;
                }
                Ok(_) => DataProblem::NotFinite { value },
                Err(_) => DataProblem::NotANumber { value },
            };
            return Err(self.place(row, &self.names[i]).error(problem));
        }
        Ok(())
    }

    /// The file, as it was named.
    pub fn file(&self) -> &Path {
        &self.file
    }

    /// SHA-256 of the file's bytes, in hexadecimal.
    pub fn sha256(&self) -> &str {
        &self.sha256
    }

    /// The column's values, one a row, `None` if the file has no such column.
    pub fn column(&self, name: &str) -> Option<&[f64]> {
        let index = self.names.iter().position(|present| present == name)?;
        Some(&self.columns[index])
    }

    /// The first of the columns that the file has, with its name.
    ///
    /// # Errors
    /// The file has none of them.
    pub fn first_column<'a>(&self, names: &[&'a str]) -> Result<(&'a str, &[f64]), DataError> {
        names.iter().find_map(|&name| Some((name, self.column(name)?))).ok_or_else(|| {
            Place::file(&self.file).error(DataProblem::MissingColumn {
                wanted: names.join(" or "),
                present: self.names.join(", "),
            })
        })
    }

    /// Where a value stands; `row` is counted from 0.
    pub fn place(&self, row: usize, column: &str) -> Place {
        Place { file: self.file.clone(), line: Some(self.lines[row]), column: Some(column.to_owned()) }
    }
}

fn text(bytes: &[u8]) -> Result<&str, DataProblem> {
    if let Some(offset) = bytes.iter().position(|&byte| byte == 0) {
        return Err(DataProblem::Nul { offset });
    }
    let text =
        std::str::from_utf8(bytes).map_err(|error| DataProblem::NotUtf8 { offset: error.valid_up_to() })?;
    Ok(text.strip_prefix('\u{feff}').unwrap_or(text))
}

fn sha256_hex(bytes: &[u8]) -> String {
    Sha256::digest(bytes).iter().map(|byte| format!("{byte:02x}")).collect()
}
