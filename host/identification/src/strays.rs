//! When least squares are pulled by a few samples, and Huber's loss would be right.

use std::fmt;

use super::robust::{beyond, deviation};
use recording::Recording;

/// Outliers that make up so much of the sum of squares pull a least-squares fit away from the other
/// samples.
const PULLING: f64 = 0.25;
/// Outliers are few: more are a model that does not describe the recording.
const FEW: f64 = 0.05;

/// Samples that pull a least-squares fit more than they should.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Strays {
    /// How many.
    pub samples: usize,
    /// The time of the first. Unit: s.
    pub first_s: f64,
    /// Their share of the sum of squares.
    pub share: f64,
}

impl Strays {
    /// Those of a model that answers with `simulated` (a value a sample, output unit), where they
    /// are few and make up much of its error.
    pub fn of(recording: &Recording, simulated: &[f64]) -> Option<Self> {
        let Recording { drive, output, .. } = recording;
        let rows: Vec<usize> = (0..drive.scored.len()).filter(|&row| drive.scored[row]).collect();
        let residuals: Vec<f64> = rows.iter().map(|&row| output.values[row] - simulated[row]).collect();
        let far: Vec<usize> = beyond(&residuals, deviation(&residuals)).collect();
        let squares = |residual: &f64| residual * residual;
        let all: f64 = residuals.iter().map(squares).sum();
        let share = far.iter().map(|&place| squares(&residuals[place])).sum::<f64>() / all;
        let first_s = drive.time_s[rows[*far.first()?]];
        (share > PULLING && far.len() as f64 <= FEW * rows.len() as f64).then_some(Self {
            samples: far.len(),
            first_s,
            share,
        })
    }
}

impl fmt::Display for Strays {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { samples, first_s, share } = self;
        write!(
            f,
            "{samples} samples beyond five robust standard deviations, the first at {first_s:.4} s, make up {:.0} % of the \
             squared error: --loss huber keeps them from pulling the model",
            100.0 * share
        )
    }
}
