//! The scored rows of a recording.

use super::Columns;
use super::anatomy::Residual;

/// The columns, a value a scored row.
pub struct Scored {
    time_s: Vec<f64>,
    input: Vec<f64>,
    pub output: Vec<f64>,
    pub command: Option<Vec<f64>>,
    load: Option<Vec<f64>>,
    temperature: Option<Vec<f64>>,
}

impl Scored {
    /// Those of a recording.
    pub fn of(columns: &Columns) -> Self {
        let pick = |values: &[f64]| columns.of_scored(values);
        Self {
            time_s: pick(&columns.time_s),
            input: pick(&columns.input),
            output: pick(&columns.output),
            command: columns.command.as_deref().map(pick),
            load: columns.load_n.as_deref().map(pick),
            temperature: columns.temperature_c.as_deref().map(pick),
        }
    }

    /// They, with a residual.
    pub fn residual<'a>(&'a self, residual: &'a [f64]) -> Residual<'a> {
        Residual {
            time_s: &self.time_s,
            residual,
            input: &self.input,
            output: &self.output,
            load: self.load.as_deref(),
            temperature: self.temperature.as_deref(),
        }
    }
}
