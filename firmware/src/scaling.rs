//! Codes of the converters and what they mean.
//!
//! | signal | sensor or actuator | 12-bit code |
//! |---|---|---|
//! | pressure | transducer 0 to 10 bar, ratiometric 10 to 90 % | 409.5 at 0 bar, 327.6 per bar |
//! | contraction | potentiometer of 150 mm, 5 to 95 % of its travel used | 204.75 at 0 mm, 24.57 per mm |
//! | supply | the same transducer as for the pressure, before the valve | 409.5 at 0 bar, 327.6 per bar |
//! | temperature | in the processor: 0.76 V at 25 °C, 2.5 mV/K (data sheet DS8626, table 70), of 3.3 V | 865.5 at 0 °C, 3.1023 per K |
//! | command | proportional regulator, 0 to 10 V for 0 to 10 bar | 0 at 0 bar, 409.5 per bar |
//!
//! These are the standard sensors. One of 4 to 20 mA or 0 to 10 V has the scaling of its range
//! instead ([`Input`]).
//!
//! A broken wire or a short pulls an input to a rail, outside the plausible codes, but for a sensor
//! of 0 to 10 V, which has no live zero. A board tells
//! the scalings of pressure, contraction and command in its greeting, so that a host needs no copy
//! of them.

use wire::{Calibration, Input, Inputs, Line, Refusal, Scaling, Signal};

use crate::board::DacCode;

/// Pressure in bar. Plausible: -0.64 to 10.65 bar.
pub const PRESSURE: Scaling =
    Scaling { zero_code: 409.5, codes_per_unit: 327.6, code_min: 200, code_max: 3900 };

/// Contraction in mm. Plausible: -6.7 to 156.7 mm.
pub const CONTRACTION: Scaling =
    Scaling { zero_code: 204.75, codes_per_unit: 24.57, code_min: 40, code_max: 4055 };

/// Pressure before the valve, in bar.
pub const SUPPLY: Scaling = PRESSURE;

/// Those that a calibration may set.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Scalings {
    /// Of the pressure in the muscle, in bar.
    pub pressure: Scaling,
    /// In mm.
    pub contraction: Scaling,
    /// Of the pressure before the valve, in bar.
    pub supply: Scaling,
    /// In bar.
    pub command: Scaling,
    /// As in [`Calibration::day`].
    pub day: u32,
    /// How the sensors are connected.
    pub inputs: Inputs,
}

/// How far a calibrated gain may be from that of the standard sensor. Unit: share.
const CREDIBLE_GAIN: core::ops::RangeInclusive<f32> = 0.8..=1.25;
/// How far a calibrated zero may be from that of the standard sensor. Unit: share of its span.
const CREDIBLE_ZERO: f32 = 0.1;
/// Where the pressure sensor's range may end at the lowest: one of 0 to 10 V shows nothing beyond
/// its range, and would hide a burst. The highest hard limit that the registers take. Unit: bar.
const LEAST_RANGE_BAR: f32 = 8.5;

impl Scalings {
    /// Of the standard sensors and regulator.
    pub const STANDARD: Self = Self {
        pressure: PRESSURE,
        contraction: CONTRACTION,
        supply: SUPPLY,
        command: COMMAND,
        day: 0,
        inputs: Inputs::STANDARD,
    };

    /// Those of sensors that are connected so, by their ranges alone; the regulator is the standard
    /// one.
    ///
    /// # Errors
    /// A range that cannot be, by name, value and limits.
    pub fn of(inputs: &Inputs) -> Result<Self, Refusal> {
        Ok(Self {
            pressure: ranged("pressure", &PRESSURE, &inputs.pressure, LEAST_RANGE_BAR)?,
            contraction: ranged("contraction", &CONTRACTION, &inputs.contraction, 0.0)?,
            supply: ranged("supply", &SUPPLY, &inputs.supply, 0.0)?,
            inputs: *inputs,
            ..Self::STANDARD
        })
    }

    /// Those of a calibration. What counts as a broken wire stays.
    ///
    /// # Errors
    /// A range that cannot be, or a line that no working sensor of its kind has, by name, value and
    /// limits.
    pub fn calibrated(calibration: &Calibration) -> Result<Self, Refusal> {
        let Calibration { pressure, contraction, supply, command, day, inputs } = *calibration;
        let of = Self::of(&inputs)?;
        Ok(Self {
            pressure: calibrated("pressure", &of.pressure, pressure, span(&inputs.pressure, 10.0))?,
            contraction: calibrated(
                "contraction",
                &of.contraction,
                contraction,
                span(&inputs.contraction, 150.0),
            )?,
            supply: calibrated("supply", &of.supply, supply, span(&inputs.supply, 10.0))?,
            command: calibrated("command", &of.command, command, 10.0)?,
            day,
            ..of
        })
    }

    /// These with sensors that are connected so: those that change begin by the line of their
    /// range.
    ///
    /// # Errors
    /// A range that cannot be.
    pub fn connected(&self, inputs: &Inputs) -> Result<Self, Refusal> {
        let of = Self::of(inputs)?;
        let kept = |is_same: bool, before: Scaling, after: Scaling| if is_same { before } else { after };
        let before = &self.inputs;
        Ok(Self {
            pressure: kept(before.pressure == inputs.pressure, self.pressure, of.pressure),
            contraction: kept(before.contraction == inputs.contraction, self.contraction, of.contraction),
            supply: kept(before.supply == inputs.supply, self.supply, of.supply),
            inputs: *inputs,
            ..*self
        })
    }

    /// What a host is told of them.
    pub const fn calibration(&self) -> Calibration {
        const fn line(Scaling { zero_code, codes_per_unit, .. }: Scaling) -> Line {
            Line { zero_code, codes_per_unit }
        }
        Calibration {
            pressure: line(self.pressure),
            contraction: line(self.contraction),
            supply: line(self.supply),
            command: line(self.command),
            day: self.day,
            inputs: self.inputs,
        }
    }

    /// The code of a command in bar. None at all is the vented code, wherever the calibrated zero
    /// is.
    #[inline(always)]
    pub fn command_code(&self, bar: f32) -> DacCode {
        if bar > 0.0 { DacCode(self.command.code(bar)) } else { VENT }
    }
}

/// The range of a sensor; of a ratiometric one that of the standard sensor. Unit: that of the
/// sensor.
fn span(input: &Input, standard: f32) -> f32 {
    if input.signal == Signal::Ratiometric { standard } else { input.high - input.low }
}

/// The scaling by a sensor's range. `least_high`: where that may end at the lowest.
fn ranged(name: &str, standard: &Scaling, input: &Input, least_high: f32) -> Result<Scaling, Refusal> {
    let Some(scaling) = input.scaling() else { return Ok(*standard) };
    let Input { pin_v, low, high, .. } = *input;
    let [least, most] = input.pin_limits_v();
    if !(least..=most).contains(&pin_v) {
        return Err(Refusal::parameter(format_args!(
            "{name}: its pin has {pin_v} V at the end of its range, must be {least} to {most} V"
        )));
    }
    let rises = high > low && scaling.codes_per_unit.is_finite();
    if !rises {
        return Err(Refusal::parameter(format_args!("{name}: its range is {low} to {high}, must rise")));
    }
    if high < least_high {
        return Err(Refusal::parameter(format_args!(
            "{name}: its range ends at {high}, must be at least {least_high}"
        )));
    }
    Ok(scaling)
}

/// A scaling with a calibrated line. `span`: of the sensor, in its unit.
pub(crate) fn calibrated(name: &str, standard: &Scaling, line: Line, span: f32) -> Result<Scaling, Refusal> {
    let Line { zero_code, codes_per_unit } = line;
    let share = codes_per_unit / standard.codes_per_unit;
    if !CREDIBLE_GAIN.contains(&share) {
        let (least, most) = (CREDIBLE_GAIN.start(), CREDIBLE_GAIN.end());
        return Err(Refusal::parameter(format_args!(
            "{name}: {share} times the standard sensor's gain, must be {least} to {most}"
        )));
    }
    let off = (zero_code - standard.zero_code).abs() / (span * standard.codes_per_unit);
    if off.is_nan() || off > CREDIBLE_ZERO {
        return Err(Refusal::parameter(format_args!(
            "{name}: its zero is off by {off} of the span, must be at most {CREDIBLE_ZERO}"
        )));
    }
    Ok(Scaling { zero_code, codes_per_unit, ..*standard })
}

/// Temperature of the processor in °C. Plausible: -40 to 125 °C. Of a typical sensor: the board
/// turns codes of its own into them by its factory values.
pub const TEMPERATURE: Scaling =
    Scaling { zero_code: 865.5, codes_per_unit: 3.1023, code_min: 741, code_max: 1253 };

/// Command in bar: 0 to 10 bar.
pub const COMMAND: Scaling = Scaling { zero_code: 0.0, codes_per_unit: 409.5, code_min: 0, code_max: 4095 };

/// The code of a value, whatever the converter's range is: that of a limit which is off is beyond
/// any.
pub(crate) fn level(scaling: &Scaling, value: f32) -> u16 {
    (scaling.zero_code + value * scaling.codes_per_unit) as u16
}

/// Code of the processor's reference voltage, 1.21 V of 3.3 V (data sheet DS8626, table 72), on a
/// typical chip: the board turns codes of its own into that by its factory value.
pub const REFERENCE_CODE: f32 = 1501.5;
/// The supply of the converters at which the reference has [`REFERENCE_CODE`]. Unit: V.
pub const REFERENCE_SUPPLY_V: f32 = 3.3;

/// The safe output: the regulator vents the muscle.
pub const VENT: DacCode = DacCode(0);
