//! MATLAB's files of version 5 (and of 6 and 7, which are packed): real arrays of numbers.
//!
//! # Format (MathWorks, *MAT-File Format*)
//! 128 bytes of header, then variables: a tag, which says kind and size, and a content, which may
//! be packed (zlib). That of an array is: flags with its class, dimensions, name, the real parts,
//! column by column and in the narrowest type that holds all of them, and the imaginary ones. Each
//! of these has a tag of its own; one of up to four bytes stands in its tag.
//!
//! A variable that is packed is unpacked into a file, so that no numbers are held.

use std::fs::File;
use std::io::{self, ErrorKind, Read};
use std::ops::RangeInclusive;
use std::path::Path;
use std::sync::Arc;

use flate2::read::ZlibDecoder;
use recording::input::FromPlace;

use super::array::{Array, exactly, unreadable};
use super::number::Kind;
use super::variables::Variable;
use super::{Problem, scratch};

/// Bytes before the first variable.
const HEADER: usize = 128;
/// Bytes of a tag. Contents end at multiples of as many.
const TAG: u64 = 8;
/// The kinds of contents that an array needs.
const NAME: u32 = 1;
const DIMENSIONS: u32 = 5;
const FLAGS: u32 = 6;
const ARRAY: u32 = 14;
const PACKED: u32 = 15;
/// The classes of arrays of numbers, without sparse ones.
const NUMBERS: RangeInclusive<u32> = 6..=15;
/// The flag of complex numbers.
const IS_COMPLEX: u32 = 0x800;

/// The variables of a file; what is complex, or no array of numbers, is passed over.
///
/// # Errors
/// The file is damaged.
pub fn variables(file: &Arc<File>, folder: Option<&Path>) -> Result<Vec<Box<dyn Variable>>, Problem> {
    let header = exactly(&mut FromPlace::new(file, 0), HEADER).map_err(cut)?;
    let is_big_endian = &header[HEADER - 2..] == b"MI";
    let length = file.metadata()?.len();
    let mut found: Vec<Box<dyn Variable>> = Vec::new();
    let mut begins = HEADER as u64;
    while begins < length {
        let mut variable = Content { bytes: FromPlace::new(file, begins), place: 0, is_big_endian };
        let (kind, size) = variable.tag()?;
        begins += variable.place;
        if begins + size > length {
            return Err(cut(ErrorKind::UnexpectedEof.into()));
        }
        let array = match kind {
            ARRAY => array(file, begins, size, is_big_endian)?,
            PACKED => {
                let bytes = ZlibDecoder::new(variable.bytes.take(size));
                let mut variable = Content { bytes, place: 0, is_big_endian };
                let (kind, size) = variable.tag()?;
                let unpacked = scratch::copy(folder, &mut variable.bytes.take(size)).map_err(cut)?;
                if unpacked.metadata()?.len() < size {
                    return Err(cut(ErrorKind::UnexpectedEof.into()));
                }
                if kind == ARRAY { array(&unpacked, 0, size, is_big_endian)? } else { None }
            }
            _ => None,
        };
        found.extend(array.map(|array| Box::new(array) as Box<dyn Variable>));
        begins += size;
    }
    Ok(found)
}

/// The array whose content begins at byte `begins` and has `size` bytes; None where it holds
/// something else than real numbers, is empty, or has no name, as what MATLAB keeps for itself.
fn array(file: &Arc<File>, begins: u64, size: u64, is_big_endian: bool) -> Result<Option<Array>, Problem> {
    let mut content = Content { bytes: FromPlace::new(file, begins).take(size), place: 0, is_big_endian };
    let flags = content.whole(FLAGS)?;
    let flags = content.number(&flags);
    if !NUMBERS.contains(&(flags & 0xff)) || flags & IS_COMPLEX != 0 {
        return Ok(None);
    }
    let sizes = content.whole(DIMENSIONS)?;
    let sizes: Vec<usize> = sizes.chunks(4).map(|size| content.number(size) as usize).collect();
    let name = String::from_utf8_lossy(&content.whole(NAME)?).into_owned();
    let (rows, width) = match sizes[..] {
        // A row is as good as a column.
        [1, count] => (count, 1),
        [rows, ref across @ ..] => (rows, across.iter().copied().fold(1, usize::saturating_mul)),
        [] => (0, 0),
    };
    if rows == 0 || width == 0 || name.is_empty() {
        return Ok(None);
    }
    let (kind, bytes) = content.tag()?;
    let Some(kind) = stored(kind, is_big_endian) else {
        return Err(Problem::Damaged(format!("{name} has numbers of the unknown kind {kind}")));
    };
    let expected = rows.checked_mul(width).and_then(|count| count.checked_mul(kind.width));
    if expected.is_none_or(|expected| expected as u64 != bytes) || content.place + bytes > size {
        return Err(Problem::Damaged(format!("{name} has {bytes} bytes for {sizes:?} numbers")));
    }
    let begins = begins + content.place;
    let (file, fields) = (Arc::clone(file), vec![(name.clone(), kind)]);
    Ok(Some(Array { file, begins, name, fields, rows, width, is_by_columns: true }))
}

/// How numbers of a kind are stored.
fn stored(kind: u32, is_big_endian: bool) -> Option<Kind> {
    let (letter, width) = match kind {
        1 => ('i', 1),
        2 => ('u', 1),
        3 => ('i', 2),
        4 => ('u', 2),
        5 => ('i', 4),
        6 => ('u', 4),
        7 => ('f', 4),
        9 => ('f', 8),
        12 => ('i', 8),
        13 => ('u', 8),
        _ => return None,
    };
    Some(Kind { letter, width, is_big_endian })
}

/// Contents one behind the other.
struct Content<R> {
    bytes: R,
    /// Bytes before the next one.
    place: u64,
    is_big_endian: bool,
}

impl<R: Read> Content<R> {
    /// The kind and the size of the next content, which is read from its place on.
    fn tag(&mut self) -> Result<(u32, u64), Problem> {
        let begin = exactly(&mut self.bytes, 4).map_err(cut)?;
        let kind = self.number(&begin);
        if kind >> 16 > 0 {
            self.place += TAG / 2;
            return Ok((kind & 0xffff, (kind >> 16).into()));
        }
        let size = exactly(&mut self.bytes, 4).map_err(cut)?;
        self.place += TAG;
        Ok((kind, self.number(&size).into()))
    }

    /// The next content, which is to be of a kind and no numbers.
    fn whole(&mut self, expected: u32) -> Result<Vec<u8>, Problem> {
        let (kind, size) = self.tag()?;
        if kind != expected {
            return Err(Problem::Damaged(format!("a content of kind {kind} where {expected} is to be")));
        }
        let content = exactly(&mut self.bytes, size as usize).map_err(cut)?;
        let ends = self.place + size;
        self.place = ends.next_multiple_of(TAG);
        exactly(&mut self.bytes, (self.place - ends) as usize).map_err(cut)?;
        Ok(content)
    }

    /// The whole number of these four bytes.
    fn number(&self, bytes: &[u8]) -> u32 {
        let join = |number: u32, byte: &u8| (number << 8) | u32::from(*byte);
        let bytes = bytes.get(..4).unwrap_or(bytes);
        if self.is_big_endian { bytes.iter().fold(0, join) } else { bytes.iter().rev().fold(0, join) }
    }
}

/// What is wrong where bytes of a variable cannot be had.
fn cut(error: io::Error) -> Problem {
    unreadable(|| "it ends within a variable".to_owned())(error)
}

#[cfg(test)]
mod tests {
    use std::io::Write;

    use flate2::Compression;
    use flate2::write::ZlibEncoder;

    use super::super::variables::tests::read;
    use super::*;

    /// How a file is written: the order of bytes, and whether variables are packed.
    #[derive(Clone, Copy)]
    struct Style {
        is_big_endian: bool,
        is_packed: bool,
    }

    impl Style {
        fn number(self, number: u32) -> [u8; 4] {
            if self.is_big_endian { number.to_be_bytes() } else { number.to_le_bytes() }
        }

        /// A content with its tag.
        fn content(self, kind: u32, bytes: &[u8]) -> Vec<u8> {
            let size = bytes.len() as u32;
            let mut content = match size {
                1..=4 => self.number(size << 16 | kind).to_vec(),
                size => [self.number(kind), self.number(size)].concat(),
            };
            content.extend(bytes);
            content.resize(content.len().next_multiple_of(TAG as usize), 0);
            content
        }

        /// A variable.
        fn array(self, class: u32, sizes: &[u32], name: &str, kind: u32, numbers: &[u8]) -> Vec<u8> {
            let sizes: Vec<u8> = sizes.iter().flat_map(|&size| self.number(size)).collect();
            let content = [
                self.content(FLAGS, &[self.number(class), self.number(0)].concat()),
                self.content(DIMENSIONS, &sizes),
                self.content(NAME, name.as_bytes()),
                self.content(kind, numbers),
            ];
            let array = self.content(ARRAY, &content.concat());
            if !self.is_packed {
                return array;
            }
            let mut packed = ZlibEncoder::new(Vec::new(), Compression::default());
            packed.write_all(&array).expect("in memory");
            let packed = packed.finish().expect("in memory");
            [&self.number(PACKED)[..], &self.number(packed.len() as u32), &packed].concat()
        }

        fn file(self, variables: &[Vec<u8>]) -> Vec<u8> {
            let mut bytes = b"MATLAB 5.0".to_vec();
            bytes.resize(HEADER - 4, b' ');
            bytes.extend(if self.is_big_endian { b"\x01\x00MI" } else { b"\x00\x01IM" });
            bytes.extend(variables.concat());
            bytes
        }
    }

    fn columns(bytes: &[u8]) -> Result<Vec<(String, Vec<f64>)>, Problem> {
        let mut file = tempfile::tempfile().expect("a file");
        file.write_all(bytes).expect("it is written");
        read(variables(&Arc::new(file), None)?, 2)
    }

    /// Real numbers in a narrower type, whole ones, a matrix, text, complex numbers, an empty array
    /// and one without a name.
    fn variables_of(style: Style) -> Vec<Vec<u8>> {
        let whole: Vec<u8> =
            [-7, 8, 9].iter().flat_map(|&number: &i32| style.number(number as u32)).collect();
        let real = |number: f64| {
            if style.is_big_endian { number.to_be_bytes() } else { number.to_le_bytes() }
        };
        let matrix: Vec<u8> =
            [1.5, 2.5, 3.5, 4.5, 5.5, 6.5].iter().flat_map(|&number| real(number)).collect();
        vec![
            style.array(6, &[3, 1], "t", 2, &[1, 2, 255]),
            style.array(12, &[1, 3], "k", 5, &whole),
            style.array(4, &[1, 3], "text", 2, b"abc"),
            style.array(6 | IS_COMPLEX, &[3, 1], "z", 2, &[1, 2, 3]),
            style.array(6, &[0, 0], "none", 9, &[]),
            style.array(9, &[1, 3], "", 2, &[1, 2, 3]),
            style.array(6, &[3, 2], "x", 9, &matrix),
        ]
    }

    #[test]
    fn arrays_of_either_order_of_bytes_packed_or_not_are_columns() {
        for (is_big_endian, is_packed) in [(false, false), (false, true), (true, false), (true, true)] {
            let style = Style { is_big_endian, is_packed };
            let found = columns(&style.file(&variables_of(style))).expect("a file");
            let wanted = [
                ("t", [1.0, 2.0, 255.0]),
                ("k", [-7.0, 8.0, 9.0]),
                ("x_1", [1.5, 2.5, 3.5]),
                ("x_2", [4.5, 5.5, 6.5]),
            ];
            assert_eq!(found, wanted.map(|(name, values)| (name.to_owned(), values.to_vec())));
        }
        // What is packed ends anywhere.
        let plain = Style { is_big_endian: false, is_packed: false };
        let both = [Style { is_packed: true, ..plain }, plain].map(|style| variables_of(style).concat());
        assert_eq!(columns(&plain.file(&both)).expect("a file").len(), 8);
    }

    #[test]
    fn a_file_that_is_cut_off_anywhere_is_refused() {
        for is_packed in [false, true] {
            let style = Style { is_big_endian: false, is_packed };
            let variables = variables_of(style);
            let whole = style.file(&variables);
            let mut ends = HEADER;
            let between: Vec<usize> = variables
                .iter()
                .map(|variable| {
                    ends += variable.len();
                    ends
                })
                .collect();
            for length in (0..whole.len()).filter(|length| *length != HEADER && !between.contains(length)) {
                assert!(matches!(columns(&whole[..length]), Err(Problem::Damaged(_))), "{length}");
            }
            // A size that does not fit the dimensions.
            let other = style.array(6, &[4, 1], "t", 2, &[1, 2, 3]);
            assert!(matches!(columns(&style.file(&[other])), Err(Problem::Damaged(_))));
        }
    }
}
