//! Keys and units of the raw parameters, with the units that they take over from the model's input
//! and output.

use crate::Recording;
use crate::model::named::Dimension;
use crate::unit::Unit;

/// Units of a model's parameters.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Names {
    /// Unit of the input.
    pub input: Unit,
    /// Unit of the output.
    pub output: Unit,
}

impl Names {
    /// Those of a board's model.
    pub const BOARD: Self = Self { input: Unit::BAR, output: Unit::MM };

    /// Those of a recording's columns.
    pub fn of(recording: &Recording) -> Self {
        Self { input: recording.drive.input.channel.unit, output: recording.output.channel.unit }
    }

    /// The key with the unit: `c1_per_bar`, `w0_mm`, `gain_mm_per_bar`, `q`.
    pub fn key(&self, name: &str, dimension: Dimension) -> String {
        let (input, output) = (self.input.suffix(), self.output.suffix());
        match dimension {
            Dimension::One => name.to_owned(),
            Dimension::Input => format!("{name}_{input}"),
            Dimension::PerInput => format!("{name}_per_{input}"),
            Dimension::Output => format!("{name}_{output}"),
            Dimension::OutputPerInput => format!("{name}_{output}_per_{input}"),
        }
    }

    /// The unit as people write it: `1/bar`, `mm`, `1`.
    pub fn unit(&self, dimension: Dimension) -> String {
        match dimension {
            Dimension::One => "1".to_owned(),
            Dimension::Input => self.input.to_string(),
            Dimension::PerInput => format!("1/{}", self.input),
            Dimension::Output => self.output.to_string(),
            Dimension::OutputPerInput => format!("{}/{}", self.output, self.input),
        }
    }
}
