//! What a friction is.

use crate::dynamics::Limits;

/// Resistance of a muscle to contraction, with its memory.
pub trait Resist: Send {
    /// Force at which it slides slowly, at a pressure (bar), as a share of its nominal one.
    fn level(&self, pressure_bar: f64) -> f64;

    /// Resistance if the muscle went to a contraction ratio, N; rises with it.
    fn resistance_n(&self, ratio: f64, limits_n: &Limits) -> f64;

    /// Goes there.
    fn settle(&mut self, ratio: f64, limits_n: &Limits);

    /// The pressure that reaches the force law, thresholds `widened` by a factor. Bar.
    fn felt_bar(&mut self, pressure_bar: f64, _widened: f64) -> f64 {
        pressure_bar
    }
}
