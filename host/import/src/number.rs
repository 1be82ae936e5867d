//! Numbers as files store them, and matrices of them.

use super::{Problem, Variable};

/// The columns of a matrix in the order of Fortran, each under a name of its own.
pub fn columns(name: &str, rows: usize, values: Vec<f64>) -> Vec<Variable> {
    match rows {
        0 => Vec::new(),
        rows if rows == values.len() => vec![(name.to_owned(), values)],
        rows => {
            let named = |(place, column): (usize, &[f64])| (format!("{name}_{}", place + 1), column.to_vec());
            values.chunks(rows).enumerate().map(named).collect()
        }
    }
}

/// A whole number as an `f64`.
///
/// # Errors
/// There is no such number.
pub fn whole(name: &str, value: i128) -> Result<f64, Problem> {
    let number = value as f64;
    match number as i128 == value {
        true => Ok(number),
        false => Err(Problem::Variable {
            name: name.to_owned(),
            why: format!("{value} is no number of double precision; store differences to the first one"),
        }),
    }
}

/// A matrix whose rows stand one behind the other, its columns one behind the other.
pub fn transposed(rows: usize, width: usize, values: &[f64]) -> Vec<f64> {
    (0..width).flat_map(|column| (0..rows).map(move |row| values[row * width + column])).collect()
}

/// How a number is stored.
#[derive(Clone, Copy, Debug)]
pub struct Kind {
    /// As NumPy has it: f, i, u, b.
    pub letter: char,
    /// Unit: bytes.
    pub width: usize,
    /// Whether the first byte is the highest.
    pub is_big_endian: bool,
}

impl Kind {
    /// That of `<f8`.
    pub fn of(text: &str) -> Option<Self> {
        let mut letters = text.chars();
        let (order, letter) = (letters.next()?, letters.next()?);
        let width: usize = letters.as_str().parse().ok()?;
        let is_known = matches!((letter, width), ('f', 4 | 8) | ('i' | 'u', 1 | 2 | 4 | 8) | ('b', 1));
        (is_known && "<>|=".contains(order)).then_some(Self { letter, width, is_big_endian: order == '>' })
    }

    /// A number of this many bytes.
    ///
    /// # Errors
    /// A whole number that no `f64` has.
    pub fn value(self, name: &str, bytes: &[u8]) -> Result<f64, Problem> {
        let mut wide = [0_u8; 8];
        // Little-endian from here on.
        for (place, byte) in bytes.iter().enumerate() {
            wide[if self.is_big_endian { self.width - 1 - place } else { place }] = *byte;
        }
        let bits = u64::from_le_bytes(wide);
        match (self.letter, self.width) {
            ('f', 8) => Ok(f64::from_bits(bits)),
            ('f', _) => Ok(f64::from(f32::from_bits(bits as u32))),
            ('i', width) => {
                let unused = 64 - 8 * width as u32;
                whole(name, (((bits << unused) as i64) >> unused).into())
            }
            _ => whole(name, bits.into()),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_matrix_is_a_column_each() {
        let found = columns("x", 2, vec![1.0, 2.0, 3.0, 4.0]);
        assert_eq!(found, [("x_1".to_owned(), vec![1.0, 2.0]), ("x_2".to_owned(), vec![3.0, 4.0])]);
    }

    #[test]
    fn whole_numbers_that_would_be_rounded_are_refused() {
        assert_eq!(whole("t", 1 << 53).ok(), Some((1_u64 << 53) as f64));
        assert!(whole("t", (1 << 53) + 1).is_err());
    }
}
