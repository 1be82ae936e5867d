//! How a board is reached on its bus: kept by it, taken at its next start or by an order.

use serde::{Deserialize, Serialize};

use crate::registers::{BAUD, Id, UNIT, Value, fields};

/// Number, rate, parity and patience.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct BusParameters {
    /// The board's number, 1 to 247; 0 is everybody's.
    pub unit: u8,
    /// Unit: bit/s.
    pub baud: u32,
    /// The bit that checks the eight others of a byte.
    pub parity: Parity,
    /// Least time from the end of a request to its answer, for masters that are slow to let go of
    /// the line. Unit: µs.
    pub turnaround_us: u32,
}

/// The bit that checks the others of a byte; one stop bit follows in any case.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum Parity {
    /// There is none.
    None,
    /// The ones are even in number.
    Even,
    /// The ones are odd in number.
    Odd,
}

impl Parity {
    /// By its number in the register.
    pub const ALL: [Self; 3] = [Self::None, Self::Even, Self::Odd];

    /// Its number in the register.
    pub const fn number(self) -> u16 {
        self as u16
    }

    /// The one with a number.
    pub fn of_number(number: u16) -> Option<Self> {
        Self::ALL.get(usize::from(number)).copied()
    }
}

impl BusParameters {
    /// Those of a new board, and of one that nobody is heard on.
    pub const STANDARD: Self = Self { unit: UNIT, baud: BAUD, parity: Parity::None, turnaround_us: 0 };

    /// The same line as a new board's, by this number.
    #[must_use]
    pub const fn on_standard_line(self) -> Self {
        Self { unit: self.unit, ..Self::STANDARD }
    }

    /// Whether each is within the limits of its register.
    pub fn is_valid(&self) -> bool {
        let takes = |id: Id| {
            let value = fields::of_bus(&mut self.clone(), id).map(|field| field.get());
            value.is_some_and(|value: Value| id.register().takes(value))
        };
        fields::BUS.into_iter().all(takes)
    }

    /// Bits of a byte on the line: start, data, parity and stop.
    pub const fn byte_bits(&self) -> u32 {
        match self.parity {
            Parity::None => 10,
            Parity::Even | Parity::Odd => 11,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_standard_is_valid_and_what_no_register_takes_is_not() {
        let standard = BusParameters::STANDARD;
        assert!(standard.is_valid());
        for wrong in [
            BusParameters { unit: 0, ..standard },
            BusParameters { unit: 248, ..standard },
            BusParameters { baud: 9_599, ..standard },
            BusParameters { baud: 1_000_001, ..standard },
            BusParameters { turnaround_us: 50_001, ..standard },
        ] {
            assert!(!wrong.is_valid(), "{wrong:?}");
        }
    }

    #[test]
    fn every_parity_is_found_by_its_number() {
        for parity in Parity::ALL {
            assert_eq!(Parity::of_number(parity.number()), Some(parity));
        }
        assert_eq!(Parity::of_number(3), None);
    }
}
