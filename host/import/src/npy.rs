//! NumPy's arrays: `.npy`, and `.npz`, an archive of them.
//!
//! # Format (NEP 1)
//! A magic word, a version, the length of a header, and the header, a dictionary of Python's in one
//! line: `{'descr': '<f8', 'fortran_order': False, 'shape': (1200, 3), }`, padded with blanks; then
//! the values. A table of named fields has a list of pairs for its `descr`.
//!
//! # Limits
//! Real numbers, truth values and fields of them, in either order of bytes; no text, no complex
//! numbers, no Python objects.

use std::fmt::Display;
use std::fs::File;
use std::path::Path;
use std::sync::Arc;

use recording::input::FromPlace;
use zip::ZipArchive;

use super::array::{Array, ends, exactly, unreadable};
use super::number::Kind;
use super::variables::Variable;
use super::{Problem, scratch};

/// Whether an archive is one of NumPy's: all its files are arrays.
pub fn is_archive(file: &File) -> bool {
    ZipArchive::new(file).is_ok_and(|archive| {
        !archive.is_empty() && archive.file_names().all(|name| name.is_ok_and(|name| name.ends_with(".npy")))
    })
}

/// The variables of an archive, each of which is unpacked into a file of its own.
///
/// # Errors
/// The archive is damaged, or an array does not hold numbers.
pub fn archive(file: &File, folder: Option<&Path>) -> Result<Vec<Box<dyn Variable>>, Problem> {
    let damaged = |error: &dyn Display| Problem::Damaged(error.to_string());
    let mut archive = ZipArchive::new(file).map_err(|error| damaged(&error))?;
    let mut all = Vec::new();
    for place in 0..archive.len() {
        let mut file = archive.by_index(place).map_err(|error| damaged(&error))?;
        let name = file.name().map_err(|error| damaged(&error))?.trim_end_matches(".npy").to_owned();
        let content = scratch::copy(folder, &mut file).map_err(unreadable(|| ends(&name)))?;
        all.extend(array(&name, &content)?);
    }
    Ok(all)
}

/// The variable of an array under a name; none of a matrix without rows.
///
/// # Errors
/// It is damaged, or no array of numbers.
pub fn array(name: &str, file: &Arc<File>) -> Result<Option<Box<dyn Variable>>, Problem> {
    let refused = |why: String| Problem::Variable { name: name.to_owned(), why };
    let mut bytes = FromPlace::new(file, 0);
    let mut take = |count| exactly(&mut bytes, count).map_err(unreadable(|| ends(name)));
    let version = take(8)?[6];
    let length = take(if version == 1 { 2 } else { 4 })?;
    let begins = 8 + length.len();
    let length = length.iter().rev().fold(0_usize, |sum, byte| (sum << 8) | usize::from(*byte));
    let header = take(length)?;
    let header = String::from_utf8_lossy(&header);
    let value = |key: &str| {
        let behind = header.split_once(&format!("'{key}':"))?.1.trim_start();
        Some(behind)
    };
    let unknown = || refused("its header is none of NumPy's".to_owned());
    let descr = value("descr").ok_or_else(unknown)?;
    let is_fortran = value("fortran_order").ok_or_else(unknown)?.starts_with("True");
    let shape =
        value("shape").and_then(|shape| shape.strip_prefix('(')?.split_once(')')).ok_or_else(unknown)?.0;
    let shape: Vec<usize> = shape
        .split(',')
        .map(str::trim)
        .filter(|size| !size.is_empty())
        .map(|size| size.trim_end_matches('L').parse().map_err(|_| unknown()))
        .collect::<Result<_, _>>()?;
    let fields = fields(name, descr).ok_or_else(|| {
        let end = descr.find(", 'fortran_order'").unwrap_or(descr.len());
        refused(format!("its type {} is none of real numbers", &descr[..end]))
    })?;
    let (rows, width, is_by_columns) = match shape[..] {
        [] => (1, 1, false),
        // A row is as good as a column.
        [rows] | [1, rows] => (rows, 1, false),
        [0, _] => return Ok(None),
        [rows, width] => (rows, width, is_fortran),
        _ => return Err(refused(format!("it has {} dimensions; a row a sample is needed", shape.len()))),
    };
    let begins = (begins + length) as u64;
    let element: usize = fields.iter().map(|(_, kind)| kind.width).sum();
    let size = [rows, width, element].iter().try_fold(1_u64, |size, &count| size.checked_mul(count as u64));
    let last = size.and_then(|size| size.checked_add(begins));
    if last.is_none_or(|last| file.metadata().is_ok_and(|file| file.len() < last)) {
        return Err(Problem::Damaged(ends(name)));
    }
    let (file, name) = (Arc::clone(file), name.to_owned());
    Ok(Some(Box::new(Array { file, begins, name, fields, rows, width, is_by_columns })))
}

/// The fields of a type, or the type under the array's name. None where one is no real number.
fn fields(name: &str, descr: &str) -> Option<Vec<(String, Kind)>> {
    let quoted = |text: &str| text.strip_prefix('\'')?.split_once('\'').map(|(inside, _)| inside.to_owned());
    let Some(list) = descr.strip_prefix('[') else {
        return Some(vec![(name.to_owned(), Kind::of(&quoted(descr)?)?)]);
    };
    let list = &list[..list.find(']')?];
    let pairs = list.split('(').skip(1).map(|pair| {
        let (field, kind) = pair.split_once(',')?;
        let kind = kind.trim().trim_end_matches([',', ' ', ')']);
        Some((quoted(field.trim())?, Kind::of(&quoted(kind)?)?))
    });
    pairs.collect()
}

#[cfg(test)]
mod tests {
    use std::io::Write;

    use super::super::variables::tests::read;
    use super::*;

    /// The columns of an array, read so many rows at a time.
    fn columns(name: &str, bytes: &[u8], most: usize) -> Result<Vec<(String, Vec<f64>)>, Problem> {
        let mut file = tempfile::tempfile().expect("a file");
        file.write_all(bytes).expect("it is written");
        read(array(name, &Arc::new(file))?.into_iter().collect(), most)
    }

    /// An array as NumPy writes it.
    fn npy(header: &str, data: &[u8]) -> Vec<u8> {
        let mut bytes = b"\x93NUMPY\x01\x00".to_vec();
        bytes.extend((header.len() as u16).to_le_bytes());
        bytes.extend(header.as_bytes());
        bytes.extend(data);
        bytes
    }

    fn bytes(values: &[f64]) -> Vec<u8> {
        values.iter().flat_map(|value| value.to_le_bytes()).collect()
    }

    #[test]
    fn rows_and_columns_are_told_apart_in_either_order() {
        let values = bytes(&[1.0, 2.0, 3.0, 4.0, 5.0, 6.0]);
        let of = |order: &str| {
            let values = values.clone();
            let header = format!("{{'descr': '<f8', 'fortran_order': {order}, 'shape': (3, 2), }}");
            (1..4).map(move |most| columns("x", &npy(&header, &values), most).expect("an array"))
        };
        let second = |values: [f64; 3]| ("x_2".to_owned(), values.to_vec());
        assert!(of("False").all(|columns| columns[1] == second([2.0, 4.0, 6.0])));
        assert!(of("True").all(|columns| columns[1] == second([4.0, 5.0, 6.0])));
    }

    #[test]
    fn fields_of_any_width_and_order_are_numbers() {
        let header =
            "{'descr': [('t', '>i2'), ('p', '<f4'), ('on', '|b1')], 'fortran_order': False, 'shape': (2,), }";
        let mut data = Vec::new();
        for (t, p, on) in [(-2_i16, 1.5_f32, 1_u8), (300, -0.25, 0)] {
            data.extend(t.to_be_bytes());
            data.extend(p.to_le_bytes());
            data.push(on);
        }
        let found = columns("table", &npy(header, &data), 1).expect("fields");
        let values: Vec<&[f64]> = found.iter().map(|(_, values)| values.as_slice()).collect();
        assert_eq!(values, [[-2.0, 300.0], [1.5, -0.25], [1.0, 0.0]]);
        assert_eq!(found[1].0, "p");
    }

    #[test]
    fn what_is_cut_off_or_no_number_is_refused() {
        let header = "{'descr': '<f8', 'fortran_order': False, 'shape': (3,), }";
        let message = |bytes: &[u8]| columns("x", bytes, 9).expect_err("refused").to_string();
        let whole = npy(header, &bytes(&[1.0, 2.0, 3.0]));
        for length in [6, 9, 20, whole.len() - 1] {
            assert!(message(&whole[..length]).contains("ends within the array"), "{length}");
        }
        let text = "{'descr': '<U5', 'fortran_order': False, 'shape': (1,), }";
        assert!(message(&npy(text, &[0; 20])).contains("x: its type '<U5' is none of real numbers"));
        let huge = "{'descr': '<f8', 'fortran_order': False, 'shape': (9223372036854775807, 9), }";
        assert!(message(&npy(huge, &[])).contains("ends within the array"));
    }
}
