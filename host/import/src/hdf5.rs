//! HDF5 files, and MATLAB's files of version 7.3, which are HDF5 files.
//!
//! A variable's name is its path: `run/pressure`. Arrays of up to two dimensions are variables, a
//! row a sample; of a table each field is one. Of MATLAB's files, whose arrays stand the other way
//! round, text, cells and references are passed over.
//!
//! Lengths are known before numbers are read: what is no part of the table, pictures for instance,
//! is never read. Of the others some rows are read at a time. Of arrays in chunks, the chunks are
//! held that lie beside each other, so that none is unpacked twice: of an array that is one chunk
//! all of it.

use std::fmt;
use std::fs::File;
use std::ops::Range;
use std::sync::Arc;

use hdf5_reader::group::Group;
use hdf5_reader::storage::FileStorage;
use hdf5_reader::{ByteOrder, Dataset, Datatype, H5Type, Hdf5File, OpenOptions, SliceInfo, SliceInfoElem};

use super::Problem;
use super::number::Kind;
use super::variables::{Reader, Variable};

/// Groups within groups that are followed, at most: links may form a circle.
const DEPTH: usize = 16;
/// Elements that are read at a time, unless a row has more.
const PIECE: usize = 1 << 15;
/// The classes of MATLAB's arrays of numbers.
const NUMBERS: [&str; 11] =
    ["double", "single", "int8", "uint8", "int16", "uint16", "int32", "uint32", "int64", "uint64", "logical"];

/// The arrays of numbers of a file. `is_matlab`: of version 7.3.
///
/// # Errors
/// The file is damaged.
pub fn variables(file: &File, is_matlab: bool) -> Result<Vec<Box<dyn Variable>>, Problem> {
    let arrays = |options: OpenOptions| {
        let storage = FileStorage::from_file(file.try_clone()?).map_err(damaged)?;
        let book = Hdf5File::from_storage_with_options(Arc::new(storage), options).map_err(damaged)?;
        let (length, wanted) = (file.metadata()?.len(), book.superblock().eof_address);
        if length < wanted {
            return Err(Problem::Damaged(format!("it has {length} bytes of {wanted}")));
        }
        let mut found = Vec::new();
        collect(&book.root_group().map_err(damaged)?, "", is_matlab, DEPTH, &mut found)?;
        Ok(found)
    };
    let (mut count, mut bytes) = (0_usize, 0_usize);
    for (chunks, size) in arrays(OpenOptions::default())?.iter().map(Array::beside_each_other) {
        count = count.saturating_add(chunks);
        bytes = bytes.saturating_add(chunks.saturating_mul(size));
    }
    let kept = OpenOptions::default().with_chunk_cache_slots(count.max(1)).with_chunk_cache_bytes(bytes);
    Ok(arrays(kept)?.into_iter().map(|array| Box::new(array) as Box<dyn Variable>).collect())
}

/// An array of numbers.
pub struct Array {
    name: String,
    dataset: Dataset,
    /// Its fields: each a name, where it begins in an element, and how it is stored.
    fields: Vec<(String, usize, Kind)>,
    is_matlab: bool,
}

impl fmt::Debug for Array {
    fn fmt(&self, to: &mut fmt::Formatter<'_>) -> fmt::Result {
        to.debug_struct("Array").field("name", &self.name).field("shape", &self.dataset.shape()).finish()
    }
}

/// How the numbers of an array stand.
#[derive(Clone, Copy, PartialEq)]
enum Order {
    /// One.
    Alone,
    /// One dimension.
    Line,
    /// Two dimensions, the first of one element: a row that is as good as a column.
    Row,
    /// The rows of a matrix one behind the other.
    Rows,
    /// Its columns.
    Columns,
}

fn collect(
    group: &Group,
    path: &str,
    is_matlab: bool,
    depth: usize,
    found: &mut Vec<Array>,
) -> Result<(), Problem> {
    let (groups, datasets) = group.members().map_err(damaged)?;
    let place = |name: &str| if path.is_empty() { name.to_owned() } else { format!("{path}/{name}") };
    let own = |name: &str| name.rsplit('/').next().unwrap_or(name).to_owned();
    for dataset in datasets {
        let name = place(&own(dataset.name()));
        if is_matlab && !is_of_numbers(&dataset) {
            continue;
        }
        if let Some(fields) = fields(&name, dataset.dtype()) {
            found.push(Array { name, dataset, fields, is_matlab });
        }
    }
    for group in groups {
        let name = own(group.name());
        // What MATLAB keeps for itself.
        if depth > 0 && !name.starts_with('#') {
            collect(&group, &place(&name), is_matlab, depth - 1, found)?;
        }
    }
    Ok(())
}

/// Whether an array of MATLAB's is one of numbers that has some.
fn is_of_numbers(dataset: &Dataset) -> bool {
    let class = dataset.attribute("MATLAB_class").and_then(|class| class.read_string());
    let is_number = class.is_ok_and(|class| NUMBERS.contains(&class.trim_end_matches('\0')));
    is_number && dataset.attribute("MATLAB_empty").is_err()
}

/// The fields of a type, or the type under the array's name; None where one is no real number.
fn fields(name: &str, kind: &Datatype) -> Option<Vec<(String, usize, Kind)>> {
    match kind {
        Datatype::Compound { fields, .. } => fields
            .iter()
            .map(|field| {
                Some((format!("{name}/{}", field.name), field.byte_offset as usize, number(&field.datatype)?))
            })
            .collect(),
        kind => Some(vec![(name.to_owned(), 0, number(kind)?)]),
    }
}

fn number(kind: &Datatype) -> Option<Kind> {
    let of = |letter, width: u8, order: ByteOrder| {
        let is_known = if letter == 'f' { matches!(width, 4 | 8) } else { matches!(width, 1 | 2 | 4 | 8) };
        let is_big_endian = order == ByteOrder::BigEndian;
        is_known.then_some(Kind { letter, width: width.into(), is_big_endian })
    };
    match kind {
        Datatype::FloatingPoint { size, byte_order } => of('f', *size, *byte_order),
        Datatype::FixedPoint { size, signed, byte_order } => {
            of(if *signed { 'i' } else { 'u' }, *size, *byte_order)
        }
        Datatype::Enum { base, .. } => number(base),
        _ => None,
    }
}

impl Array {
    fn order(&self) -> Order {
        match (self.dataset.shape(), self.is_matlab) {
            ([], _) => Order::Alone,
            ([1, _], _) => Order::Row,
            // A column is the same in either order.
            ([_, 1], _) | ([_, _], false) => Order::Rows,
            ([_, _], true) => Order::Columns,
            _ => Order::Line,
        }
    }

    /// Columns of the matrix.
    fn width(&self) -> usize {
        match (self.order(), self.dataset.shape()) {
            (Order::Rows, [_, width]) | (Order::Columns, [width, _]) => size(*width),
            _ => 1,
        }
    }

    /// How many chunks the rows of the array lie in that are read together, and the bytes of one.
    fn beside_each_other(&self) -> (usize, usize) {
        let chunks = self.dataset.chunks().unwrap_or_default();
        let element = self.dataset.raw_element_size().unwrap_or(0);
        let bytes = chunks.iter().fold(element, |bytes, &count| bytes.saturating_mul(count as usize));
        let across = match (self.order(), &chunks[..]) {
            (_, []) => return (0, 0),
            (Order::Rows, [_, across]) | (Order::Columns, [across, _]) => *across as usize,
            _ => 1,
        };
        (self.width().div_ceil(across.max(1)), bytes)
    }
}

fn size(count: u64) -> usize {
    usize::try_from(count).unwrap_or(usize::MAX)
}

impl Variable for Array {
    fn entries(&self) -> Vec<String> {
        vec![self.name.clone()]
    }

    fn columns(&self) -> Result<Vec<String>, Problem> {
        let dimensions = self.dataset.ndim();
        if dimensions > 2 {
            let why = format!("it has {dimensions} dimensions; a row a sample is needed");
            return Err(Problem::Variable { name: self.name.clone(), why });
        }
        let width = if self.rows() == 0 { 0 } else { self.width() };
        let named = |(name, ..): &(String, usize, Kind)| match width {
            1 => vec![name.clone()],
            width => (1..=width).map(|place| format!("{name}_{place}")).collect(),
        };
        Ok(self.fields.iter().flat_map(named).collect())
    }

    fn rows(&self) -> usize {
        match (self.order(), self.dataset.shape()) {
            (Order::Rows, [rows, _]) | (Order::Row | Order::Columns, [_, rows]) => size(*rows),
            (_, shape) => shape.iter().fold(1, |product, &count| size(count).saturating_mul(product)),
        }
    }

    fn reader(&self, columns: &[usize]) -> Result<Box<dyn Reader + '_>, Problem> {
        Ok(Box::new(Slices { array: self, columns: columns.to_vec(), row: 0 }))
    }
}

/// Where the reading of an array has come to.
struct Slices<'a> {
    array: &'a Array,
    /// Those that are read: of each field as many as the matrix has.
    columns: Vec<usize>,
    row: usize,
}

impl Reader for Slices<'_> {
    fn read(&mut self, rows: usize, columns: &mut [Vec<f64>]) -> Result<(), Problem> {
        let Array { fields, .. } = self.array;
        let (order, width) = (self.array.order(), self.array.width());
        let at_once = (PIECE / width.max(1)).max(1);
        for first in (0..rows).step_by(at_once) {
            let these = self.row..self.row + at_once.min(rows - first);
            let elements = self.array.elements(&these)?;
            let count = these.len();
            if elements.len() != count * width {
                return Err(Problem::Damaged(format!("{} ends within the array", self.array.name)));
            }
            for (column, target) in self.columns.iter().zip(&mut *columns) {
                let ((name, offset, kind), place) = (&fields[column / width], column % width);
                let (begin, step) = match order {
                    Order::Columns => (place * count, 1),
                    _ => (place, width),
                };
                for element in elements[begin..].iter().step_by(step).take(count) {
                    let bytes = element.bytes().get(*offset..*offset + kind.width);
                    let ends = || Problem::Damaged(format!("{name} ends within a value"));
                    target.push(kind.value(name, bytes.ok_or_else(ends)?)?);
                }
            }
            self.row = these.end;
        }
        Ok(())
    }
}

impl Array {
    /// The elements of some rows, as they stand.
    fn elements(&self, rows: &Range<usize>) -> Result<Vec<Element>, Problem> {
        let all = SliceInfoElem::Slice { start: 0, end: u64::MAX, step: 1 };
        let some = SliceInfoElem::Slice { start: rows.start as u64, end: rows.end as u64, step: 1 };
        let selections = match self.order() {
            Order::Alone => return Ok(vec![Element::of(&self.dataset.read_raw_bytes().map_err(damaged)?)]),
            Order::Line => vec![some],
            Order::Rows => vec![some, all],
            Order::Row | Order::Columns => vec![all, some],
        };
        let elements = self.dataset.read_slice::<Element>(&SliceInfo { selections });
        let elements = elements.map_err(|error| Problem::Damaged(format!("{}: {error}", self.name)))?;
        Ok(elements.into_raw_vec_and_offset().0)
    }
}

/// An element as it is stored.
#[derive(Clone)]
enum Element {
    /// Of at most eight bytes; none where it has fewer.
    Number([u8; 8]),
    Fields(Box<[u8]>),
}

impl Element {
    fn of(bytes: &[u8]) -> Self {
        let mut number = [0; 8];
        match number.get_mut(..bytes.len()) {
            Some(target) => {
                target.copy_from_slice(bytes);
                Self::Number(number)
            }
            None => Self::Fields(bytes.into()),
        }
    }

    fn bytes(&self) -> &[u8] {
        match self {
            Self::Number(bytes) => bytes,
            Self::Fields(bytes) => bytes,
        }
    }
}

impl H5Type for Element {
    fn hdf5_type() -> Datatype {
        Datatype::Opaque { size: 0, tag: String::new() }
    }

    fn from_bytes(bytes: &[u8], _: &Datatype) -> hdf5_reader::error::Result<Self> {
        Ok(Self::of(bytes))
    }

    fn element_size(_: &Datatype) -> usize {
        size_of::<Self>()
    }
}

fn damaged(error: hdf5_reader::error::Error) -> Problem {
    Problem::Damaged(error.to_string())
}
