//! A loop over the whole input range: its slope and its width, by which an equivalent input becomes a change of contraction.

use super::basis::{Basis, Weights};
use super::equivalent::bend;
use super::fit::Fit;
use super::signals::Signals;
use identification::{HostModel, HostParameters, simulate};
use recording::numbers::range;

/// Points of the loop that slopes are taken from, each way.
const POINTS: usize = 400;

/// A loop over the whole input range: input and output, up and down.
pub struct Loop {
    input: Vec<f64>,
    output: Vec<f64>,
}

impl Loop {
    pub(super) fn of(signals: &Signals, basis: &Basis, fit: &Fit) -> Self {
        Self::new(range(&signals.input), |input| {
            basis.simulate(input, bend(&fit.effects), &Weights::new(&fit.weights))
        })
    }

    /// The loop of an operator over its input range; None if its parameters are not valid.
    pub fn of_operator(parameters: &HostParameters) -> Option<Self> {
        let operator = HostModel::try_new(parameters).ok()?;
        Some(Self::new(parameters.input(), |input| simulate(&operator, input)))
    }

    /// Of a rate-independent model between two inputs; `simulate` answers with an output for each input.
    pub fn new((low, high): (f64, f64), simulate: impl Fn(&[f64]) -> Vec<f64>) -> Self {
        let step = (high - low) / POINTS as f64;
        let up = (0..=POINTS).map(|i| low + step * i as f64);
        let down = (0..POINTS).rev().map(|i| low + step * i as f64);
        // Twice, so that the first rise is not that of a fresh muscle.
        let input: Vec<f64> = up.clone().chain(down.clone()).chain(up).chain(down).collect();
        let output = simulate(&input);
        let half = input.len() / 2;
        Self { input: input[half..].to_vec(), output: output[half..].to_vec() }
    }

    /// The mean slope of both branches around an output. Unit: output unit/input unit.
    pub fn slope(&self, at: f64) -> f64 {
        let (low, high) = range(&self.output);
        let near = 0.08 * (high - low);
        let slopes: Vec<f64> = self
            .input
            .windows(2)
            .zip(self.output.windows(2))
            .filter(|(_, y)| (0.5 * (y[0] + y[1]) - at).abs() < near)
            .map(|(u, y)| (y[1] - y[0]) / (u[1] - u[0]))
            .collect();
        slopes.iter().sum::<f64>() / slopes.len().max(1) as f64
    }

    /// The middle of its outputs. Output unit.
    pub(super) fn middle(&self) -> f64 {
        let (low, high) = range(&self.output);
        0.5 * (low + high)
    }

    /// Half the width of the loop at an output. Input unit.
    pub(super) fn half_width(&self, at: f64) -> f64 {
        let crossings: Vec<f64> = self
            .output
            .windows(2)
            .zip(&self.input)
            .filter(|(y, _)| (y[0] - at) * (y[1] - at) <= 0.0)
            .map(|(_, &u)| u)
            .collect();
        let highest = crossings.iter().copied().fold(f64::NEG_INFINITY, f64::max);
        let lowest = crossings.iter().copied().fold(f64::INFINITY, f64::min);
        if crossings.len() < 2 { 0.0 } else { 0.5 * (highest - lowest) }
    }
}
