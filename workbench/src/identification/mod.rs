//! Identification of the models of the family by Levenberg-Marquardt with variable projection.
//!
//! # Design
//! | file | what it does |
//! |---|---|
//! | `data` | the recording, checked and normalised |
//! | `structure` | the parts of a model of the family |
//! | `coordinates` | the nonlinear coordinates, bounded smoothly |
//! | `envelope`, `plays` | the parts in normalised form, without the model's two exact scalings |
//! | `inner` | u over the recording and its exact sensitivities |
//! | `projection`, `nnls` | offset, slopes of the dead zones and added functions, linear and kept positive |
//! | `problem` | the reduced problem and its Jacobian, for the Levenberg-Marquardt kernel (MINPACK's, crate `levenberg-marquardt`) |
//! | `starts` | where the searches begin |
//! | `raw`, [`named`] | the way to the raw parameters, and their names |
//! | `thinning` | a shorter recording that is enough to screen them |
//! | `uncertainty` | standard errors of the raw parameters |
//!
//! The problem has several minima, so that many starts are tried side by side: each gets a few steps on a thinned
//! recording, then the best quarter goes on to convergence on all of it. The answer depends on the seed, not on the number of threads.
//!
//! # Contract
//! Whatever the recording is, the result is a validated, invertible model or a typed error. Before the recording the
//! muscle is taken to have come from rest at the lowest input, either preconditioned by a full cycle or, if that fits
//! clearly better, fresh. Rows that do not count (`scored` false) still drive it.
//!
//! # Limits
//! At most [`PLAYS`] plays and [`DEAD_ZONES`] dead zones. The inputs of the recording are the model's
//! validity range.

mod coordinates;
mod data;
mod envelope;
mod error;
mod inner;
pub mod named;
mod nnls;
mod plays;
mod problem;
mod projection;
mod raw;
mod starts;
mod structure;
mod thinning;
mod uncertainty;

use levenberg_marquardt::{LevenbergMarquardt, TerminationReason};
use model_core::envelope::KNOTS;
use model_core::{Hysteresis, Invertible, Kind, Model, ModelParameters, ParameterError};
use rayon::prelude::*;

use data::{Data, normalise};
pub use error::IdentificationError;
use named::Named;
use problem::{Point, Problem as Reduced};
use starts::Start;
use structure::Structure;

/// The largest number of plays of a model on the host.
pub const PLAYS: usize = 128;
/// The largest number of dead zones of a model on the host.
pub const DEAD_ZONES: usize = 128;
/// Raw parameters of a model on the host.
pub type HostParameters = ModelParameters<f64, PLAYS, DEAD_ZONES>;
/// A model on the host.
pub type HostModel = Model<f64, PLAYS, DEAD_ZONES>;

/// The share by which the sum of squares of a fresh muscle has to be smaller to be believed.
const CLEARLY: f64 = 0.02;
/// Evaluations per coordinate that every start gets.
const SCREENING: usize = 4;
/// Evaluations per coordinate that the best starts get.
const CONVERGENCE: usize = 60;

/// A recording to identify from.
#[derive(Clone, Copy, Debug)]
pub struct Problem<'a> {
    /// Input of every row. Input unit.
    pub input: &'a [f64],
    /// Measured output of every row. Output unit.
    pub output: &'a [f64],
    /// Whether a row counts; the others are input history only.
    pub scored: &'a [bool],
}

/// How to identify.
#[derive(Clone, Copy, Debug)]
pub struct Options {
    /// Which model.
    pub model: Kind,
    /// A piecewise-linear envelope with so many knots, 3 to [`KNOTS`], for models with one envelope; without, tanh.
    pub knots: Option<usize>,
    /// Number of plays, 1 to [`PLAYS`].
    pub plays: usize,
    /// Number of dead zones, 1 to [`DEAD_ZONES`], for models that have them.
    pub dead_zones: usize,
    /// Number of starts, at least 1.
    pub starts: usize,
    /// Seed of the starts.
    pub seed: u64,
    /// Threads; 0 for one a core.
    pub threads: usize,
}

impl Options {
    /// How many independent numbers are found: the raw parameters less those that scalings of the model leave open.
    pub fn unknowns(&self) -> usize {
        Structure::new(self).unknowns()
    }
}

/// Exponential density of the plays and the spacing of their thresholds, equations (9) and (10).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Density {
    /// Weight of a play of threshold 0.
    pub rho: f64,
    /// Decay of the weights with the threshold.
    pub tau: f64,
    /// Distance of the thresholds.
    pub alpha: f64,
}

/// A raw parameter with its standard error.
#[derive(Clone, Debug, PartialEq)]
pub struct Estimate {
    /// Name, value and dimension.
    pub parameter: Named,
    /// Standard error in the same unit, for independent residuals; None where a bound binds.
    pub standard_error: Option<f64>,
}

/// How the search ended.
#[derive(Clone, Debug, PartialEq)]
pub struct Termination {
    /// In words.
    pub reason: String,
    /// Whether at a minimum.
    pub converged: bool,
}

/// An identified model.
#[derive(Clone, Debug)]
pub struct Fit {
    /// The validated model.
    pub model: HostModel,
    /// Its raw parameters.
    pub parameters: HostParameters,
    /// The density that the play parameters come from.
    pub density: Density,
    /// The model's output for every row. Output unit.
    pub simulated: Vec<f64>,
    /// The raw parameters with their standard errors.
    pub estimates: Vec<Estimate>,
    /// How the best start ended.
    pub termination: Termination,
    /// Number of starts tried.
    pub starts: usize,
}

/// Identifies a model. `progress` is called with the number of searches done, at most [`searches`] times.
///
/// # Errors
/// See [`IdentificationError`].
pub fn identify(
    problem: &Problem<'_>,
    options: &Options,
    progress: &(dyn Fn(usize) + Sync),
) -> Result<Fit, IdentificationError> {
    let data = normalise(problem, options)?;
    // The next larger of a few capacities for coordinates.
    match data.coordinates.len() {
        0..=5 => find::<5>(problem, options, &data, progress),
        6..=8 => find::<8>(problem, options, &data, progress),
        9..=16 => find::<16>(problem, options, &data, progress),
        _ => find::<{ KNOTS + 1 }>(problem, options, &data, progress),
    }
}

fn find<const K: usize>(
    problem: &Problem<'_>,
    options: &Options,
    data: &Data,
    progress: &(dyn Fn(usize) + Sync),
) -> Result<Fit, IdentificationError> {
    let pool = rayon::ThreadPoolBuilder::new()
        .num_threads(options.threads)
        .build()
        .map_err(|error| IdentificationError::Threads(error.to_string()))?;
    let done = std::sync::atomic::AtomicUsize::new(0);
    let count = || progress(1 + done.fetch_add(1, std::sync::atomic::Ordering::Relaxed));
    let (thinned, starts) = (data.thinned(), starts::starts(&data.coordinates, options.starts, options.seed));
    let ends = pool.install(|| {
        let screened = search_all::<K>(&thinned, &starts, SCREENING, &count);
        let mut best: Vec<Start> = screened.into_iter().map(|(point, _)| point.at).collect();
        let mut others = best.split_off(finalists(options.starts).min(best.len()));
        // The best of the other kind of muscle, if only one is left.
        others.retain(|at| best.iter().all(|other| other.preconditioned != at.preconditioned));
        best.extend(others.into_iter().next());
        search_all::<K>(data, &best, CONVERGENCE, &count)
    });
    let ends = prefer_preconditioned(ends);
    // The best end whose model has an inverse; that of most models is certain, that of the extended one is not.
    let mut refusal = IdentificationError::Size("starts", options.starts, [1, usize::MAX]);
    for (point, reason) in ends {
        match finish(problem, options, data, &point, &reason) {
            Ok(fit) => return Ok(fit),
            Err(error) => refusal = IdentificationError::Invalid(error),
        }
    }
    Err(refusal)
}

/// The ends, best first. Muscles that are measured have mostly been moved before: that one is fresh has to show,
/// where the recording begins, in a clearly smaller error.
fn prefer_preconditioned<const K: usize>(mut ends: Vec<End<'_, K>>) -> Vec<End<'_, K>> {
    if let Some(place) = ends.iter().position(|(point, _)| point.at.preconditioned) {
        let (best, preconditioned) = (ends[0].0.cost(), ends[place].0.cost());
        if preconditioned * (1.0 - CLEARLY) <= best {
            ends[..=place].rotate_right(1);
        }
    }
    ends
}

/// How many searches [`identify`] makes for a number of starts: all of them briefly, the best ones to the
/// end.
pub fn searches(starts: usize) -> usize {
    2 * starts + finalists(starts) + 1
}

fn finalists(starts: usize) -> usize {
    starts.div_ceil(4)
}

/// Searches from all starts, side by side, and calls `count` at the end of each. The best end comes first.
fn search_all<'a, const K: usize>(
    data: &'a Data,
    starts: &[Start],
    patience: usize,
    count: &(dyn Fn() + Sync),
) -> Vec<End<'a, K>> {
    let one = |start: &Start| {
        let end = search(data, start, patience);
        count();
        end
    };
    let mut ends: Vec<End<'a, K>> = starts.par_iter().map(one).collect();
    // Stable: of equal ends the first start wins, whichever thread was faster.
    ends.sort_by(|(one, _), (other, _)| one.cost().total_cmp(&other.cost()));
    ends
}

/// Where a search ended, and why.
type End<'a, const K: usize> = (Point<'a, K>, TerminationReason);

fn search<'a, const K: usize>(data: &'a Data, start: &Start, patience: usize) -> End<'a, K> {
    let kernel =
        LevenbergMarquardt::new().with_ftol(1e-9).with_xtol(1e-9).with_gtol(1e-9).with_patience(patience);
    let (problem, report) = kernel.minimize(Reduced::new(data, start));
    (problem.into_point(), report.termination)
}

fn finish<const K: usize>(
    problem: &Problem<'_>,
    options: &Options,
    data: &Data,
    point: &Point<'_, K>,
    reason: &TerminationReason,
) -> Result<Fit, ParameterError> {
    let (parameters, density) =
        raw::parameters(&data.structure, &point.inner, &point.columns.grid, &point.linear, data.span)?;
    let parameters = parameters.with_preconditioned(point.at.preconditioned);
    let model = HostModel::try_new(&parameters)?;
    model.inverse()?;
    Ok(Fit {
        simulated: simulate(&model, problem.input),
        estimates: uncertainty::estimates(data, point)?,
        termination: Termination { reason: in_words(reason), converged: reason.was_successful() },
        starts: options.starts,
        model,
        parameters,
        density,
    })
}

/// The model's output for every input, from rest; the inputs are finite.
pub fn simulate(model: &HostModel, input: &[f64]) -> Vec<f64> {
    let mut state = model.rest_state();
    input.iter().map(|&x| model.step(&mut state, x).unwrap_or(f64::NAN)).collect()
}

fn in_words(reason: &TerminationReason) -> String {
    match reason {
        TerminationReason::Converged { ftol: true, xtol: true } => {
            "converged: sum of squares and parameters settled"
        }
        TerminationReason::Converged { ftol: true, .. } => "converged: sum of squares settled",
        TerminationReason::Converged { .. } => "converged: parameters settled",
        TerminationReason::Orthogonal => "converged: the gradient vanished",
        TerminationReason::ResidualsZero => "converged: no residual left",
        TerminationReason::NoImprovementPossible(_) => {
            "converged: no improvement possible in double precision"
        }
        TerminationReason::LostPatience => "stopped: largest number of evaluations reached",
        _ => "stopped: numerical failure",
    }
    .to_string()
}

#[cfg(test)]
mod tests;
