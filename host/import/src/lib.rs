//! Files of other programs as tables, of which recordings are made.
//!
//! | file | what it reads |
//! |---|---|
//! | `npy` | NumPy's `.npy`, and `.npz`: several of them in one archive |
//! | `mat` | MATLAB's `.mat` of version 5 (`save` without `-v7.3`, SciPy's `savemat`) |
//! | `sheet` | spreadsheets: `.xlsx`, `.xls`, `.xlsb`, `.ods` |
//!
//! Everything else is text, and read as a recording is ([`Table::read`]). What a file is its first
//! bytes say, not its name.
//!
//! # Contract
//! Numbers are the file's, bit for bit: those of a narrower type are exact in `f64`, but for whole
//! numbers above 2⁵³, which are refused. A matrix is a column each, `name_1`, `name_2`. Columns of
//! another length than the times are no part of the table; they are listed by name.

mod mat;
mod npy;
mod sheet;

use std::fs;
use std::path::{Path, PathBuf};

use recording::table::{DataError, Table};
use thiserror::Error;

/// A variable of a file: its name, and a value a row.
pub type Variable = (String, Vec<f64>);

/// A file as a table.
#[derive(Debug)]
pub struct Imported {
    /// The table.
    pub table: Table,
    /// Variables that are no part of it, each with how many values it has.
    pub left_out: Vec<(String, usize)>,
}

/// What is wrong with a file.
#[derive(Debug, Error)]
#[allow(missing_docs, reason = "the messages say what the variants and their fields are")]
pub enum ImportError {
    #[error(transparent)]
    Data(#[from] DataError),
    #[error("{}: {problem}", file.display())]
    File { file: PathBuf, problem: Problem },
}

/// Each message follows the file's name.
#[derive(Debug, Error)]
#[allow(missing_docs, reason = "the messages say what the variants and their fields are")]
pub enum Problem {
    #[error("cannot be read: {0}")]
    Unreadable(#[from] std::io::Error),
    #[error("cut off or damaged: {0}")]
    Damaged(String),
    #[error(
        "a MAT file of version 7.3; save it again by `save -v7`, or read it in Python: mgpi.Recording takes arrays"
    )]
    Mat73,
    #[error("a Parquet file; read it in Python: mgpi.Recording(pandas.read_parquet(FILE))")]
    Parquet,
    #[error("{name}: {why}")]
    Variable { name: String, why: String },
    #[error("there is no sheet {wanted}; there are {present}")]
    NoSheet { wanted: String, present: String },
    #[error("there is no variable of numbers in it")]
    Nothing,
}

/// Reads a file of whatever kind. `sheet`: of a spreadsheet, else the first one.
///
/// # Errors
/// See [`ImportError`].
pub fn read(file: &Path, sheet: Option<&str>) -> Result<Imported, ImportError> {
    let of_file = |problem| ImportError::File { file: file.to_owned(), problem };
    if recording::input::is_standard(file) {
        return text(file);
    }
    let bytes = fs::read(file).map_err(|error| of_file(error.into()))?;
    let variables = match &bytes[..] {
        [0x93, b'N', b'U', b'M', b'P', b'Y', ..] => npy::array(&stem(file), &bytes),
        [b'P', b'A', b'R', b'1', ..] => Err(Problem::Parquet),
        [b'M', b'A', b'T', b'L', b'A', b'B', ..] => mat::variables(&bytes),
        [0x89, b'H', b'D', b'F', ..] => Err(Problem::Mat73),
        [b'P', b'K', 3 | 5, ..] if npy::is_archive(&bytes) => npy::archive(&bytes),
        [b'P', b'K', 3 | 5, ..] | [0xd0, 0xcf, 0x11, 0xe0, ..] => {
            let text = sheet::text(bytes, sheet).map_err(of_file)?;
            return Ok(Imported { table: Table::parse(file, text.as_bytes())?, left_out: Vec::new() });
        }
        _ => return text(file),
    };
    let (variables, left_out) = of_one_length(variables.map_err(of_file)?);
    let columns: Vec<(&str, &[f64])> =
        variables.iter().map(|(name, values)| (name.as_str(), values.as_slice())).collect();
    if columns.is_empty() {
        return Err(of_file(Problem::Nothing));
    }
    Ok(Imported { table: Table::of_columns(file, &columns)?, left_out })
}

fn text(file: &Path) -> Result<Imported, ImportError> {
    Ok(Imported { table: Table::read(file)?, left_out: Vec::new() })
}

/// The variables that have as many values as most have, of equally many lengths the larger; and the
/// others.
fn of_one_length(variables: Vec<Variable>) -> (Vec<Variable>, Vec<(String, usize)>) {
    let count = |length: usize| variables.iter().filter(|(_, values)| values.len() == length).count();
    let lengths = variables.iter().map(|(_, values)| values.len());
    let length = lengths.max_by_key(|&length| (count(length), length)).unwrap_or(0);
    let (these, others): (Vec<Variable>, Vec<Variable>) =
        variables.into_iter().partition(|(_, values)| values.len() == length);
    (these, others.into_iter().map(|(name, values)| (name, values.len())).collect())
}

/// The columns of a matrix in the order of Fortran, each under a name of its own.
fn columns(name: &str, rows: usize, values: Vec<f64>) -> Vec<Variable> {
    match rows {
        0 => Vec::new(),
        rows if rows == values.len() => vec![(name.to_owned(), values)],
        rows => {
            let named = |(place, column): (usize, &[f64])| (format!("{name}_{}", place + 1), column.to_vec());
            values.chunks(rows).enumerate().map(named).collect()
        }
    }
}

/// A whole number that no `f64` has.
fn whole(name: &str, value: i128) -> Result<f64, Problem> {
    let number = value as f64;
    match number as i128 == value {
        true => Ok(number),
        false => Err(Problem::Variable {
            name: name.to_owned(),
            why: format!("{value} is no number of double precision; store differences to the first one"),
        }),
    }
}

fn stem(file: &Path) -> String {
    file.file_stem().unwrap_or_default().display().to_string()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn variables_of_another_length_are_listed() {
        let named = |name: &str, count| (name.to_owned(), vec![0.0; count]);
        let (these, others) =
            of_one_length(vec![named("rate", 1), named("t", 5), named("p", 5), named("note", 2)]);
        assert_eq!(these.iter().map(|(name, _)| name.as_str()).collect::<Vec<_>>(), ["t", "p"]);
        assert_eq!(others, [("rate".to_owned(), 1), ("note".to_owned(), 2)]);
    }

    #[test]
    fn a_matrix_is_a_column_each() {
        let found = columns("x", 2, vec![1.0, 2.0, 3.0, 4.0]);
        assert_eq!(found, [("x_1".to_owned(), vec![1.0, 2.0]), ("x_2".to_owned(), vec![3.0, 4.0])]);
    }

    #[test]
    fn whole_numbers_that_would_be_rounded_are_refused() {
        assert_eq!(whole("t", 1 << 53).ok(), Some((1_u64 << 53) as f64));
        assert!(whole("t", (1 << 53) + 1).is_err());
    }
}
