//! Diagnosis.

pub mod anatomy;
pub mod basis;
pub mod cause;
pub mod effect;
pub mod equivalent;
pub mod fit;
pub mod free_run;
pub mod gain;
pub mod output;
pub mod pure_error;
pub mod reject;
pub mod screen;
pub mod search;
pub mod signals;
pub mod spectrum;
pub mod valve;

/// The columns of a recording.
#[derive(Clone, Debug, Default)]
pub struct Columns {
    /// Unit: s.
    pub time_s: Vec<f64>,
    /// What the muscle is modelled from.
    pub input: Vec<f64>,
    /// The command, where the input is the measured pressure.
    pub command: Option<Vec<f64>>,
    /// Measured contraction.
    pub output: Vec<f64>,
    /// Which rows are scored.
    pub scored: Vec<bool>,
    /// Unit: N.
    pub load_n: Option<Vec<f64>>,
    /// Unit: degree Celsius.
    pub temperature_c: Option<Vec<f64>>,
}
