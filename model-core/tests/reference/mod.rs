//! The bank of plays as the paper writes it, play by play: what the library's bank is held against.

use model_core::Real;
use model_core::play::PlayParameters;

/// Equations (6) and (7) and the outputs of the plays.
pub struct PlainBank<T, const N: usize> {
    parameters: PlayParameters<T, N>,
    /// By rising threshold.
    pub outputs: Vec<T>,
}

impl<T: Real, const N: usize> PlainBank<T, N> {
    /// At rest at 0.
    pub fn new(parameters: &PlayParameters<T, N>) -> Self {
        Self { parameters: parameters.clone(), outputs: vec![T::ZERO; parameters.thresholds.len()] }
    }

    /// One sample.
    pub fn step(&mut self, v: T) -> T {
        let PlayParameters { q, thresholds, weights } = &self.parameters;
        let mut u = *q * v;
        for ((&threshold, &weight), z) in thresholds.iter().zip(weights).zip(&mut self.outputs) {
            *z = z.limit(v - threshold, v + threshold);
            u += weight * *z;
        }
        u
    }
}
