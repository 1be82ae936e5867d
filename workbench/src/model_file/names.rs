//! The raw parameters' names, with the units that they take over from the model's input and output.
//!
//! c1 is per input unit; the dead zones' weights (w0, w1, …) and the offset are in the output unit; everything
//! else is a plain number.

use crate::unit::Unit;

/// Names of the parameters before the weights, in the order of Table 1.
const INNER: [&str; 8] = ["c0", "c1", "c2", "c3", "q", "rho", "tau", "alpha"];

/// Units of a model's parameters.
#[derive(Clone, Copy, Debug)]
pub struct Names {
    /// Unit of the input.
    pub input: Unit,
    /// Unit of the output.
    pub output: Unit,
}

impl Names {
    /// All parameters of a model, in the order of Tables 1 and 2, then the offset.
    pub fn all(dead_zones: usize) -> impl Iterator<Item = String> {
        let weights = (0..dead_zones).map(|j| format!("w{j}"));
        INNER.iter().map(|name| (*name).to_owned()).chain(weights).chain(["offset".to_owned()])
    }

    /// The key with the unit: `c1_per_bar`, `w0_mm`, `tau`.
    pub fn key(&self, name: &str) -> String {
        match name {
            "c1" => format!("{name}_per_{}", self.input.suffix()),
            _ if INNER.contains(&name) => name.to_owned(),
            _ => format!("{name}_{}", self.output.suffix()),
        }
    }

    /// The unit as people write it: `1/bar`, `mm`, `1`.
    pub fn unit(&self, name: &str) -> String {
        match name {
            "c1" => format!("1/{}", self.input),
            _ if INNER.contains(&name) => "1".to_owned(),
            _ => self.output.to_string(),
        }
    }
}
