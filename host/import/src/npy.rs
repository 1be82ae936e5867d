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

use std::io::{Cursor, Read};

use zip::ZipArchive;

use super::number::{Kind, columns, transposed};
use super::{Problem, Variable};

/// Whether an archive is one of NumPy's: all its files are arrays.
pub fn is_archive(bytes: &[u8]) -> bool {
    ZipArchive::new(Cursor::new(bytes)).is_ok_and(|archive| {
        !archive.is_empty() && archive.file_names().all(|name| name.is_ok_and(|name| name.ends_with(".npy")))
    })
}

/// The variables of an archive.
///
/// # Errors
/// The archive is damaged, or an array does not hold numbers.
pub fn archive(bytes: &[u8]) -> Result<Vec<Variable>, Problem> {
    let damaged = |error: &dyn std::fmt::Display| Problem::Damaged(error.to_string());
    let mut archive = ZipArchive::new(Cursor::new(bytes)).map_err(|error| damaged(&error))?;
    let mut all = Vec::new();
    for place in 0..archive.len() {
        let mut file = archive.by_index(place).map_err(|error| damaged(&error))?;
        let name = file.name().map_err(|error| damaged(&error))?.trim_end_matches(".npy").to_owned();
        let mut content = Vec::new();
        file.read_to_end(&mut content).map_err(|error| damaged(&error))?;
        all.extend(array(&name, &content)?);
    }
    Ok(all)
}

/// The variables of an array under a name.
///
/// # Errors
/// It is damaged, or no array of numbers.
pub fn array(name: &str, bytes: &[u8]) -> Result<Vec<Variable>, Problem> {
    let cut = || Problem::Damaged(format!("{name} ends within the array"));
    let refused = |why: String| Problem::Variable { name: name.to_owned(), why };
    let version = *bytes.get(6).ok_or_else(cut)?;
    let begins = if version == 1 { 10 } else { 12 };
    let length = bytes.get(8..begins).ok_or_else(cut)?;
    let length = length.iter().rev().fold(0_usize, |sum, byte| (sum << 8) | usize::from(*byte));
    let header = bytes.get(begins..begins + length).ok_or_else(cut)?;
    let header = String::from_utf8_lossy(header);
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
    let count = shape.iter().try_fold(1_usize, |product, size| product.checked_mul(*size)).ok_or_else(cut)?;
    let width: usize = fields.iter().map(|(_, kind)| kind.width).sum();
    let end = count.checked_mul(width).and_then(|size| size.checked_add(begins + length)).ok_or_else(cut)?;
    let data = bytes.get(begins + length..end).ok_or_else(cut)?;
    let mut found = Vec::new();
    let mut offset = 0;
    for (field, kind) in fields {
        let value = |row: &[u8]| kind.value(&field, &row[offset..offset + kind.width]);
        let values: Vec<f64> = data.chunks_exact(width).map(value).collect::<Result<_, _>>()?;
        offset += kind.width;
        found.extend(match shape[..] {
            [] | [_] => vec![(field, values)],
            [1, _] => vec![(field, values)],
            [rows, width] if !is_fortran => columns(&field, rows, transposed(rows, width, &values)),
            [rows, _] => columns(&field, rows, values),
            _ => return Err(refused(format!("it has {} dimensions; a row a sample is needed", shape.len()))),
        });
    }
    Ok(found)
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
    use super::*;

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
            let header = format!("{{'descr': '<f8', 'fortran_order': {order}, 'shape': (3, 2), }}");
            array("x", &npy(&header, &values)).expect("an array")
        };
        assert_eq!(of("False")[1], ("x_2".to_owned(), vec![2.0, 4.0, 6.0]));
        assert_eq!(of("True")[1], ("x_2".to_owned(), vec![4.0, 5.0, 6.0]));
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
        let found = array("table", &npy(header, &data)).expect("fields");
        let values: Vec<&[f64]> = found.iter().map(|(_, values)| values.as_slice()).collect();
        assert_eq!(values, [[-2.0, 300.0], [1.5, -0.25], [1.0, 0.0]]);
        assert_eq!(found[1].0, "p");
    }

    #[test]
    fn what_is_cut_off_or_no_number_is_refused() {
        let header = "{'descr': '<f8', 'fortran_order': False, 'shape': (3,), }";
        let message = |bytes: &[u8]| array("x", bytes).expect_err("refused").to_string();
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
