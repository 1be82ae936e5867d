//! Arrays whose numbers stand in a file one behind the other.

use std::fs::File;
use std::io::{self, ErrorKind, Read};
use std::sync::Arc;

use recording::input::FromPlace;

use super::Problem;
use super::number::Kind;
use super::variables::{Reader, Variable};

/// Bytes that are read at a time, unless a row has more.
const PIECE: usize = 1 << 20;

/// An array: a column for each field of its elements, and of a matrix as many for each of its own.
#[derive(Debug)]
pub struct Array {
    pub file: Arc<File>,
    /// Bytes of the file before the first element.
    pub begins: u64,
    /// The array's in messages.
    pub name: String,
    /// Of an element: each a name and how it is stored; they stand one behind the other.
    pub fields: Vec<(String, Kind)>,
    pub rows: usize,
    /// Columns of the matrix.
    pub width: usize,
    /// Whether its columns stand one behind the other, not its rows.
    pub is_by_columns: bool,
}

impl Array {
    /// Unit: bytes.
    fn element(&self) -> usize {
        self.fields.iter().map(|(_, kind)| kind.width).sum()
    }

    /// The field of a column, and the column of the matrix.
    fn place(&self, column: usize) -> (usize, usize) {
        (column / self.width, column % self.width)
    }
}

impl Variable for Array {
    fn entries(&self) -> Vec<String> {
        let name = |column| {
            let (field, place) = self.place(column);
            let name = &self.fields[field].0;
            if self.width == 1 { name.clone() } else { format!("{name}_{}", place + 1) }
        };
        (0..self.width * self.fields.len()).map(name).collect()
    }

    fn rows(&self) -> usize {
        self.rows
    }

    fn reader(&self, columns: &[usize]) -> Result<Box<dyn Reader + '_>, Problem> {
        let element = self.element();
        let step = if self.is_by_columns { element } else { element * self.width };
        let mut lanes: Vec<Lane> = Vec::new();
        for (target, &column) in columns.iter().enumerate() {
            let (field, place) = self.place(column);
            let before: usize = self.fields[..field].iter().map(|(_, kind)| kind.width).sum();
            let (begins, offset) = match self.is_by_columns {
                true => (self.begins + (element * self.rows * place) as u64, before),
                false => (self.begins, element * place + before),
            };
            let lane = match lanes.iter().position(|lane| lane.begins == begins) {
                Some(lane) => lane,
                None => {
                    lanes.push(Lane {
                        bytes: FromPlace::new(&self.file, begins),
                        begins,
                        fields: Vec::new(),
                    });
                    lanes.len() - 1
                }
            };
            lanes[lane].fields.push((target, offset, field));
        }
        Ok(Box::new(Lanes { array: self, step, lanes, buffer: Vec::new() }))
    }
}

/// What is read from a place on: of some columns.
struct Lane {
    bytes: FromPlace,
    /// Bytes of the file before it.
    begins: u64,
    /// Each with its place among the columns that are read, the bytes of a row before it, and its
    /// place among the fields.
    fields: Vec<(usize, usize, usize)>,
}

struct Lanes<'a> {
    array: &'a Array,
    /// Bytes from a row to the next.
    step: usize,
    lanes: Vec<Lane>,
    buffer: Vec<u8>,
}

impl Reader for Lanes<'_> {
    fn read(&mut self, rows: usize, columns: &mut [Vec<f64>]) -> Result<(), Problem> {
        let Array { name, fields, .. } = self.array;
        let at_once = (PIECE / self.step.max(1)).max(1);
        for lane in &mut self.lanes {
            for first in (0..rows).step_by(at_once) {
                self.buffer.resize(at_once.min(rows - first) * self.step, 0);
                lane.bytes.read_exact(&mut self.buffer).map_err(unreadable(|| ends(name)))?;
                for row in self.buffer.chunks_exact(self.step) {
                    for &(target, offset, field) in &lane.fields {
                        let (name, kind) = &fields[field];
                        columns[target].push(kind.value(name, &row[offset..offset + kind.width])?);
                    }
                }
            }
        }
        Ok(())
    }
}

/// That an array is cut off.
pub fn ends(name: &str) -> String {
    format!("{name} ends within the array")
}

/// The next bytes, exactly so many.
///
/// # Errors
/// They end before, or cannot be read.
pub fn exactly(bytes: &mut impl Read, count: usize) -> io::Result<Vec<u8>> {
    let mut taken = Vec::new();
    match bytes.take(count as u64).read_to_end(&mut taken)? {
        found if found == count => Ok(taken),
        _ => Err(ErrorKind::UnexpectedEof.into()),
    }
}

/// What is wrong where bytes of a file cannot be had: it is cut off, or damaged, as what unpacks it
/// says.
pub fn unreadable(cut: impl FnOnce() -> String) -> impl FnOnce(io::Error) -> Problem {
    |error| match error.kind() {
        ErrorKind::UnexpectedEof => Problem::Damaged(cut()),
        ErrorKind::InvalidData | ErrorKind::InvalidInput | ErrorKind::Other => {
            Problem::Damaged(error.to_string())
        }
        _ => Problem::Unreadable(error),
    }
}
