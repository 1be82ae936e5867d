//! MATLAB's files of version 5: real arrays of numbers.

use matfile::{MatFile, NumericData};

use super::number::{columns, whole};
use super::{Problem, Variable};

/// Bytes before the first variable.
const HEADER: usize = 128;
/// Bytes before the content of a variable: its kind and its size.
const TAG: usize = 8;

/// The variables of a file; what is complex, or no array of numbers, is passed over.
///
/// # Errors
/// The file is damaged, or a whole number has no `f64`.
pub fn variables(bytes: &[u8]) -> Result<Vec<Variable>, Problem> {
    if !is_whole(bytes) {
        return Err(Problem::Damaged("it ends within a variable".to_owned()));
    }
    let file = MatFile::parse(bytes).map_err(|error| Problem::Damaged(error.to_string()))?;
    let mut found = Vec::new();
    for array in file.arrays() {
        let size = array.size();
        let Some(values) = values(array.name(), array.data())? else { continue };
        // A row is as good as a column.
        let rows = match size[..] {
            [1, count] => count,
            [rows, ..] => rows,
            [] => 0,
        };
        found.extend(columns(array.name(), rows, values));
    }
    Ok(found)
}

/// Whether the last variable ends with the file: what reads it takes no offence at one that is cut.
fn is_whole(bytes: &[u8]) -> bool {
    let is_little = bytes.get(HEADER - 2..HEADER) == Some(b"IM");
    let mut place = HEADER;
    while let Some(size) = bytes.get(place + TAG / 2..place + TAG) {
        let size = size.iter().enumerate().fold(0, |sum, (byte, value)| {
            sum | usize::from(*value) << (8 * if is_little { byte } else { 3 - byte })
        });
        place += TAG + size;
    }
    place == bytes.len()
}

/// The values in the order of Fortran.
fn values(name: &str, data: &NumericData) -> Result<Option<Vec<f64>>, Problem> {
    macro_rules! exact {
        ($real:expr) => {
            $real.iter().map(|&value| f64::from(value)).collect()
        };
    }
    Ok(Some(match data {
        NumericData::Int8 { real, imag: None } => exact!(real),
        NumericData::UInt8 { real, imag: None } => exact!(real),
        NumericData::Int16 { real, imag: None } => exact!(real),
        NumericData::UInt16 { real, imag: None } => exact!(real),
        NumericData::Int32 { real, imag: None } => exact!(real),
        NumericData::UInt32 { real, imag: None } => exact!(real),
        NumericData::Single { real, imag: None } => exact!(real),
        NumericData::Double { real, imag: None } => exact!(real),
        NumericData::Int64 { real, imag: None } => {
            real.iter().map(|&value| whole(name, value.into())).collect::<Result<_, _>>()?
        }
        NumericData::UInt64 { real, imag: None } => {
            real.iter().map(|&value| whole(name, value.into())).collect::<Result<_, _>>()?
        }
        _ => return Ok(None),
    }))
}
