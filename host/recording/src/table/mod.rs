//! Tables of numbers as loggers write them: read where there is no doubt, with a note on what was
//! done.
//!
//! # Contract
//! The first line that is neither empty nor a comment is the header; every name in it is in small
//! letters and ends in its unit ([`crate::unit::Unit`]), or is `valid`; fields are separated by
//! commas, and every field is a finite number. What differs from that is read too where it has one
//! meaning, and leaves a note; what has two is an error that says which option answers it. Nothing
//! is guessed. A column is looked at when it is asked for ([`Table::find`], [`Table::numbers`]):
//! what is wrong with another one harms nobody.
//!
//! | file | what it does |
//! |---|---|
//! | `encoding` | UTF-8, UTF-16, Windows-1252 |
//! | `pieces` | the text, a piece at a time |
//! | `outline` | what a table's columns are, and its rows a block at a time |
//! | `lines` | comments, blank lines, ends of lines; line numbers |
//! | `layout` | separator, header, lines above it, row of units |
//! | `heading` | a column's name and its unit |
//! | `cell`, `stamp`, `column` | a field; a date or time of day; the fields of a column |
//! | `naming` | the options that name columns and units, and the search for a column |
//! | `clock` | times in seconds; repeated and coarse time stamps |
//! | `rows` | which rows are left out or brought together |
//!
//! # Limits
//! A file is read twice, to see how it is written and to take its numbers, of which 8 bytes a field
//! are held; of an [`Outline`] none. What can be read once only, a pipe, is held whole while it is
//! read. The header has to be in the first megabyte.

mod cell;
pub mod clock;
mod column;
mod encoding;
mod error;
mod heading;
mod layout;
mod lines;
pub mod naming;
pub mod outline;
mod pieces;
pub mod rows;
mod stamp;

use std::path::{Path, PathBuf};

use sha2::{Digest, Sha256};

use crate::unit::Quantity;
use column::Column;
pub use column::{Store, Unkept, Values};
pub use error::{DataError, DataProblem, Place};
use heading::Heading;
use lines::number;
#[cfg(doc)]
use outline::Outline;
use outline::Text;
use pieces::Source;

/// The column of ones and zeros, the only name without a unit.
pub const VALID: &str = "valid";

/// A table of numbers.
///
/// ```
/// use recording::table::Table;
///
/// let csv = b"time_s,pressure_bar\n0.0,0.0\n0.1,1.5\n";
/// let table = Table::parse("rec.csv".as_ref(), csv)?;
/// assert_eq!(table.rows(), 2);
/// assert_eq!(table.first_column(&["pressure_bar"])?.1, [0.0, 1.5]);
/// # Ok::<(), Box<dyn core::error::Error>>(())
/// ```
#[derive(Debug)]
pub struct Table<S = Vec<f64>> {
    file: PathBuf,
    /// Empty in an outline of columns: who reads it asks for no hash.
    sha256: String,
    /// What was done that a strict reader would not.
    notes: Vec<String>,
    /// None of columns in memory.
    header_line: Option<usize>,
    columns: Vec<Column<S>>,
    rows: usize,
    /// Where the line numbers of rows jump: how many rows come before, and the line of the row.
    jumps: Vec<(usize, usize)>,
}

impl Table {
    /// Reads a file; `-` is standard input.
    ///
    /// # Errors
    /// The file cannot be read, or is no table.
    pub fn read(path: &Path) -> Result<Self, DataError> {
        let source =
            Source::of(path).map_err(|error| Place::file(path).error(DataProblem::Unreadable(error)))?;
        Text::of(path, source)?.table()
    }

    /// Reads the contents of a file; `file` is its name in messages.
    ///
    /// # Errors
    /// The contents are no table.
    pub fn parse(file: &Path, bytes: &[u8]) -> Result<Self, DataError> {
        Text::of(file, Source::Bytes(bytes.into()))?.table()
    }

    /// A table of columns that are in memory: each a name and a value a row, NaN where one is
    /// missing. `name` is the table's in messages, which count its rows from 0.
    ///
    /// # Errors
    /// There is no row, or a column is longer than another.
    ///
    /// ```
    /// use recording::table::Table;
    ///
    /// let columns = [("time_s", &[0.0, 0.1][..]), ("pressure_bar", &[0.0, f64::INFINITY])];
    /// let table = Table::of_columns("arrays".as_ref(), &columns)?;
    /// let error = table.first_column(&["pressure_bar"]).unwrap_err();
    /// assert_eq!(error.to_string(), "arrays, row 1, column pressure_bar: `inf` is not finite");
    /// # Ok::<(), Box<dyn core::error::Error>>(())
    /// ```
    pub fn of_columns(name: &Path, columns: &[(&str, &[f64])]) -> Result<Self, DataError> {
        let rows = columns.first().map_or(0, |(_, values)| values.len());
        if rows == 0 {
            return Err(Place::file(name).error(DataProblem::NoRows));
        }
        let mut hash = Sha256::new();
        for (column, values) in columns {
            if values.len() != rows {
                let place = Place { column: Some((*column).to_owned()), ..Place::file(name) };
                return Err(place.error(DataProblem::OtherLength { found: values.len(), expected: rows }));
            }
            hash.update(column);
            values.iter().for_each(|value| hash.update(value.to_le_bytes()));
        }
        Ok(Self {
            file: name.to_owned(),
            sha256: hexadecimal(&hash.finalize()),
            notes: Vec::new(),
            header_line: None,
            columns: columns
                .iter()
                .map(|(column, values)| Column::of_numbers(Heading::of(column), values))
                .collect(),
            rows,
            jumps: Vec::new(),
        })
    }

    /// SHA-256 of the file's bytes, in hexadecimal; of columns in memory that of their names and
    /// numbers.
    pub fn sha256(&self) -> &str {
        &self.sha256
    }

    /// A column's values, one a row; NaN where one is missing.
    ///
    /// # Errors
    /// A field is no number, is infinite, or has a comma that may mean two things.
    pub fn numbers(&self, index: usize) -> Result<Values<'_>, DataError> {
        let are_stamps = self.are_stamps(index)?;
        Ok(Values { numbers: self.columns[index].numbers(), are_stamps })
    }

    /// The values of the first of our own columns that the file has, with its name; none is
    /// missing.
    ///
    /// # Errors
    /// The file has none of the columns, or a field is no finite number.
    pub fn first_column<'a>(&self, names: &[&'a str]) -> Result<(&'a str, &[f64]), DataError> {
        for &name in names {
            if let Some(found) = self.find(name)? {
                let values = self.numbers(found.index)?.numbers;
                if let Some(row) = values.iter().position(|value| value.is_nan()) {
                    return Err(self.place(row, name).error(DataProblem::Hole));
                }
                return Ok((name, values));
            }
        }
        Err(self.missing(&names.join(" or "), String::new()))
    }

    /// What a strict reader says of any column.
    pub fn strictly(&self) -> Result<(), DataError> {
        for (index, column) in self.columns.iter().enumerate() {
            let at = || self.heading_place(index);
            if !column.heading.is_ours() {
                let note = format!("{} is not a name in small letters with its unit", column.heading.shown());
                return Err(at().error(DataProblem::Mended(note)));
            }
            let values = self.numbers(index)?;
            if let Some(row) = values.numbers.iter().position(|value| value.is_nan()) {
                return Err(self.place(row, column.heading.shown()).error(DataProblem::Hole));
            }
        }
        Ok(())
    }
}

impl<S: Store> Table<S> {
    /// The file, as it was named.
    pub fn file(&self) -> &Path {
        &self.file
    }

    /// Number of rows.
    pub fn rows(&self) -> usize {
        self.rows
    }

    /// What was done to read it, a sentence each.
    pub fn notes(&self) -> &[String] {
        &self.notes
    }

    /// The column of flags, if there is one.
    ///
    /// # Errors
    /// There are two.
    pub fn flags(&self) -> Result<Option<usize>, DataError> {
        self.position(VALID)
    }

    /// Number of columns.
    pub fn columns(&self) -> usize {
        self.columns.len()
    }

    /// A column under our name, with its unit if that is known.
    pub fn our_name(&self, index: usize) -> String {
        self.columns[index].heading.name()
    }

    /// Whether an option gives the column its name.
    pub fn is_named(&self, index: usize) -> bool {
        self.columns[index].heading.is_named
    }

    /// A column as it is shown to people: as it stands in the file.
    pub fn shown(&self, index: usize) -> &str {
        self.columns[index].heading.shown()
    }

    /// A column as an option names it: without its unit.
    pub fn as_option(&self, index: usize) -> String {
        self.columns[index].heading.stem_or_raw().to_owned()
    }

    /// The place of a column's name.
    pub fn heading_place(&self, index: usize) -> Place {
        let column = Some(self.columns[index].heading.shown().to_owned());
        Place { line: self.header_line, column, ..Place::file(&self.file) }
    }

    /// Where a value stands; `row` is counted from 0.
    pub fn place(&self, row: usize, column: &str) -> Place {
        let at = Place { column: Some(column.to_owned()), ..Place::file(&self.file) };
        match self.header_line {
            Some(_) => Place { line: Some(number(&self.jumps, row)), ..at },
            None => Place { row: Some(row), ..at },
        }
    }

    /// Whether a column's values are dates or times of day.
    ///
    /// # Errors
    /// A field is no number, is infinite, or has a comma that may mean two things.
    pub fn are_stamps(&self, index: usize) -> Result<bool, DataError> {
        let column = &self.columns[index];
        let at = |row, problem| self.place(row, column.heading.shown()).error(problem);
        let are_stamps = column.are_stamps().map_err(|(row, problem)| at(row, problem))?;
        // Decimal commas are one habit of all that was measured.
        let is_measured = |&(place, peer): &(usize, &Column<S>)| {
            peer.is_numeric() && (place == index || peer.heading.known().is_some())
        };
        let peers = || self.columns.iter().enumerate().filter(is_measured).map(|(_, peer)| peer);
        if let Some((row, value)) = column.first_comma() {
            if !peers().any(Column::has_decimal_commas) {
                return Err(at(row, DataProblem::AmbiguousComma { value }));
            }
            if peers().any(Column::has_points) {
                return Err(at(row, DataProblem::CommaAndPoint { value }));
            }
        }
        Ok(are_stamps)
    }

    /// That numbers have decimal commas, if those of one of the columns do.
    pub fn decimal_commas(&self, indices: &[usize]) -> Option<String> {
        let has_commas = |index: &usize| self.columns[*index].first_comma().is_some();
        indices.iter().any(has_commas).then(|| "numbers were read with decimal commas".to_owned())
    }

    /// That there is no such column; `cure` says how to name it, and begins with a semicolon if it
    /// is not empty.
    pub fn missing(&self, wanted: &str, cure: String) -> DataError {
        let present: Vec<&str> = self.columns.iter().map(|column| column.heading.shown()).collect();
        let (wanted, present) = (wanted.to_owned(), present.join(", "));
        Place::file(&self.file).error(DataProblem::MissingColumn { wanted, present, cure })
    }

    /// The columns that no reader uses, since they have no unit: as they are shown to people.
    pub fn without_unit(&self) -> impl Iterator<Item = (usize, &str)> {
        let columns = self.columns.iter().enumerate();
        columns
            .filter(|(_, column)| column.heading.known().is_none() && column.heading.name() != VALID)
            .map(|(index, column)| (index, column.heading.shown()))
    }

    /// The columns with a unit of this quantity: the name without the unit, and as it is shown to
    /// people.
    pub fn of_quantity(&self, quantity: Quantity) -> impl Iterator<Item = (&str, &str)> {
        let headings = self.columns.iter().map(|column| &column.heading);
        let of_it = headings.filter(move |heading| heading.measures(quantity));
        of_it.map(|heading| (heading.stem.as_str(), heading.shown()))
    }
}

fn hexadecimal(bytes: &[u8]) -> String {
    bytes.iter().map(|byte| format!("{byte:02x}")).collect()
}
