//! Numbers as files store them.

use super::Problem;

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
    fn whole_numbers_that_would_be_rounded_are_refused() {
        assert_eq!(whole("t", 1 << 53).ok(), Some((1_u64 << 53) as f64));
        assert!(whole("t", (1 << 53) + 1).is_err());
    }
}
