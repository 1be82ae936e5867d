//! Values in registers: words of 16 bits, the high one first.

/// What the words of a register are.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Kind {
    /// A word.
    U16,
    /// A word, with a sign.
    I16,
    /// Two words.
    U32,
    /// Two words, with a sign.
    I32,
    /// Two words: IEEE 754, single precision.
    F32,
}

impl Kind {
    /// Number of words.
    pub const fn words(self) -> u16 {
        match self {
            Self::U16 | Self::I16 => 1,
            Self::U32 | Self::I32 | Self::F32 => 2,
        }
    }

    /// Its usual short name.
    pub const fn name(self) -> &'static str {
        match self {
            Self::U16 => "u16",
            Self::I16 => "i16",
            Self::U32 => "u32",
            Self::I32 => "i32",
            Self::F32 => "f32",
        }
    }
}

/// A value of a register.
#[derive(Clone, Copy, Debug, PartialEq)]
#[allow(missing_docs, reason = "the kinds of the same names say what they are")]
pub enum Value {
    U16(u16),
    I16(i16),
    U32(u32),
    I32(i32),
    F32(f32),
}

impl Value {
    /// What it is.
    pub const fn kind(self) -> Kind {
        match self {
            Self::U16(_) => Kind::U16,
            Self::I16(_) => Kind::I16,
            Self::U32(_) => Kind::U32,
            Self::I32(_) => Kind::I32,
            Self::F32(_) => Kind::F32,
        }
    }

    /// The value of these words; `None` if there are too few.
    pub fn of_words(kind: Kind, words: &[u16]) -> Option<Self> {
        let &high = words.first()?;
        let pair = || Some(u32::from(high) << 16 | u32::from(*words.get(1)?));
        Some(match kind {
            Kind::U16 => Self::U16(high),
            Kind::I16 => Self::I16(high.cast_signed()),
            Kind::U32 => Self::U32(pair()?),
            Kind::I32 => Self::I32(pair()?.cast_signed()),
            Kind::F32 => Self::F32(f32::from_bits(pair()?)),
        })
    }

    /// Its word of this number, counted from 0; that of a value without such a word is 0.
    pub const fn word(self, index: u16) -> u16 {
        let (bits, words) = match self {
            Self::U16(value) => (value as u32, 1),
            Self::I16(value) => (value.cast_unsigned() as u32, 1),
            Self::U32(value) => (value, 2),
            Self::I32(value) => (value.cast_unsigned(), 2),
            Self::F32(value) => (value.to_bits(), 2),
        };
        match (words, index) {
            (2, 0) => (bits >> 16) as u16,
            (2, 1) | (1, 0) => bits as u16,
            _ => 0,
        }
    }

    /// Its words.
    pub fn words(self) -> impl Iterator<Item = u16> {
        (0..self.kind().words()).map(move |index| self.word(index))
    }

    /// The number that it stands for; exact.
    pub const fn number(self) -> f64 {
        match self {
            Self::U16(value) => value as f64,
            Self::I16(value) => value as f64,
            Self::U32(value) => value as f64,
            Self::I32(value) => value as f64,
            Self::F32(value) => value as f64,
        }
    }

    /// The value of a kind that is nearest to a number; a NaN is 0 in a whole kind.
    pub const fn of_number(kind: Kind, number: f64) -> Self {
        // The conversion cuts off towards 0 and saturates; the half makes it round.
        let half = if number < 0.0 { -0.5 } else { 0.5 };
        match kind {
            Kind::U16 => Self::U16((number + half) as u16),
            Kind::I16 => Self::I16((number + half) as i16),
            Kind::U32 => Self::U32((number + half) as u32),
            Kind::I32 => Self::I32((number + half) as i32),
            Kind::F32 => Self::F32(number as f32),
        }
    }
}

#[cfg(test)]
mod tests {
    extern crate std;
    use super::*;

    #[test]
    fn a_value_survives_its_words() {
        let values = [
            Value::U16(0xA55A),
            Value::I16(-2),
            Value::U32(0x1234_5678),
            Value::I32(-70_000),
            Value::F32(-1.5),
        ];
        for value in values {
            let words: std::vec::Vec<_> = value.words().collect();
            assert_eq!(Value::of_words(value.kind(), &words), Some(value));
            assert_eq!(Value::of_number(value.kind(), value.number()), value);
            assert_eq!(Value::of_words(value.kind(), &words[1..]), None);
        }
    }

    #[test]
    fn the_high_word_comes_first() {
        assert!(Value::U32(0x1234_5678).words().eq([0x1234, 0x5678]));
        assert!(Value::F32(1.0).words().eq([0x3F80, 0]));
    }
}
