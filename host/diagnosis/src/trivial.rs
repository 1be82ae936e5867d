//! Models that need no operator, fitted to the first samples and tried on the others: one that is no better than these describes
//! nothing.

use nalgebra::{DMatrix, DVector};

use super::Columns;
use super::signals::hats;
use recording::numbers::range;

/// Knots of the static curve, evenly spaced over the input's range.
const KNOTS: usize = 11;
/// Singular values below this share of the largest are none: inputs that follow each other are nearly the same.
const LEAST: f64 = 1e-9;

/// A model that needs no operator.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Trivial {
    /// A curve over the input, straight between knots, without memory.
    StaticCurve,
    /// A linear function of the input and its last two samples.
    PastSamples,
}

impl Trivial {
    /// All of them.
    pub const ALL: [Self; 2] = [Self::StaticCurve, Self::PastSamples];

    /// Measured less simulated at the samples that it is tried on, by the one that fits the taught ones best. Output unit.
    pub fn errors(self, columns: &Columns, taught: &[usize], tried: &[usize]) -> Vec<f64> {
        let Columns { input, output, .. } = columns;
        let (low, high) = range(input);
        let knots: [f64; KNOTS] =
            std::array::from_fn(|knot| low + (high - low) * knot as f64 / (KNOTS - 1) as f64);
        let terms = |row: usize| match self {
            Self::StaticCurve => hats(&knots, input[row]).to_vec(),
            Self::PastSamples => {
                let past = |samples: usize| input[row.saturating_sub(samples)];
                // The same as a function of the three, and better conditioned.
                vec![1.0, past(0), past(0) - past(1), past(0) - 2.0 * past(1) + past(2)]
            }
        };
        let all: Vec<Vec<f64>> = taught.iter().map(|&row| terms(row)).collect();
        let count = all.first().map_or(0, Vec::len);
        let design = DMatrix::from_fn(all.len(), count, |row, term| all[row][term]);
        let sizes = DVector::from_fn(count, |term, _| design.column(term).norm().max(f64::MIN_POSITIVE));
        let scaled = DMatrix::from_fn(all.len(), count, |row, term| design[(row, term)] / sizes[term]);
        let measured = DVector::from_iterator(taught.len(), taught.iter().map(|&row| output[row]));
        let weights = scaled.svd(true, true).solve(&measured, LEAST).unwrap_or(DVector::zeros(count));
        let said = |row: usize| -> f64 {
            terms(row)
                .iter()
                .zip(weights.iter().zip(&sizes))
                .map(|(term, (weight, size))| term * weight / size)
                .sum()
        };
        tried.iter().map(|&row| output[row] - said(row)).collect()
    }

    /// The word in files.
    pub fn name(self) -> &'static str {
        match self {
            Self::StaticCurve => "static_curve",
            Self::PastSamples => "two_past_samples",
        }
    }

    /// What it is, for people.
    pub fn words(self) -> &'static str {
        match self {
            Self::StaticCurve => "a static curve of the input",
            Self::PastSamples => "a linear function of the input and its last two samples",
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use recording::numbers::root_mean_square;

    /// Errors on the last third of an output of the input's course.
    fn errors(trivial: Trivial, of: impl Fn(f64, f64) -> f64) -> f64 {
        let input: Vec<f64> = (0..900).map(|row| 3.0 - 3.0 * (0.05 * f64::from(row)).cos()).collect();
        let output = (0..900).map(|row: usize| of(input[row], input[row.saturating_sub(1)])).collect();
        let columns =
            Columns { time_s: (0..900).map(f64::from).collect(), input, output, ..Columns::default() };
        let rows: Vec<usize> = (0..900).collect();
        root_mean_square(&trivial.errors(&columns, &rows[..600], &rows[600..]))
    }

    #[test]
    fn a_curve_without_memory_is_followed_by_the_static_curve_alone() {
        let parabola = |u: f64, _| (u - 3.0).powi(2);
        assert!(errors(Trivial::StaticCurve, parabola) < 0.1);
        assert!(errors(Trivial::PastSamples, parabola) > 1.0);
    }

    #[test]
    fn a_lead_is_followed_by_the_past_samples_alone() {
        let lead = |u: f64, before: f64| u + 10.0 * (u - before);
        assert!(errors(Trivial::PastSamples, lead) < 1e-6);
        assert!(errors(Trivial::StaticCurve, lead) > 0.5);
    }
}
