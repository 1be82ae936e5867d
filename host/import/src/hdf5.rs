//! HDF5 files, and MATLAB's files of version 7.3, which are HDF5 files.
//!
//! A variable's name is its path: `run/pressure`. Arrays of up to two dimensions are variables, a
//! row a sample; of a table each field is one. Of MATLAB's files, whose arrays stand the other way
//! round, text, cells and references are passed over.
//!
//! Lengths are known before numbers are read: what is no part of the table, pictures for instance,
//! is never read.

use std::fs;
use std::path::Path;

use hdf5_reader::group::Group;
use hdf5_reader::{ByteOrder, Dataset, Datatype, Hdf5File};

use super::number::{Kind, columns, transposed};
use super::{Problem, Shaped, Variable};

/// Groups within groups that are followed, at most: links may form a circle.
const DEPTH: usize = 16;
/// The classes of MATLAB's arrays of numbers.
const NUMBERS: [&str; 11] =
    ["double", "single", "int8", "uint8", "int16", "uint16", "int32", "uint32", "int64", "uint64", "logical"];

/// The arrays of numbers of a file. `is_matlab`: of version 7.3.
///
/// # Errors
/// The file is damaged.
pub fn arrays(file: &Path, is_matlab: bool) -> Result<Vec<Array>, Problem> {
    let length = fs::metadata(file)?.len();
    let file = Hdf5File::open(file).map_err(damaged)?;
    let wanted = file.superblock().eof_address;
    if length < wanted {
        return Err(Problem::Damaged(format!("it has {length} bytes of {wanted}")));
    }
    let mut found = Vec::new();
    collect(&file.root_group().map_err(damaged)?, "", is_matlab, DEPTH, &mut found)?;
    Ok(found)
}

/// An array of numbers.
pub struct Array {
    name: String,
    dataset: Dataset,
    /// Its fields: each a name, where it begins in an element, and how it is stored.
    fields: Vec<(String, usize, Kind)>,
    is_matlab: bool,
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

impl Shaped for Array {
    fn name(&self) -> &str {
        &self.name
    }

    fn rows(&self) -> usize {
        let count = |size: &u64| usize::try_from(*size).unwrap_or(usize::MAX);
        match (self.dataset.shape(), self.is_matlab) {
            ([], _) => 1,
            ([rows], _) => count(rows),
            // A row is as good as a column.
            ([1, rows], _) | ([rows, 1], _) => count(rows),
            ([rows, _], false) | ([_, rows], true) => count(rows),
            (shape, _) => shape.iter().map(count).fold(1, usize::saturating_mul),
        }
    }

    fn read(&self) -> Result<Vec<Variable>, Problem> {
        let (shape, rows) = (self.dataset.shape(), self.rows());
        if shape.len() > 2 {
            let why = format!("it has {} dimensions; a row a sample is needed", shape.len());
            return Err(Problem::Variable { name: self.name.clone(), why });
        }
        let bytes = self.dataset.read_raw_bytes().map_err(damaged)?;
        let width = self.dataset.raw_element_size().map_err(damaged)?.max(1);
        let mut found = Vec::new();
        for (name, offset, kind) in &self.fields {
            let value = |element: &[u8]| match element.get(*offset..*offset + kind.width) {
                Some(bytes) => kind.value(name, bytes),
                None => Err(Problem::Damaged(format!("{name} ends within a value"))),
            };
            let values: Vec<f64> = bytes.chunks_exact(width).map(value).collect::<Result<_, _>>()?;
            let is_one = values.len() == rows;
            let values = match self.is_matlab || is_one {
                true => values,
                false => transposed(rows, values.len() / rows.max(1), &values),
            };
            found.extend(columns(name, rows, values));
        }
        Ok(found)
    }
}

fn damaged(error: hdf5_reader::error::Error) -> Problem {
    Problem::Damaged(error.to_string())
}
