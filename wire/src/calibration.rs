//! What two points a sensor have shown: the straight lines between quantities and codes, and when.

use serde::{Deserialize, Serialize};

use crate::input::{Inputs, checksum_of};
use crate::registers::{Id, Value, fields};

/// A straight line between a quantity and a converter's code.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Line {
    /// The code of 0. Unit: code.
    pub zero_code: f32,
    /// Unit: code per unit of the quantity.
    pub codes_per_unit: f32,
}

impl Line {
    /// Through two points, a quantity and its code each; `None` where they are the same quantity.
    pub fn through([low, high]: [(f32, f32); 2]) -> Option<Self> {
        let codes_per_unit = (high.1 - low.1) / (high.0 - low.0);
        codes_per_unit
            .is_finite()
            .then_some(Self { zero_code: low.1 - low.0 * codes_per_unit, codes_per_unit })
    }
}

/// The lines of a board.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Calibration {
    /// ADC code of the pressure in the muscle, in bar.
    pub pressure: Line,
    /// ADC code of the contraction, in mm.
    pub contraction: Line,
    /// ADC code of the pressure before the valve, in bar.
    pub supply: Line,
    /// DAC code of the command in bar: by what the pressure sensor shows.
    pub command: Line,
    /// Days from 1970-01-01 to the last change; 0 on a board that nobody has calibrated.
    pub day: u32,
    /// How the sensors are connected.
    pub inputs: Inputs,
}

impl Calibration {
    /// The CRC-32 (ISO-HDLC) over all that stands before it in the registers, as bytes there; the
    /// inputs have one of their own.
    pub fn checksum(&self) -> u32 {
        checksum_of(&fields::CALIBRATION, |id| self.value(id))
    }

    /// Its value at a register of the group "Calibration".
    pub fn value(&self, id: Id) -> Option<Value> {
        match id {
            Id::CalibrationChecksum => Some(Value::U32(self.checksum())),
            _ => fields::of_calibration(&mut self.clone(), id)
                .map(|field| field.get())
                .or_else(|| self.inputs.value(id)),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_line_goes_through_its_points_and_none_through_one_quantity() {
        let line = Line::through([(0.5, 573.0), (6.5, 2539.0)]).expect("two quantities");
        assert!((line.codes_per_unit - 327.666_66).abs() < 1e-3);
        assert!((line.zero_code + 0.5 * line.codes_per_unit - 573.0).abs() < 1e-3);
        assert_eq!(Line::through([(1.0, 500.0), (1.0, 600.0)]), None);
    }

    #[test]
    fn every_number_of_a_calibration_is_part_of_its_checksum() {
        let line = Line { zero_code: 1.0, codes_per_unit: 2.0 };
        let of = Calibration {
            pressure: line,
            contraction: line,
            supply: line,
            command: line,
            day: 3,
            inputs: Inputs::STANDARD,
        };
        for id in fields::CALIBRATION {
            let mut other = of;
            let field = fields::of_calibration(&mut other, id).expect("a register of the group");
            let value = field.get();
            field.set(Value::of_number(value.kind(), value.number() + 1.0));
            assert_ne!(other.checksum(), of.checksum(), "{id:?}");
        }
    }
}
