//! One search: from a start to its end, by Levenberg-Marquardt.

use levenberg_marquardt::{LevenbergMarquardt, TerminationReason};

use super::CONVERGED;
use super::data::Data;
use super::problem::Problem;
use super::starts::Start;
use crate::progress::Part;

/// The share by which the sum of squares of a fresh muscle has to be smaller to be believed.
const CLEARLY: f64 = 0.02;
/// Evaluations per coordinate that a search gets at most.
const MOST: usize = 60;

/// Where a search ended, and with what.
pub type End = (Start, Reached);

/// What a search has reached.
pub struct Reached {
    /// Sum of squares.
    pub cost: f64,
    /// Why it ended.
    pub reason: TerminationReason,
}

/// What ends a search that gets no further by itself.
#[derive(Clone, Copy, Debug)]
pub struct Limits {
    /// Evaluations per coordinate.
    pub patience: usize,
    /// A step that gains less than this share of the sum of squares is the last.
    pub tolerance: f64,
}

impl Limits {
    /// Of a search that is to come to its end.
    pub fn to_the_end(tolerance: f64) -> Self {
        Self { patience: MOST, tolerance }
    }
}

/// Searches from a start.
pub fn search<const K: usize>(data: &Data, start: &Start, limits: Limits, part: &Part<'_>) -> End {
    let kernel = LevenbergMarquardt::new()
        .with_ftol(limits.tolerance)
        .with_xtol(CONVERGED)
        .with_gtol(CONVERGED)
        .with_patience(limits.patience);
    let (problem, report) = kernel.minimize(Problem::<K>::new(data, start, part));
    let point = problem.into_point();
    (point.at, Reached { cost: point.cost, reason: report.termination })
}

/// Whether a fresh muscle fits so much better than a preconditioned one that it is believed.
pub fn is_clearly_better((_, fresh): &End, (_, preconditioned): &End) -> bool {
    fresh.cost < preconditioned.cost * (1.0 - CLEARLY)
}
