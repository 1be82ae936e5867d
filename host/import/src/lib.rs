//! Files of other programs as tables, of which recordings are made.
//!
//! | file | what it reads | feature |
//! |---|---|---|
//! | `npy` | NumPy's `.npy`, and `.npz`: several of them in one archive | |
//! | `mat` | MATLAB's `.mat` of version 5 (`save` without `-v7.3`, SciPy's `savemat`) | |
//! | `sheet` | spreadsheets: `.xlsx`, `.xls`, `.xlsb`, `.ods` | |
//! | `hdf5` | HDF5, and MATLAB's `.mat` of version 7.3 | `hdf5` |
//! | `parquet` | Parquet | `parquet` |
//! | `bag` | MCAP, ROS 2's bags | `mcap` |
//!
//! `to_parquet` writes Parquet (feature `parquet`).
//!
//! Everything else is text, and read as a recording is ([`Table::read`]). What a file is its first
//! bytes say, not its name.
//!
//! # Contract
//! Numbers are the file's, bit for bit: those of a narrower type are exact in `f64`, but for whole
//! numbers above 2⁵³, which are refused. A matrix is a column each, `name_1`, `name_2`. Columns of
//! another length than the times are no part of the table; they are listed by name.

#[cfg(feature = "mcap")]
mod bag;
#[cfg(feature = "hdf5")]
mod hdf5;
mod mat;
mod npy;
mod number;
#[cfg(feature = "parquet")]
mod parquet;
mod sheet;
#[cfg(feature = "parquet")]
pub mod to_parquet;

use std::fs::{self, File};
use std::io::Read;
use std::ops::Range;
use std::path::{Path, PathBuf};

use recording::table::naming::Renamed;
use recording::table::outline::Outline;
use recording::table::{DataError, Table};
use thiserror::Error;

/// A variable of a file: its name, and a value a row.
pub type Variable = (String, Vec<f64>);

/// The values of a column that is written.
#[derive(Clone, Copy, Debug)]
pub enum Values<'a> {
    /// Numbers; NaN stands for a missing one.
    Numbers(&'a [f64]),
    /// Words; an empty one stands for a missing one.
    Words(&'a [String]),
}

impl Values<'_> {
    /// How many there are.
    pub fn len(&self) -> usize {
        match self {
            Self::Numbers(values) => values.len(),
            Self::Words(values) => values.len(),
        }
    }

    /// Those of some rows.
    pub fn part(&self, rows: Range<usize>) -> Self {
        match self {
            Self::Numbers(values) => Self::Numbers(&values[rows]),
            Self::Words(values) => Self::Words(&values[rows]),
        }
    }

    /// Whether there are none.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }
}

/// A file as a table.
#[derive(Debug)]
pub struct Imported {
    /// The table.
    pub table: Table,
    /// Variables that are no part of it, each with how many values it has.
    pub left_out: Vec<(String, usize)>,
    /// What was done to make it one, in words.
    pub notes: Vec<String>,
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
    #[error("{0}, which this mgpi was built without: the feature {1} of cargo")]
    NotBuilt(&'static str, &'static str),
    #[error(
        "a bag of SQLite; convert it: `ros2 bag convert`, or `rosbags-convert --src BAG --dst BAG.mcap` of the package rosbags"
    )]
    Sqlite,
    #[error("a folder without a .mcap file of a bag")]
    Folder,
    #[error("a folder with several .mcap files: {0}; name one")]
    SeveralParts(String),
    #[error("there is no topic {wanted} with numbers; there are {present}")]
    NoTopic { wanted: String, present: String },
    #[error("there is no variable {wanted}; there are {present}")]
    NoVariable { wanted: String, present: String },
    #[error("{name}: {why}")]
    Variable { name: String, why: String },
    #[error("there is no sheet {wanted}; there are {present}")]
    NoSheet { wanted: String, present: String },
    #[error("there is no variable of numbers in it")]
    Nothing,
}

/// What the user says of a file.
#[derive(Clone, Copy, Debug, Default)]
pub struct Options<'a> {
    /// The sheet of a spreadsheet, else the first one.
    pub sheet: Option<&'a str>,
    /// The variables to import; all of them if this is empty.
    pub columns: &'a [Renamed],
    /// The topic of a bag whose times the recording has.
    pub clock: Option<&'a str>,
}

/// The name of the times of a bag.
#[cfg(feature = "mcap")]
const TIME_COLUMN: &str = "time_s";
/// As many bytes as tell what a file is: MATLAB's files say their version at the end of these.
const HEAD: usize = 128;

/// What a file is by its first bytes.
#[derive(Clone, Copy, PartialEq)]
enum Kind {
    Npy,
    Parquet,
    Mat,
    Mat73,
    Hdf5,
    Bag,
    Sqlite,
    /// A ZIP archive or an old spreadsheet.
    Archive,
    Text,
}

impl Kind {
    fn of(file: &Path) -> Result<Self, Problem> {
        let mut head = Vec::new();
        File::open(file)?.take(HEAD as u64).read_to_end(&mut head)?;
        Ok(match &head[..] {
            [0x93, b'N', b'U', b'M', b'P', b'Y', ..] => Self::Npy,
            [b'P', b'A', b'R', b'1', ..] => Self::Parquet,
            [b'M', b'A', b'T', b'L', b'A', b'B', ..] if is_of_version_7_3(&head) => Self::Mat73,
            [b'M', b'A', b'T', b'L', b'A', b'B', ..] => Self::Mat,
            [0x89, b'H', b'D', b'F', ..] => Self::Hdf5,
            [0x89, b'M', b'C', b'A', b'P', ..] => Self::Bag,
            head if head.starts_with(b"SQLite format 3") => Self::Sqlite,
            [b'P', b'K', 3 | 5, ..] | [0xd0, 0xcf, 0x11, 0xe0, ..] => Self::Archive,
            _ => Self::Text,
        })
    }
}

/// Reads a file of whatever kind.
///
/// # Errors
/// See [`ImportError`].
pub fn read(file: &Path, options: &Options) -> Result<Imported, ImportError> {
    if recording::input::is_standard(file) {
        return text(file);
    }
    let file = &part(file).map_err(of(file))?;
    let whole = || fs::read(file).map_err(|error| of(file)(error.into()));
    let variables = match Kind::of(file).map_err(of(file))? {
        Kind::Npy => npy::array(&stem(file), &whole()?),
        Kind::Parquet => parquet_file(file),
        Kind::Mat => mat::variables(&whole()?),
        Kind::Mat73 => return hdf5_file(file, true).map_err(of(file))?.table(file),
        Kind::Hdf5 => return hdf5_file(file, false).map_err(of(file))?.table(file),
        Kind::Bag => return bag_file(file, options).map_err(of(file))?.table(file),
        Kind::Sqlite => Err(Problem::Sqlite),
        Kind::Archive => {
            let bytes = whole()?;
            match npy::is_archive(&bytes) {
                true => npy::archive(&bytes),
                false => {
                    let text = sheet::text(bytes, options.sheet).map_err(of(file))?;
                    let table = Table::parse(file, text.as_bytes())?;
                    return Ok(Imported { table, left_out: Vec::new(), notes: Vec::new() });
                }
            }
        }
        Kind::Text => return text(file),
    };
    of_one_length(variables.map_err(of(file))?).map_err(of(file))?.table(file)
}

/// The outline of a file of text, whose rows are then read in blocks; `None` of any other file, and
/// of what can be read once only.
///
/// # Errors
/// See [`ImportError`].
pub fn outline(file: &Path) -> Result<Option<Outline<'_>>, ImportError> {
    if recording::input::is_standard(file) || !file.is_file() {
        return Ok(None);
    }
    match Kind::of(file).map_err(of(file))? {
        Kind::Text => Ok(Outline::of(file)?),
        _ => Ok(None),
    }
}

/// That there is a problem with a file.
fn of(file: &Path) -> impl Fn(Problem) -> ImportError {
    |problem| ImportError::File { file: file.to_owned(), problem }
}

/// What a file holds.
struct Found {
    variables: Vec<Variable>,
    left_out: Vec<(String, usize)>,
    notes: Vec<String>,
}

impl Found {
    fn table(self, file: &Path) -> Result<Imported, ImportError> {
        let Self { variables, left_out, notes } = self;
        let columns: Vec<(&str, &[f64])> =
            variables.iter().map(|(name, values)| (name.as_str(), values.as_slice())).collect();
        if columns.is_empty() {
            return Err(ImportError::File { file: file.to_owned(), problem: Problem::Nothing });
        }
        Ok(Imported { table: Table::of_columns(file, &columns)?, left_out, notes })
    }
}

/// The file itself, or of a bag's folder the one that it has.
fn part(file: &Path) -> Result<PathBuf, Problem> {
    if !file.is_dir() {
        return Ok(file.to_owned());
    }
    let entries = fs::read_dir(file)?.collect::<Result<Vec<_>, _>>()?;
    let is_bag = |path: &PathBuf| path.extension().is_some_and(|ending| ending == "mcap");
    let mut parts: Vec<PathBuf> = entries.into_iter().map(|entry| entry.path()).filter(is_bag).collect();
    parts.sort();
    match &parts[..] {
        [part] => Ok(part.clone()),
        [] => Err(Problem::Folder),
        several => {
            let names = several.iter().map(|part| part.file_name().unwrap_or_default().display().to_string());
            Err(Problem::SeveralParts(names.collect::<Vec<_>>().join(", ")))
        }
    }
}

/// Whether the head of a file of MATLAB's says so: version 0x0200 in either order of bytes.
fn is_of_version_7_3(head: &[u8]) -> bool {
    matches!(head.get(HEAD - 4..HEAD), Some([0, 2, b'I', b'M'] | [2, 0, b'M', b'I']))
}

#[cfg(feature = "parquet")]
fn parquet_file(file: &Path) -> Result<Vec<Variable>, Problem> {
    parquet::variables(File::open(file)?)
}

#[cfg(not(feature = "parquet"))]
fn parquet_file(_: &Path) -> Result<Vec<Variable>, Problem> {
    Err(Problem::NotBuilt("a Parquet file", "parquet"))
}

#[cfg(feature = "hdf5")]
fn hdf5_file(file: &Path, is_matlab: bool) -> Result<Found, Problem> {
    of_one_length(hdf5::arrays(file, is_matlab)?)
}

#[cfg(not(feature = "hdf5"))]
fn hdf5_file(_: &Path, _: bool) -> Result<Found, Problem> {
    Err(Problem::NotBuilt("an HDF5 file", "hdf5"))
}

#[cfg(feature = "mcap")]
fn bag_file(file: &Path, options: &Options) -> Result<Found, Problem> {
    let (variables, notes) = bag::variables(File::open(file)?, options)?;
    Ok(Found { variables, left_out: Vec::new(), notes })
}

#[cfg(not(feature = "mcap"))]
fn bag_file(_: &Path, _: &Options) -> Result<Found, Problem> {
    Err(Problem::NotBuilt("a bag", "mcap"))
}

fn text(file: &Path) -> Result<Imported, ImportError> {
    Ok(Imported { table: Table::read(file)?, left_out: Vec::new(), notes: Vec::new() })
}

/// What has a length before it is read.
trait Shaped {
    fn name(&self) -> &str;
    fn rows(&self) -> usize;
    fn read(&self) -> Result<Vec<Variable>, Problem>;
}

impl Shaped for Variable {
    fn name(&self) -> &str {
        &self.0
    }

    fn rows(&self) -> usize {
        self.1.len()
    }

    fn read(&self) -> Result<Vec<Variable>, Problem> {
        Ok(vec![self.clone()])
    }
}

/// The variables that have as many values as most have, of equally many lengths the larger; and the
/// others, which are not read.
fn of_one_length<S: Shaped>(found: Vec<S>) -> Result<Found, Problem> {
    let count = |length: usize| found.iter().filter(|one| one.rows() == length).count();
    let length = found.iter().map(Shaped::rows).max_by_key(|&length| (count(length), length)).unwrap_or(0);
    let (mut these, mut others) = (Vec::new(), Vec::new());
    for one in &found {
        match one.rows() == length {
            true => these.extend(one.read()?),
            false => others.push((one.name().to_owned(), one.rows())),
        }
    }
    Ok(Found { variables: these, left_out: others, notes: Vec::new() })
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
        let Found { variables: these, left_out: others, .. } =
            of_one_length(vec![named("rate", 1), named("t", 5), named("p", 5), named("note", 2)])
                .expect("in memory");
        assert_eq!(these.iter().map(|(name, _)| name.as_str()).collect::<Vec<_>>(), ["t", "p"]);
        assert_eq!(others, [("rate".to_owned(), 1), ("note".to_owned(), 2)]);
    }
}
