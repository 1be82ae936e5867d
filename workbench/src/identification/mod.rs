//! Identification of the models of the family by Levenberg-Marquardt with variable projection.
//!
//! # Design
//! | file | what it does |
//! |---|---|
//! | `structure` | the parts of a model of the family |
//! | `coordinates` | the nonlinear coordinates, bounded smoothly |
//! | `envelope`, `plays` | the parts in normalised form, without the model's two exact scalings |
//! | `inner` | u over the recording and its exact sensitivities |
//! | `projection`, `nnls` | offset, slopes of the dead zones and added functions, linear and kept positive |
//! | `problem` | the reduced problem and its Jacobian, for the Levenberg-Marquardt kernel (MINPACK's, crate `levenberg-marquardt`) |
//! | `starts` | where the searches begin |
//! | `raw`, [`named`] | the way to the raw parameters, and their names |
//! | `uncertainty` | standard errors of the raw parameters |
//!
//! The problem has several minima, so that many starts are tried side by side: each gets a few steps, then
//! the best quarter goes on to convergence. The answer depends on the seed, not on the number of threads.
//!
//! # Contract
//! Whatever the recording is, the result is a validated, invertible model or a typed error. The muscle is
//! taken to have come from rest at the lowest input; rows that do not count (`scored` false) still
//! drive it.
//!
//! # Limits
//! At most [`PLAYS`] plays and [`DEAD_ZONES`] dead zones. The inputs of the recording are the model's
//! validity range.

mod coordinates;
mod envelope;
mod inner;
pub mod named;
mod nnls;
mod plays;
mod problem;
mod projection;
mod raw;
mod starts;
mod structure;
mod uncertainty;

use std::fmt;

use levenberg_marquardt::{LevenbergMarquardt, TerminationReason};
use model_core::envelope::KNOTS;
use model_core::memoryless::{Memoryless, MemorylessParameters};
use model_core::{Hysteresis, Invertible, Kind, Model, ModelParameters, ParameterError, Range};
use rayon::prelude::*;

use named::Named;
use problem::{Data, Point, Problem as Reduced};
use structure::Structure;

/// The largest number of plays of a model on the host.
pub const PLAYS: usize = 128;
/// The largest number of dead zones of a model on the host.
pub const DEAD_ZONES: usize = 128;
/// Raw parameters of a model on the host.
pub type HostParameters = ModelParameters<f64, PLAYS, DEAD_ZONES>;
/// A model on the host.
pub type HostModel = Model<f64, PLAYS, DEAD_ZONES>;

/// The smallest slope that the dead-zone stage may get, as a share of the mean slope: how far a model is
/// kept from being non-invertible.
const LEAST_SLOPE: f64 = 1e-2;
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

/// Why nothing can be identified.
#[derive(Clone, Debug, PartialEq)]
pub enum IdentificationError {
    /// Lists of different length.
    Lengths,
    /// A size outside its limits: its name, value, least and largest value.
    Size(&'static str, usize, [usize; 2]),
    /// Fewer rows that count than parameters.
    TooFewRows {
        /// Rows that count.
        rows: usize,
        /// Parameters to find.
        parameters: usize,
    },
    /// A number that is not finite: the list's name and the row, counted from 0.
    NotFinite(&'static str, usize),
    /// The input never changes; its value.
    ConstantInput(f64),
    /// The output never changes; its value.
    ConstantOutput(f64),
    /// The best model found is not valid.
    Invalid(ParameterError),
    /// The threads could not be started.
    Threads(String),
}

impl fmt::Display for IdentificationError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Lengths => write!(f, "input, output and scored rows differ in number"),
            Self::Size(name, value, [min, max]) => {
                write!(f, "number of {name} is {value}, must be {min} to {max}")
            }
            Self::TooFewRows { rows, parameters } => {
                write!(
                    f,
                    "{rows} rows count, but the model has {parameters} parameters: record more, or use fewer"
                )
            }
            Self::NotFinite(list, row) => write!(f, "{list} of row {row} is not a finite number"),
            Self::ConstantInput(value) => {
                write!(f, "the input is constant ({value}): nothing can be identified")
            }
            Self::ConstantOutput(value) => {
                write!(f, "the output is constant ({value}): nothing can be identified")
            }
            Self::Invalid(error) => write!(f, "the best model found is not valid: {error}"),
            Self::Threads(error) => write!(f, "the threads of the search could not be started: {error}"),
        }
    }
}

impl std::error::Error for IdentificationError {}

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
    let search_all = |starts: &[Vec<f64>], patience: usize| {
        let mut ends: Vec<_> = starts
            .par_iter()
            .map(|start| {
                let end = search::<K>(data, start, patience);
                progress(1 + done.fetch_add(1, std::sync::atomic::Ordering::Relaxed));
                end
            })
            .collect();
        // Stable: of equal ends the first start wins, whichever thread was faster.
        ends.sort_by(|(one, _), (other, _)| one.cost().total_cmp(&other.cost()));
        ends
    };
    let ends = pool.install(|| {
        let screened =
            search_all(&starts::starts(&data.coordinates, options.starts, options.seed), SCREENING);
        let best = screened.into_iter().take(finalists(options.starts));
        let best: Vec<Vec<f64>> = best.map(|(point, _)| point.coordinates).collect();
        search_all(&best, CONVERGENCE)
    });
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

/// How many searches [`identify`] makes for a number of starts: all of them briefly, the best ones to the
/// end.
pub fn searches(starts: usize) -> usize {
    starts + finalists(starts)
}

fn finalists(starts: usize) -> usize {
    starts.div_ceil(4)
}

/// Lowest input and span of the inputs. Input unit.
type Span = (f64, f64);

/// The inputs of a recording.
struct Drive {
    /// The inputs, 0 … 1 over their span.
    inputs: Vec<f64>,
    /// Whether each is on a rising branch; one that rests keeps its branch.
    rising: Vec<bool>,
}

impl Drive {
    fn new(input: &[f64], (low, span): Span) -> Self {
        let mut state = (low, true);
        let is_rising = |&x: &f64| {
            let rising = if x == state.0 { state.1 } else { x > state.0 };
            state = (x, rising);
            rising
        };
        Self {
            rising: input.iter().map(is_rising).collect(),
            inputs: input.iter().map(|x| (x - low) / span).collect(),
        }
    }
}

fn normalise(problem: &Problem<'_>, options: &Options) -> Result<Data, IdentificationError> {
    let Problem { input, output, scored } = *problem;
    if input.len() != output.len() || input.len() != scored.len() {
        return Err(IdentificationError::Lengths);
    }
    for (name, value, limits) in [
        ("plays", options.plays, [1, PLAYS]),
        ("dead zones", options.dead_zones, [1, DEAD_ZONES]),
        ("knots", options.knots.unwrap_or(KNOTS), [3, KNOTS]),
        ("starts", options.starts, [1, usize::MAX]),
    ] {
        if !(limits[0]..=limits[1]).contains(&value) {
            return Err(IdentificationError::Size(name, value, limits));
        }
    }
    for (name, list) in [("input", input), ("output", output)] {
        if let Some(row) = list.iter().position(|value| !value.is_finite()) {
            return Err(IdentificationError::NotFinite(name, row));
        }
    }
    let structure = Structure::new(options);
    let coordinates = structure.coordinates();
    let rows: Vec<usize> = (0..scored.len()).filter(|&row| scored[row]).collect();
    let parameters = coordinates.len() + structure.linear();
    if rows.len() <= parameters {
        return Err(IdentificationError::TooFewRows { rows: rows.len(), parameters });
    }
    let range = |values: &mut dyn Iterator<Item = f64>| {
        values
            .fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), value| (low.min(value), high.max(value)))
    };
    let (low, high) = range(&mut input.iter().copied());
    if low == high {
        return Err(IdentificationError::ConstantInput(low));
    }
    let (output_low, output_high) = range(&mut rows.iter().map(|&row| output[row]));
    if output_low == output_high {
        return Err(IdentificationError::ConstantOutput(output_low));
    }
    let span = (low, high - low);
    Ok(Data {
        drive: Drive::new(input, span),
        span,
        outputs: rows.iter().map(|&row| output[row]).collect(),
        added: added(&structure, &rows, input, (low, high))?,
        rows,
        least_slope: LEAST_SLOPE * (output_high - output_low),
        structure,
        coordinates,
    })
}

/// The added functions of the input at some rows.
fn added(
    structure: &Structure,
    rows: &[usize],
    input: &[f64],
    (low, high): (f64, f64),
) -> Result<Vec<Vec<f64>>, IdentificationError> {
    let function = Range::try_new(low, high, "input range", "input unit")
        .and_then(|range| Memoryless::try_new(&MemorylessParameters { rises: [0.0; 3] }, &range))
        .map_err(IdentificationError::Invalid)?;
    let column = |k: usize| rows.iter().map(|&row| function.basis(input[row])[k]).collect();
    Ok((0..structure.added()).map(column).collect())
}

fn search<'a, const K: usize>(
    data: &'a Data,
    start: &[f64],
    patience: usize,
) -> (Point<'a, K>, TerminationReason) {
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
