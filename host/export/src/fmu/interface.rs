//! The variables of a unit.
//!
//! | reference | forward | inverse |
//! |---|---|---|
//! | 0 | time | time |
//! | 1 | the model's input | the output that is wanted |
//! | 2 | the model's output | the input that brings it about |
//! | 3 | pressure behind the valve, if the model has one | |
//! | 4, 5 | load, temperature, if the model needs them | the same |

use model_core::Hysteresis;
use recording::unit::Unit as Measure;

use super::{Direction, Unit};

/// The independent variable.
pub const TIME: u32 = 0;
/// What the unit is driven by.
pub const DRIVE: u32 = 1;
/// What it answers.
pub const ANSWER: u32 = 2;
/// The pressure behind the valve.
pub const PRESSURE: u32 = 3;
/// The load. Unit: N.
pub const LOAD: u32 = 4;
/// The temperature. Unit: °C.
pub const TEMPERATURE: u32 = 5;

/// A variable.
#[derive(Clone, Debug, PartialEq)]
pub struct Variable {
    /// FMI's value reference.
    pub reference: u32,
    /// Its name, with its unit.
    pub name: String,
    /// Its unit.
    pub unit: Measure,
    /// The value of an input that nobody sets; None of an output.
    pub start: Option<f64>,
    /// What it is.
    pub about: String,
}

impl Unit {
    /// The variables, but for the time.
    pub fn variables(&self) -> Vec<Variable> {
        let (input, output) = (&self.model.input, &self.model.output);
        let (low, high) = self.model.parameters.input();
        let extensions = self.model.acting();
        let mut all = Vec::new();
        let mut push = |reference, name: &str, unit, start, about: String| {
            all.push(Variable { reference, name: name.to_owned(), unit, start, about });
        };
        let valid = format!("{}; the model is valid from {low} to {high}", input.words());
        match self.direction {
            Direction::Forward => {
                push(DRIVE, &input.name, input.unit, Some(low), valid);
                push(ANSWER, &output.name, output.unit, None, output.words());
                if extensions.without_valve() != extensions {
                    let name = format!("valve_pressure_{}", input.unit.suffix());
                    push(PRESSURE, &name, input.unit, None, "pressure behind the valve".to_owned());
                }
            }
            Direction::Inverse { .. } => {
                let (wanted, rest) = (format!("wanted_{}", output.name), self.model.model.output_range().0);
                push(DRIVE, &wanted, output.unit, Some(rest), format!("{} that is wanted", output.words()));
                push(ANSWER, &input.name, input.unit, None, valid);
            }
        }
        for (reference, name, unit, schedule) in [
            (LOAD, "load_n", Measure::N, extensions.load),
            (TEMPERATURE, "temperature_c", Measure::CELSIUS, extensions.temperature),
        ] {
            if let Some(schedule) = schedule {
                let about = "measured; at its start value the model needs no correction".to_owned();
                push(reference, name, unit, Some(schedule.reference), about);
            }
        }
        all
    }
}
