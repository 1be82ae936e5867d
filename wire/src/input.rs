//! How a sensor is connected to its input, and what its codes mean before two points were taken.

use serde::{Deserialize, Serialize};

use crate::message::Scaling;
use crate::registers::{Id, Value, checksum, fields};

/// The converter's range. Unit: V, code.
const PIN_V: f32 = 3.3;
const CODES: f32 = 4095.0;
/// Nearer to the rail a converter cannot be trusted; the same as for the standard potentiometer.
/// Unit: code.
const RAIL_CODES: f32 = 40.0;
/// Live zero and end of a current signal, and what counts as a failed sensor (NAMUR NE 43): up to
/// 3.6 mA, and from 21 mA on. Unit: share of 20 mA.
const ZERO_SHARE: f32 = 4.0 / 20.0;
const FAILED_LOW_SHARE: f32 = 3.6 / 20.0;
const FAILED_HIGH_SHARE: f32 = 21.0 / 20.0;

/// What a sensor puts out.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum Signal {
    /// A share of the converter's own supply: the standard sensors.
    Ratiometric,
    /// 4 to 20 mA, over a resistor to ground.
    Current,
    /// 0 to 10 V, by a divider.
    Voltage,
}

impl Signal {
    /// By its number in the register.
    pub const ALL: [Self; 3] = [Self::Ratiometric, Self::Current, Self::Voltage];

    /// Its number in the register.
    pub const fn number(self) -> u16 {
        self as u16
    }

    /// The one with a number.
    pub fn of_number(number: u16) -> Option<Self> {
        Self::ALL.get(usize::from(number)).copied()
    }
}

/// A sensor's signal and its range. Of a ratiometric one the numbers are 0, and not looked at.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Input {
    /// What it puts out.
    pub signal: Signal,
    /// At the pin, by 20 mA or 10 V. Unit: V.
    pub pin_v: f32,
    /// At 4 mA or 0 V. Unit: bar or mm.
    pub low: f32,
    /// At 20 mA or 10 V. Unit: bar or mm.
    pub high: f32,
}

impl Input {
    /// That of a standard sensor.
    pub const RATIOMETRIC: Self = Self { signal: Signal::Ratiometric, pin_v: 0.0, low: 0.0, high: 0.0 };

    /// What `pin_v` may be: enough of the converter's range, and 21 mA or 10 V below its rail.
    /// Unit: V.
    pub fn pin_limits_v(&self) -> [f32; 2] {
        let rail_v = (CODES - RAIL_CODES) / CODES * PIN_V;
        [1.0, if self.signal == Signal::Current { rail_v / FAILED_HIGH_SHARE } else { rail_v }]
    }

    /// The scaling by its range alone; none of a ratiometric one, which is the board's own.
    pub fn scaling(&self) -> Option<Scaling> {
        let full = self.pin_v / PIN_V * CODES;
        let (zero, code_min, code_max) = match self.signal {
            Signal::Ratiometric => return None,
            // The next whole codes within both limits: codes are not negative.
            Signal::Current => {
                (ZERO_SHARE * full, (FAILED_LOW_SHARE * full) as u16 + 1, (FAILED_HIGH_SHARE * full) as u16)
            }
            // Without a live zero: a wire that is broken reads as nothing.
            Signal::Voltage => (0.0, 0, (CODES - RAIL_CODES) as u16),
        };
        let codes_per_unit = (full - zero) / (self.high - self.low);
        Some(Scaling { zero_code: zero - self.low * codes_per_unit, codes_per_unit, code_min, code_max })
    }
}

/// Those of all sensors.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Inputs {
    /// Pressure in the muscle, bar.
    pub pressure: Input,
    /// Contraction, mm.
    pub contraction: Input,
    /// Pressure before the valve, bar.
    pub supply: Input,
}

impl Inputs {
    /// Those of the standard sensors.
    pub const STANDARD: Self =
        Self { pressure: Input::RATIOMETRIC, contraction: Input::RATIOMETRIC, supply: Input::RATIOMETRIC };

    /// The CRC-32 (ISO-HDLC) over their registers, as bytes there.
    pub fn checksum(&self) -> u32 {
        checksum_of(&fields::INPUTS, |id| self.value(id))
    }

    /// Its value at a register of the inputs.
    pub fn value(&self, id: Id) -> Option<Value> {
        match id {
            Id::InputsChecksum => Some(Value::U32(self.checksum())),
            _ => fields::of_inputs(&mut self.clone(), id).map(|field| field.get()),
        }
    }
}

/// The CRC-32 (ISO-HDLC) over registers of at most two words, high byte first.
pub fn checksum_of(ids: &[Id], value: impl Fn(Id) -> Option<Value>) -> u32 {
    let mut bytes = heapless::Vec::<u8, { 4 * fields::INPUTS.len() }>::new();
    for value in ids.iter().filter_map(|id| value(*id)) {
        for word in value.words() {
            // There is room for two words each.
            let _ = bytes.extend_from_slice(&word.to_be_bytes());
        }
    }
    checksum(&bytes)
}

/// There is room for the registers of a calibration, too.
const _: () = assert!(fields::CALIBRATION.len() <= fields::INPUTS.len());

#[cfg(test)]
mod tests {
    use super::*;

    /// 150 ohm.
    const CURRENT: Input = Input { signal: Signal::Current, pin_v: 3.0, low: 0.0, high: 10.0 };

    fn code_of_ma(current_ma: f32) -> f32 {
        current_ma / 20.0 * 3.0 / 3.3 * 4095.0
    }

    #[test]
    fn a_current_below_3_6_ma_or_above_21_is_a_failed_sensors() {
        let scaling = CURRENT.scaling().expect("a scaling of its own");
        for (current_ma, is_good) in [(3.59, false), (3.61, true), (4.0, true), (20.99, true), (21.01, false)]
        {
            assert_eq!(
                scaling.is_plausible(code_of_ma(current_ma).round() as u16),
                is_good,
                "{current_ma} mA"
            );
        }
        assert!(!scaling.is_plausible(0) && !scaling.is_plausible(4095));
    }

    #[test]
    fn both_ends_of_a_range_are_what_they_are_said_to_be() {
        let scaling = Input { low: -1.0, ..CURRENT }.scaling().expect("a scaling of its own");
        assert!((scaling.zero_code - scaling.codes_per_unit - code_of_ma(4.0)).abs() < 0.01);
        assert!((scaling.zero_code + 10.0 * scaling.codes_per_unit - code_of_ma(20.0)).abs() < 0.01);
        let voltage = Input { signal: Signal::Voltage, pin_v: 3.0, low: 0.0, high: 150.0 };
        let scaling = voltage.scaling().expect("a scaling of its own");
        assert!(
            scaling.zero_code == 0.0 && (150.0 * scaling.codes_per_unit - 3.0 / 3.3 * 4095.0).abs() < 0.01
        );
    }

    #[test]
    fn the_highest_voltage_at_the_pin_leaves_21_ma_below_the_rail() {
        let [_, highest] = CURRENT.pin_limits_v();
        let scaling = Input { pin_v: highest, ..CURRENT }.scaling().expect("a scaling of its own");
        assert!(scaling.code_max <= 4055 && scaling.code_max >= 4054, "{scaling:?}");
        assert!((3.1..3.12).contains(&highest), "{highest}");
    }

    #[test]
    fn every_number_of_the_inputs_is_part_of_their_checksum() {
        let of = Inputs { pressure: CURRENT, contraction: CURRENT, supply: CURRENT };
        for id in fields::INPUTS {
            let mut other = of;
            let field = fields::of_inputs(&mut other, id).expect("one of them");
            let value = field.get();
            field.set(Value::of_number(value.kind(), value.number() + 1.0));
            assert_ne!(other.checksum(), of.checksum(), "{id:?}");
        }
    }
}
