//! What a hidden effect changes in a recording, and whether the recording can show it.
//!
//! The plant is run free, without noise, with the effect and without it. The difference that is
//! left after the best refit of a rate-independent hysteresis is what a diagnosis has to go by;
//! where it does not exceed what the sensors are off by, the recording cannot show the effect.

use serde::Serialize;

use super::refit::Hysteresis;
use crate::effect::Effect;

/// A noise-free signal with what it follows.
pub(crate) struct Seen {
    /// What the model is made from.
    pub(crate) input: Vec<f64>,
    /// What the model is of.
    pub(crate) output: Vec<f64>,
    /// Standard deviation of what the sensor of the output is off by.
    pub(crate) noise: f64,
}

/// How much of an effect there is to see. Amounts in the output's unit: mm, or bar for the valve's
/// pressure.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Visible {
    /// The effect.
    pub effect: &'static str,
    /// Unit of the amounts.
    pub unit: &'static str,
    /// Root mean square of the change.
    pub change: f64,
    /// That in percent of the stroke, or of the range of pressure.
    pub percent_of_stroke: f64,
    /// That over the sensor's noise.
    pub over_noise: f64,
    /// What is left of the change after the refit.
    pub after_refit: f64,
    /// Whether that exceeds the noise.
    pub examinable: bool,
}

impl Visible {
    /// Of `effect`, from what is seen with it and without it.
    pub(crate) fn of(effect: Effect, unit: &'static str, with: &Seen, without: &Seen) -> Self {
        let change: Vec<_> = with.output.iter().zip(&without.output).map(|(a, b)| a - b).collect();
        let rms = (change.iter().map(|d| d * d).sum::<f64>() / change.len() as f64).sqrt();
        let (low, high) = without
            .output
            .iter()
            .fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), v| (low.min(*v), high.max(*v)));
        let after_refit = Hysteresis::of(&with.input).rest(&change);
        Self {
            effect: effect.name(),
            unit,
            change: rms,
            percent_of_stroke: 100.0 * rms / (high - low).max(1e-9),
            over_noise: rms / with.noise,
            after_refit,
            examinable: after_refit > with.noise,
        }
    }
}
