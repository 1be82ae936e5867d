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
//! `to_parquet` writes Parquet (feature `parquet`). `variables` makes a table of what these files
//! find, `array` reads what stands in a file as it is, `scratch` unpacks what does not.
//!
//! Everything else is text, and read as a recording is ([`Table::read`](recording::table::Table::read)). What a file is its first
//! bytes say, not its name.
//!
//! # Contract
//! Numbers are the file's, bit for bit: those of a narrower type are exact in `f64`, but for whole
//! numbers above 2⁵³, which are refused. A matrix is a column each, `name_1`, `name_2`. Columns of
//! another length than the times are no part of the table; they are listed by name.
//!
//! # Memory
//! No numbers are held: a file is gone through once to see what its columns are and that it is
//! whole, and again for some rows at a time ([`Outline`]). What can be read once only, or not from
//! any place (pipes, packed variables of NumPy and MATLAB), is copied into a file without a name
//! first; so are the numbers of a bag. Spreadsheets are held, with some 260 bytes a row of three
//! columns; a sheet of Excel has 1,048,576 rows at most.

mod array;
#[cfg(feature = "mcap")]
mod bag;
#[cfg(feature = "hdf5")]
mod hdf5;
mod mat;
mod npy;
mod number;
#[cfg(feature = "parquet")]
mod parquet;
mod scratch;
mod sheet;
#[cfg(feature = "parquet")]
pub mod to_parquet;
mod variables;

use std::fs::{self, File};
use std::io::{self, Read};
use std::ops::Range;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use recording::input::{self, FromPlace};
use recording::table::DataError;
use recording::table::naming::Renamed;
use recording::table::outline::Outline;
use thiserror::Error;

use variables::{Found, Variable, Variables, of_one_length};

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
    /// The table, whose numbers are read when they are asked for.
    pub outline: Outline,
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
    Unreadable(io::Error),
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

/// What has been read tells what was wrong with it.
impl From<io::Error> for Problem {
    fn from(error: io::Error) -> Self {
        error.downcast().unwrap_or_else(Self::Unreadable)
    }
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
    /// Where copies of what cannot be read twice are kept meanwhile, else where the system keeps
    /// such files.
    pub scratch: Option<&'a Path>,
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
    fn of(file: &Arc<File>) -> io::Result<Self> {
        let mut head = Vec::new();
        FromPlace::new(file, 0).take(HEAD as u64).read_to_end(&mut head)?;
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

/// Looks at a file of whatever kind; `-` is standard input.
///
/// # Errors
/// See [`ImportError`].
pub fn read(file: &Path, options: &Options) -> Result<Imported, ImportError> {
    let of = |file: &Path| {
        let file = file.to_owned();
        |problem| ImportError::File { file, problem }
    };
    let name = &part(file).map_err(of(file))?;
    let file = open(name, options.scratch).map_err(|error| of(name)(error.into()))?;
    let kind = Kind::of(&file).map_err(|error| of(name)(error.into()))?;
    let text = |outline| Imported { outline, left_out: Vec::new(), notes: Vec::new() };
    if kind == Kind::Text {
        return Ok(text(Outline::of(name, file)?));
    }
    if kind == Kind::Archive && !npy::is_archive(&file) {
        let sheet = sheet::text(&file, options.sheet).map_err(of(name))?;
        return Ok(text(Outline::of_text(name, sheet)?));
    }
    let Found { variables, left_out, notes } = found(name, &file, kind, options).map_err(of(name))?;
    let (numbers, columns) = Variables::of(variables).map_err(of(name))?;
    let outline =
        Outline::of_numbers(name, &columns, Box::new(numbers)).map_err(|error| of(name)(error.into()))?;
    Ok(Imported { outline: outline?, left_out, notes })
}

/// A file that can be read as often as wanted: of what comes through a pipe a copy.
fn open(name: &Path, scratch: Option<&Path>) -> io::Result<Arc<File>> {
    if input::is_standard(name) {
        return scratch::copy(scratch, &mut io::stdin().lock());
    }
    let mut file = File::open(name)?;
    match file.metadata()?.is_file() {
        true => Ok(file.into()),
        false => scratch::copy(scratch, &mut file),
    }
}

fn found(name: &Path, file: &Arc<File>, kind: Kind, options: &Options) -> Result<Found, Problem> {
    let all = match kind {
        Kind::Npy => npy::array(&stem(name), file)?.into_iter().collect(),
        Kind::Archive => npy::archive(file, options.scratch)?,
        Kind::Mat => mat::variables(file, options.scratch)?,
        Kind::Parquet => parquet_file(file)?,
        Kind::Mat73 | Kind::Hdf5 => hdf5_file(file, kind == Kind::Mat73)?,
        Kind::Bag => return bag_file(file, options),
        Kind::Sqlite => return Err(Problem::Sqlite),
        Kind::Text => Vec::new(),
    };
    Ok(of_one_length(all))
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
fn parquet_file(file: &File) -> Result<Vec<Box<dyn Variable>>, Problem> {
    parquet::variables(file.try_clone()?)
}

#[cfg(not(feature = "parquet"))]
fn parquet_file(_: &File) -> Result<Vec<Box<dyn Variable>>, Problem> {
    Err(Problem::NotBuilt("a Parquet file", "parquet"))
}

#[cfg(feature = "hdf5")]
fn hdf5_file(file: &File, is_matlab: bool) -> Result<Vec<Box<dyn Variable>>, Problem> {
    hdf5::variables(file, is_matlab)
}

#[cfg(not(feature = "hdf5"))]
fn hdf5_file(_: &File, _: bool) -> Result<Vec<Box<dyn Variable>>, Problem> {
    Err(Problem::NotBuilt("an HDF5 file", "hdf5"))
}

#[cfg(feature = "mcap")]
fn bag_file(file: &Arc<File>, options: &Options) -> Result<Found, Problem> {
    bag::found(file, options)
}

#[cfg(not(feature = "mcap"))]
fn bag_file(_: &Arc<File>, _: &Options) -> Result<Found, Problem> {
    Err(Problem::NotBuilt("a bag", "mcap"))
}

fn stem(file: &Path) -> String {
    file.file_stem().unwrap_or_default().display().to_string()
}
