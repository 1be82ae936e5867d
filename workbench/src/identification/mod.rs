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
//! | `robust` | Huber's loss |
//! | `thinning` | a shorter recording that is enough to screen them |
//! | `uncertainty` | standard errors, intervals and correlation of the raw parameters |
//! | `autocorrelation`, `collinear` | what makes them larger: residuals that are alike, parameters that are |
//! | `termination` | how a search ended |
//!
//! The problem has several minima, so that many starts are tried side by side: each gets a few steps on a thinned
//! recording, the better half a few more, then the best quarter goes on to convergence on all of it. The answer depends on the
//! seed, not on the number of threads.
//!
//! # Contract
//! Whatever the recording is, the result is a validated, invertible model or a typed error. Before the recording the
//! muscle is taken to have come from rest at the lowest input, either preconditioned by a full cycle or, if that fits
//! clearly better, fresh. Rows that do not count (`scored` false) still drive it.
//!
//! # Limits
//! At most [`PLAYS`] plays and [`DEAD_ZONES`] dead zones. The inputs of the recording are the model's
//! validity range.

pub mod autocorrelation;
mod collinear;
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
mod robust;
mod starts;
mod structure;
mod termination;
mod thinning;
mod uncertainty;

use levenberg_marquardt::{LevenbergMarquardt, TerminationReason};
use model_core::envelope::KNOTS;
use model_core::{ExtendedModel, Hysteresis, Invertible, Kind, Model, ModelParameters, ParameterError};
use rayon::prelude::*;

use data::{Data, normalise};
pub use error::IdentificationError;
use problem::{Point, Problem as Reduced};
use robust::Robust;
use starts::Start;
use structure::Structure;
pub use termination::Termination;
pub use uncertainty::{Estimate, Uncertainty};

/// The largest number of plays of a model on the host.
pub const PLAYS: usize = 128;
/// The largest number of dead zones of a model on the host.
pub const DEAD_ZONES: usize = 128;
/// The largest number of plays with free weights.
pub const FREE: usize = 32;
/// Raw parameters of a model on the host.
pub type HostParameters = ModelParameters<f64, PLAYS, DEAD_ZONES>;
/// A model on the host.
pub type HostModel = Model<f64, PLAYS, DEAD_ZONES>;
/// A model with its extensions on the host.
pub type HostExtendedModel = ExtendedModel<f64, PLAYS, DEAD_ZONES>;

/// How many ends with exponential weights free ones go on from.
const FREED: usize = 3;
/// The share by which the sum of squares of a fresh muscle has to be smaller to be believed.
const CLEARLY: f64 = 0.02;
/// Number of starts, unless the user has it otherwise.
pub const STARTS: usize = 24;
/// Seed of the starts, unless the user has it otherwise.
pub const SEED: u64 = 1;
/// The share of the sum of squares that a search which is at its end gains no more.
pub const CONVERGED: f64 = 1e-9;
/// What every start gets, and then the better half of them once more.
const SCREENING: Limits = Limits { patience: 2, tolerance: CONVERGED };
/// What the best starts get.
const CONVERGENCE: Limits = Limits { patience: 60, tolerance: CONVERGED };

/// What ends a search that gets no further by itself.
#[derive(Clone, Copy, Debug)]
struct Limits {
    /// Evaluations per coordinate.
    patience: usize,
    /// A step that gains less than this share of the sum of squares is the last.
    tolerance: f64,
}

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
    /// What the weights of the plays are made of; free ones for at most [`FREE`] plays.
    pub weights: Weights,
    /// Number of dead zones, 1 to [`DEAD_ZONES`], for models that have them.
    pub dead_zones: usize,
    /// How a residual counts.
    pub loss: Loss,
    /// Number of starts, at least 1.
    pub starts: usize,
    /// Seed of the starts.
    pub seed: u64,
    /// Threads; 0 for one a core.
    pub threads: usize,
    /// A step that gains less than this share of the sum of squares is the last of a search: [`CONVERGED`], or more where the
    /// answer is only a beginning. Outliers are looked for at [`CONVERGED`].
    pub tolerance: f64,
}

impl Options {
    /// How many independent numbers are found: the raw parameters less those that scalings of the model leave open.
    pub fn unknowns(&self) -> usize {
        Structure { weights: self.weights, ..Structure::new(self) }.unknowns()
    }

    fn convergence(&self) -> Limits {
        Limits { tolerance: self.tolerance, ..CONVERGENCE }
    }
}

/// How a residual counts.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Loss {
    /// By its square.
    Squares,
    /// By its square while small, by its size where it is an outlier's.
    Huber,
}

/// What the weights of the plays are made of.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Weights {
    /// An exponential density, equation (10).
    Exponential,
    /// Each by itself.
    Free,
}

/// What the thresholds and weights of the plays come from.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Density {
    /// Equations (9) and (10).
    Exponential {
        /// Weight of a play of threshold 0.
        rho: f64,
        /// Decay of the weights with the threshold.
        tau: f64,
        /// Distance of the thresholds.
        alpha: f64,
    },
    /// Equally spaced thresholds, equation (9), each with a weight of its own.
    Free {
        /// Distance of the thresholds.
        alpha: f64,
    },
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
    /// What is known about the raw parameters.
    pub uncertainty: Uncertainty,
    /// How the best start ended.
    pub termination: Termination,
    /// Number of starts tried.
    pub starts: usize,
    /// The rows that are outliers, as far as they were looked for ([`Loss::Huber`]).
    pub outliers: Vec<usize>,
}

/// Calls a function with the next larger of a few capacities for coordinates: loops over rows have fixed lengths then.
macro_rules! with_capacity {
    ($count:expr, $function:ident ( $($argument:expr),* )) => {
        match $count {
            0..=5 => $function::<5>($($argument),*),
            6..=8 => $function::<8>($($argument),*),
            9..=16 => $function::<16>($($argument),*),
            17..=32 => $function::<32>($($argument),*),
            _ => $function::<{ KNOTS + FREE }>($($argument),*),
        }
    };
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
    let pool = rayon::ThreadPoolBuilder::new()
        .num_threads(options.threads)
        .build()
        .map_err(|error| IdentificationError::Threads(error.to_string()))?;
    let done = std::sync::atomic::AtomicUsize::new(0);
    let count = || progress(1 + done.fetch_add(1, std::sync::atomic::Ordering::Relaxed));
    let ends =
        pool.install(|| with_capacity!(data.coordinates.len(), search_everywhere(&data, options, &count)));
    if options.weights == Weights::Exponential {
        return with_capacity!(data.coordinates.len(), first_model(problem, options, &data, ends));
    }
    // Free weights go on from where exponential ones end.
    let free = data.with_free_weights();
    let freed: Vec<Start> = ends.iter().take(FREED).map(|(end, _)| end.freed(&data)).collect();
    let search =
        || with_capacity!(free.coordinates.len(), search_all(&free, &freed, options.convergence(), &count));
    let ends = prefer_preconditioned(pool.install(search));
    with_capacity!(free.coordinates.len(), first_model(problem, options, &free, ends))
}

/// Screens all starts, and brings the best to their ends.
fn search_everywhere<const K: usize>(data: &Data, options: &Options, count: &(dyn Fn() + Sync)) -> Vec<End> {
    let starts = starts::starts(&data.coordinates, options.starts, options.seed);
    let thinned = data.thinned();
    let screened = |starts: &[Start]| -> Vec<Start> {
        search_all::<K>(&thinned, starts, SCREENING, count).into_iter().map(|(end, _)| end).collect()
    };
    let mut better = screened(&starts);
    let mut others = better.split_off(better.len() / 2);
    let mut best = screened(&better);
    others.splice(..0, best.split_off(finalists(options.starts).min(best.len())));
    // The best of the other kind of muscle, if only one is left.
    others.retain(|at| best.iter().all(|other| other.preconditioned != at.preconditioned));
    best.extend(others.into_iter().next());
    prefer_preconditioned(search_all::<K>(data, &best, options.convergence(), count))
}

/// The model of the best end that has an inverse; that of most models is certain, that of the extended one is not.
fn first_model<const K: usize>(
    problem: &Problem<'_>,
    options: &Options,
    data: &Data,
    ends: Vec<End>,
) -> Result<Fit, IdentificationError> {
    let mut refusal = IdentificationError::Size("starts", options.starts, [1, usize::MAX]);
    let candidates: Vec<Robust> = match options.loss {
        Loss::Squares => {
            let plain = |end| Robust { data: data.clone(), end, outliers: Vec::new() };
            ends.into_iter().map(plain).collect()
        }
        Loss::Huber => robust::of_both_kinds::<K>(data, ends),
    };
    for Robust { data, end, outliers } in candidates {
        match finish::<K>(problem, options, &data, end) {
            Ok(fit) => return Ok(Fit { outliers, ..fit }),
            Err(error) => refusal = IdentificationError::Invalid(error),
        }
    }
    Err(refusal)
}

/// The ends, best first. Muscles that are measured have mostly been moved before: that one is fresh has to show,
/// where the recording begins, in a clearly smaller error.
fn prefer_preconditioned(mut ends: Vec<End>) -> Vec<End> {
    if let Some(place) = ends.iter().position(|(start, _)| start.preconditioned)
        && !is_clearly_better(&ends[0], &ends[place])
    {
        ends[..=place].rotate_right(1);
    }
    ends
}

fn is_clearly_better((_, fresh): &End, (_, preconditioned): &End) -> bool {
    fresh.cost < preconditioned.cost * (1.0 - CLEARLY)
}

/// How many searches [`identify`] makes for a number of starts: all of them briefly, the better half once more, the best ones to
/// the end.
pub fn searches(starts: usize) -> usize {
    3 * starts + finalists(starts) + 1 + FREED
}

fn finalists(starts: usize) -> usize {
    starts.div_ceil(4)
}

/// Searches from all starts, side by side, and calls `count` at the end of each. The best end comes first.
fn search_all<const K: usize>(
    data: &Data,
    starts: &[Start],
    limits: Limits,
    count: &(dyn Fn() + Sync),
) -> Vec<End> {
    let one = |start: &Start| {
        let end = search::<K>(data, start, limits);
        count();
        end
    };
    let mut ends: Vec<End> = starts.par_iter().map(one).collect();
    // Stable: of equal ends the first start wins, whichever thread was faster.
    ends.sort_by(|(_, one), (_, other)| one.cost.total_cmp(&other.cost));
    ends
}

/// Where a search ended, and with what.
type End = (Start, Reached);

/// What a search has reached.
struct Reached {
    /// Sum of squares.
    cost: f64,
    reason: TerminationReason,
}

fn search<const K: usize>(data: &Data, start: &Start, limits: Limits) -> End {
    let kernel = LevenbergMarquardt::new()
        .with_ftol(limits.tolerance)
        .with_xtol(CONVERGED)
        .with_gtol(CONVERGED)
        .with_patience(limits.patience);
    let (problem, report) = kernel.minimize(Reduced::<K>::new(data, start));
    let point = problem.into_point();
    let reached = Reached { cost: point.cost(), reason: report.termination };
    (point.at, reached)
}

fn finish<const K: usize>(
    problem: &Problem<'_>,
    options: &Options,
    data: &Data,
    (start, Reached { reason, .. }): End,
) -> Result<Fit, ParameterError> {
    let point = &Point::<K>::new(data, start);
    let (parameters, density) =
        raw::parameters(&data.structure, &point.inner, &point.columns.grid, &point.linear, data.span)?;
    let parameters = parameters.with_preconditioned(point.at.preconditioned);
    let model = HostModel::try_new(&parameters)?;
    model.inverse()?;
    Ok(Fit {
        simulated: simulate(&model, problem.input),
        uncertainty: Uncertainty::new(data, point)?,
        termination: (&reason).into(),
        starts: options.starts,
        outliers: Vec::new(),
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

#[cfg(test)]
mod coverage;
#[cfg(test)]
mod tests;
