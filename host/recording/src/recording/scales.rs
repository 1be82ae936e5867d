//! Whether command and pressure of one file are on one scale.
//!
//! A regulator's pressure settles at its command. Where one is a fixed multiple of the other, and
//! that multiple is the ratio of two units of pressure, one of the two columns has the wrong unit
//! in its name: it is asked about.

use super::INPUTS;
use crate::numbers::quantiles;
use crate::table::naming::Found;
use crate::table::{DataError, DataProblem, Table};
use crate::unit::{Quantity, Unit};

/// Units that regulators, sensors and loggers give pressures in.
const UNITS: [&str; 6] = ["bar", "kpa", "psi", "mpa", "mbar", "pa"];
/// How far a ratio may be off that of two units, as a logarithm. Regulators' gains are off by 1 %
/// of their span, and a lag or a dead band takes a few hundredths of a swing; the nearest ratios of
/// two units, 0.1 of bar to MPa and 0.069 of bar to psi, are 45 % apart.
const NEAR: f64 = 0.15;
/// Of a column's values this share is left out at either end.
const ENDS: f64 = 0.05;
/// So many rows tell a range.
const ENOUGH: usize = 10_000;

/// The range of a column, without its ends. Unit: bar.
struct Span {
    found: Found,
    low: f64,
    high: f64,
}

impl Span {
    fn of(table: &Table, name: &str) -> Option<Self> {
        // A column that is wrong otherwise is told of by who uses it.
        let found =
            table.find(name).ok().flatten().filter(|found| found.unit.quantity() == Quantity::Pressure)?;
        let values = table.numbers(found.index).ok()?.numbers;
        let each = values.len() / ENOUGH + 1;
        let finite = values.iter().step_by(each).filter(|value| value.is_finite());
        let in_bar: Vec<f64> = finite.filter_map(|value| found.unit.convert(*value, Unit::BAR)).collect();
        let (low, high) = quantiles(&in_bar, ENDS);
        (high > low).then_some(Self { found, low, high })
    }

    /// The unit that brings it onto the scale of `other`, if there is one.
    fn in_truth(&self, other: &Self) -> Option<Unit> {
        let is_near = |ratio: f64| (ratio.ln()).abs() < NEAR;
        let fits = |unit: &Unit| {
            let factor = unit.convert(1.0, Unit::BAR).zip(self.found.unit.convert(1.0, Unit::BAR));
            factor.is_some_and(|(truth, said)| {
                let factor = truth / said;
                is_near(factor * (self.high - self.low) / (other.high - other.low))
                    && is_near(factor * self.high / other.high)
            })
        };
        // The unit of the other column is the likelier one.
        let units = UNITS.into_iter().filter_map(Unit::of_symbol);
        let units = [other.found.unit].into_iter().chain(units);
        units.into_iter().filter(|unit| *unit != self.found.unit).find(fits)
    }
}

/// Asks where the pressure beside a command is in another unit than its column says, or the command
/// is.
///
/// # Errors
/// One of the two is a multiple of the other that is the ratio of two units, and no option says the
/// unit.
pub fn check(table: &Table) -> Result<(), DataError> {
    let [pressure, command] = INPUTS.map(|name| Span::of(table, name));
    let Some((pressure, command)) = pressure.zip(command) else { return Ok(()) };
    let is_said = |span: &Span| table.is_unit_said(span.found.index);
    for (one, other) in [(&pressure, &command), (&command, &pressure)] {
        let Some(unit) = one.in_truth(other).filter(|_| !is_said(one) && !is_said(other)) else { continue };
        let highest = |span: &Span| {
            let unit = span.found.unit;
            format!("up to {:.3} {unit}", Unit::BAR.convert(span.high, unit).unwrap_or(span.high))
        };
        let problem = DataProblem::OtherScale {
            values: format!(
                "{} beside {} of {}",
                highest(one),
                highest(other),
                table.shown(other.found.index)
            ),
            column: table.as_option(one.found.index),
            said: one.found.unit.suffix(),
            likelier: unit.suffix(),
        };
        return Err(table.heading_place(one.found.index).error(problem));
    }
    Ok(())
}
