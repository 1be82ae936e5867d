//! The command of a recording, where the pressure is unknown.

use super::Columns;
use recording::numbers::range;
use recording::unit::Unit;

/// The standard atmosphere (ISO 2533); the weather moves it by a twentieth, a kilometre of height by a tenth. Unit: bar.
const OUTSIDE_BAR: f64 = 1.01325;

/// What is known of a command.
#[derive(Clone, Copy, Debug)]
pub struct Command {
    /// The highest. Input unit.
    pub highest: f64,
    /// The atmosphere's pressure; None where the command is no pressure. Input unit.
    pub outside: Option<f64>,
}

impl Command {
    /// That of a recording; None where its input is the pressure.
    pub fn of(columns: &Columns) -> Option<Self> {
        let highest = range(&columns.input).1;
        columns.input_is_command.then(|| Self { highest, outside: outside(columns.input_unit) })
    }
}

/// The atmosphere's pressure; None where that is no unit of pressure.
pub fn outside(unit: Unit) -> Option<f64> {
    Unit::BAR.convert(OUTSIDE_BAR, unit)
}
