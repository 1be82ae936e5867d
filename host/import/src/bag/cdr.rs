//! Messages in CDR, the Common Data Representation of the OMG: what ROS 2 sends and records.
//!
//! Four bytes say the order of bytes; then numbers stand one behind the other, each at a multiple
//! of its size, counted from behind these four.

use super::ELEMENTS;
use super::definition::{Count, Definition, Field, Kind};
use crate::number;

/// Types within types that are followed, at most: a definition may use itself.
const DEPTH: usize = 32;

/// Hands every number of a message on, with its path in the message.
///
/// # Errors
/// The message ends within a field, or is no CDR.
pub fn read(definition: &Definition, message: &[u8], add: &mut dyn FnMut(&str, f64)) -> Result<(), String> {
    let is_big_endian = match message.get(..4) {
        Some([0, 0, ..]) => true,
        Some([0, 1, ..]) => false,
        Some([_, kind, ..]) => return Err(format!("CDR of kind {kind} is not read")),
        _ => return Err("it ends within its first four bytes".to_owned()),
    };
    let mut cursor = Cursor { bytes: &message[4..], place: 0, is_big_endian };
    cursor.read(definition, 0, &mut String::new(), DEPTH, add)
}

struct Cursor<'a> {
    bytes: &'a [u8],
    place: usize,
    is_big_endian: bool,
}

impl<'a> Cursor<'a> {
    fn read(
        &mut self,
        definition: &Definition,
        of: usize,
        path: &mut String,
        depth: usize,
        add: &mut dyn FnMut(&str, f64),
    ) -> Result<(), String> {
        if depth == 0 {
            return Err("its types go deeper than any message's".to_owned());
        }
        for Field { name, kind, count } in &definition.types[of] {
            let length = path.len();
            if length > 0 {
                path.push('.');
            }
            path.push_str(name);
            let many = match count {
                Count::One => None,
                Count::Fixed(count) => Some(*count),
                Count::Any => Some(self.count(path)?),
            };
            for place in 0..many.unwrap_or(1) {
                let named = path.len();
                if many.is_some() {
                    path.push_str(&format!("_{}", place + 1));
                }
                // What is no variable has to be passed over all the same.
                let is_variable = many.is_none_or(|many| many <= ELEMENTS);
                match kind {
                    Kind::Number(letter, width) => {
                        let (letter, width) = (*letter, *width);
                        let bytes = self.take(width, width, path)?;
                        let kind = number::Kind { letter, width, is_big_endian: self.is_big_endian };
                        if is_variable {
                            // A counter that no `f64` has is no variable of a recording.
                            add(path, kind.value(path, bytes).unwrap_or(f64::NAN));
                        }
                    }
                    Kind::Text => {
                        let count = self.count(path)?;
                        self.take(1, count, path)?;
                    }
                    Kind::Type(of) => {
                        let mut pass = |_: &str, _: f64| {};
                        match is_variable {
                            true => self.read(definition, *of, path, depth - 1, &mut *add)?,
                            false => self.read(definition, *of, path, depth - 1, &mut pass)?,
                        }
                    }
                }
                path.truncate(named);
            }
            path.truncate(length);
        }
        Ok(())
    }

    /// How many there are.
    fn count(&mut self, path: &str) -> Result<usize, String> {
        let bytes = self.take(4, 4, path)?;
        let bytes: [u8; 4] = bytes.try_into().map_err(|_| "four bytes".to_owned())?;
        let count = if self.is_big_endian { u32::from_be_bytes(bytes) } else { u32::from_le_bytes(bytes) };
        Ok(count as usize)
    }

    /// So many bytes, at a multiple of a size.
    fn take(&mut self, size: usize, count: usize, path: &str) -> Result<&'a [u8], String> {
        let begins = self.place.next_multiple_of(size.max(1));
        let bytes = begins.checked_add(count).and_then(|ends| self.bytes.get(begins..ends));
        self.place = begins.saturating_add(count);
        bytes.ok_or_else(|| format!("it ends within {path}"))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn numbers(text: &str, message: &[u8]) -> Result<Vec<(String, f64)>, String> {
        let mut found = Vec::new();
        let definition = Definition::parse("my/Thing", text)?;
        read(&definition, message, &mut |path, value| found.push((path.to_owned(), value)))?;
        Ok(found)
    }

    #[test]
    fn numbers_stand_at_multiples_of_their_size() {
        let mut message = vec![0, 1, 0, 0, 7, 0, 0, 0];
        message.extend(3_u32.to_le_bytes()); // a text of two letters and its end
        message.extend(b"ab\0\0");
        message.extend([0; 4]); // up to a multiple of 8, counted from behind the first four bytes
        message.extend(1.5_f64.to_le_bytes());
        message.extend(2_u32.to_le_bytes());
        message.extend((-3_i16).to_le_bytes());
        message.extend(4_i16.to_le_bytes());
        let text = "uint8 a\nstring s\nfloat64 b\nint16[] c";
        let wanted = [("a", 7.0), ("b", 1.5), ("c_1", -3.0), ("c_2", 4.0)];
        let found = numbers(text, &message).expect("read");
        assert_eq!(found, wanted.map(|(name, value)| (name.to_owned(), value)));
        for length in 0..message.len() {
            assert!(numbers(text, &message[..length]).is_err(), "{length}");
        }
        assert!(numbers(text, &[0, 3, 0, 0, 1]).expect_err("refused").contains("kind 3"));
    }

    #[test]
    fn a_type_that_uses_itself_has_an_end() {
        let error = numbers("Thing again", &[0, 1, 0, 0]).expect_err("refused");
        assert!(error.contains("deeper"), "{error}");
        // And a count that is larger than any message.
        let error = numbers("float64[] x", &[0, 1, 0, 0, 255, 255, 255, 255]).expect_err("refused");
        assert!(error.contains("ends within x_1"), "{error}");
    }
}
