//! Identification of the models of the family by Levenberg-Marquardt with variable projection.
//!
//! # Design
//! | file | what it does |
//! |---|---|
//! | `data`, `row` | the recording, checked and normalised |
//! | `structure` | the parts of a model of the family |
//! | `coordinates` | the nonlinear coordinates, bounded smoothly |
//! | `envelope`, `plays` | the parts in normalised form, without the model's two exact scalings |
//! | `inner` | u over the recording and its exact sensitivities |
//! | `sums` | all that least squares needs of the rows, in one pass over them |
//! | `projection`, `nnls` | offset, slopes of the dead zones and added functions, linear and kept positive |
//! | `problem` | the reduced problem and its Jacobian, for the Levenberg-Marquardt kernel (MINPACK's, crate `levenberg-marquardt`) |
//! | `starts` | where the searches begin |
//! | `descent` | one search, from a start to its end |
//! | `search` | the searches, one after the other and side by side |
//! | `plan` | how many they are, on how many rows, and how much work |
//! | [`joint`] | two muscles at a joint, by the balance of torques |
//! | [`adapted`] | a model that answers as the muscle does that a board has learnt |
//! | `raw` | the way to the raw parameters |
//! | `robust` | Huber's loss |
//! | `strays` | when it is needed |
//! | `thinning` | a shorter recording that is enough to search on |
//! | `uncertainty` | standard errors, intervals and correlation of the raw parameters |
//! | `autocorrelation`, `collinear` | what makes them larger: residuals that are alike, parameters that are |
//! | `termination` | how a search ended |
//!
//! The problem has several minima, so that many starts are tried side by side: each gets a few
//! steps on a thinned recording, the better half a few more, then the best quarter (of a long
//! recording all) goes on to convergence on it, and the best of these ends on less thinned
//! recordings and in the end on all rows, where few steps are left. The answer depends on the seed,
//! not on the number of threads.
//!
//! # Contract
//! Whatever the recording is, the result is a validated, invertible model or a typed error. Before
//! the recording the muscle is taken to have come from rest at the lowest input, either
//! preconditioned by a full cycle or, if that fits clearly better, fresh. Rows that do not count
//! (`scored` false) still drive it. Of several recordings each begins so.
//!
//! # Limits
//! At most [`PLAYS`] plays and [`DEAD_ZONES`] dead zones. The inputs of the recording are the
//! model's validity range.

pub mod adapted;
pub mod autocorrelation;
mod collinear;
pub mod comparison;
mod coordinates;
mod data;
mod descent;
mod envelope;
mod error;
pub mod holdout;
pub mod identified;
mod inner;
pub mod joint;
pub mod json;
mod nnls;
mod plan;
mod plays;
mod problem;
pub mod progress;
mod projection;
mod raw;
mod robust;
mod row;
mod search;
mod starts;
mod strays;
mod structure;
mod sums;
mod termination;
mod thinning;
mod uncertainty;

use model_core::envelope::KNOTS;
use model_core::{Invertible, Kind, ParameterError};

use data::{Data, normalise};
use descent::{End, Reached};
pub use error::IdentificationError;
use plan::{FREED, Plan};
use problem::Point;
use robust::Robust;
use search::{Searches, finalists};
use starts::Start;
pub use strays::Strays;
use structure::{FURTHER, Structure};
pub use termination::Termination;
pub use uncertainty::{Estimate, Uncertainty};

use crate::progress::{Tell, Work};
use recording::Recording;
pub use recording::model::{
    DEAD_ZONES, Density, HostExtendedModel, HostModel, HostParameters, PLAYS, simulate,
};

/// The largest number of plays with free weights.
pub const FREE: usize = 32;
/// Number of starts, unless the user has it otherwise.
pub const STARTS: usize = 24;
/// Seed of the starts, unless the user has it otherwise.
pub const SEED: u64 = 1;
/// The share of the sum of squares that a search which is at its end gains no more.
pub const CONVERGED: f64 = 1e-9;

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

impl<'a> Problem<'a> {
    /// The outputs that count.
    fn scored_output(&self) -> impl Iterator<Item = &'a f64> + use<'a> {
        self.output.iter().zip(self.scored).filter(|(_, scored)| **scored).map(|(output, _)| output)
    }
}

impl<'a> From<&'a Recording> for Problem<'a> {
    fn from(Recording { drive, output, .. }: &'a Recording) -> Self {
        Self { input: &drive.input.values, output: &output.values, scored: &drive.scored }
    }
}

/// How to identify.
///
/// ```
/// use identification::Options;
/// use model_core::Kind;
///
/// let unknowns = |plays, model| Options { plays, model, ..Options::default() }.unknowns();
/// assert!(unknowns(10, Kind::Mgpi) > unknowns(10, Kind::Sgpi)); // dead zones are parameters
/// ```
#[derive(Clone, Copy, Debug)]
pub struct Options {
    /// Which model.
    pub model: Kind,
    /// A piecewise-linear envelope with so many knots, 3 to [`KNOTS`], for models with one
    /// envelope; without, tanh.
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
    /// A step that gains less than this share of the sum of squares is the last of a search:
    /// [`CONVERGED`], or more where the answer is only a beginning. Outliers are looked for at
    /// [`CONVERGED`].
    pub tolerance: f64,
}

impl Default for Options {
    /// The paper's model with its ten plays and ten dead zones, by least squares.
    fn default() -> Self {
        Self {
            model: Kind::Mgpi,
            knots: None,
            plays: 10,
            weights: Weights::Exponential,
            dead_zones: 10,
            loss: Loss::Squares,
            starts: STARTS,
            seed: SEED,
            threads: 0,
            tolerance: CONVERGED,
        }
    }
}

impl Options {
    /// How many independent numbers are found: the raw parameters less those that scalings of the
    /// model leave open.
    pub fn unknowns(&self) -> usize {
        Structure { weights: self.weights, ..Structure::new(self) }.unknowns()
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

/// An identified model.
#[derive(Clone, Debug)]
pub struct Fit {
    /// The validated model.
    pub model: HostModel,
    /// Its raw parameters.
    pub parameters: HostParameters,
    /// The density that the play parameters come from.
    pub density: Density,
    /// The model's output for every row, of several recordings one behind the other. Output unit.
    pub simulated: Vec<f64>,
    /// What is known about the raw parameters.
    pub uncertainty: Uncertainty,
    /// How the best start ended.
    pub termination: Termination,
    /// Number of starts tried.
    pub starts: usize,
    /// The rows that are outliers, as far as they were looked for ([`Loss::Huber`]); of several
    /// recordings counted on from one to the next.
    pub outliers: Vec<usize>,
}

/// Calls a method with the next larger of a few capacities for entries: loops over entries have
/// fixed lengths then.
macro_rules! with_capacity {
    ($count:expr, $object:ident . $method:ident ( $($argument:expr),* )) => {
        match $count {
            0..=8 => $object.$method::<8>($($argument),*),
            9..=12 => $object.$method::<12>($($argument),*),
            13..=16 => $object.$method::<16>($($argument),*),
            17..=24 => $object.$method::<24>($($argument),*),
            25..=36 => $object.$method::<36>($($argument),*),
            _ => $object.$method::<{ KNOTS + FREE + FURTHER }>($($argument),*),
        }
    };
}

/// Units of the work of [`identify`] on so many rows that count, to compare with each other.
///
/// ```
/// use identification::{Options, work};
///
/// let options = Options::default();
/// assert!(work(20_000, &options) > work(2_000, &options));
/// ```
pub fn work(rows: usize, options: &Options) -> f64 {
    Plan::new(rows, options).units()
}

/// Identifies a model. `progress` is told the share of the work that is done.
///
/// # Errors
/// See [`IdentificationError`].
///
/// ```
/// use identification::{Options, Problem, identify};
/// use model_core::Kind;
///
/// // A straight line with a play of 0.5 bar: 10 mm/bar, and hysteresis.
/// let input: Vec<f64> = (0..400).map(|k| 3.0 - 3.0 * (0.0628 * f64::from(k)).cos()).collect();
/// let mut held = 0.0_f64;
/// let output: Vec<f64> = input.iter().map(|&x| { held = held.clamp(x - 0.5, x + 0.5); 5.0 * (x + held) }).collect();
/// let scored = vec![true; input.len()];
/// let options = Options { model: Kind::Cpi, plays: 4, starts: 2, ..Options::default() };
/// let fit = identify(&Problem { input: &input, output: &output, scored: &scored }, &options, &|_| ())?;
/// let worst = fit.simulated.iter().zip(&output).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
/// assert!(worst < 3.0, "{worst} mm of a stroke of 57 mm");
/// # Ok::<(), Box<dyn core::error::Error>>(())
/// ```
pub fn identify(
    problem: &Problem<'_>,
    options: &Options,
    progress: Tell<'_>,
) -> Result<Fit, IdentificationError> {
    identify_several(&[*problem], options, progress)
}

/// Identifies one model from several recordings of one muscle, each of which begins from rest at
/// the lowest input of all. `progress` is told the share of the work that is done.
///
/// # Errors
/// See [`IdentificationError`]; there is no recording.
///
/// ```
/// use identification::{Options, Problem, identify_several};
/// use model_core::Kind;
///
/// let ramps = |top: f64| -> Vec<f64> { (0..200).map(|k| top * (0.5 - 0.5 * (0.1 * f64::from(k)).cos())).collect() };
/// let (low, high) = (ramps(2.0), ramps(6.0));
/// let line = |input: &[f64]| -> Vec<f64> { input.iter().map(|x| 10.0 * x).collect() };
/// let (short, long) = (line(&low), line(&high));
/// let scored = [true; 200];
/// let both = [
///     Problem { input: &low, output: &short, scored: &scored },
///     Problem { input: &high, output: &long, scored: &scored },
/// ];
/// let options = Options { model: Kind::Cpi, plays: 2, starts: 2, ..Options::default() };
/// let fit = identify_several(&both, &options, &|_| ())?;
/// assert_eq!(fit.simulated.len(), 400); // those of the second recording behind those of the first
/// # Ok::<(), Box<dyn core::error::Error>>(())
/// ```
pub fn identify_several(
    problems: &[Problem<'_>],
    options: &Options,
    progress: Tell<'_>,
) -> Result<Fit, IdentificationError> {
    let data = normalise(problems, options)?;
    let pool = rayon::ThreadPoolBuilder::new()
        .num_threads(options.threads)
        .build()
        .map_err(|error| IdentificationError::Threads(error.to_string()))?;
    let plan = Plan::new(data.count(), options);
    let work = Work::new(plan.units(), progress);
    let searches = Searches { options, plan, work: &work };
    pool.install(|| {
        let entries = data.structure.entries();
        let ends = with_capacity!(entries, searches.everywhere(&data));
        if options.weights == Weights::Exponential {
            return with_capacity!(entries, searches.first_model(problems, &data, ends));
        }
        // Free weights go on from where exponential ones end.
        let freed: Vec<Start> = ends.iter().take(FREED).map(|(end, _)| end.freed(&data)).collect();
        let free = data.with_free_weights();
        let entries = free.structure.entries();
        let ends = with_capacity!(entries, searches.onwards(&free, &freed));
        with_capacity!(entries, searches.first_model(problems, &free, ends))
    })
}

impl Searches<'_> {
    /// The model of the best end that has an inverse; that of most models is certain, that of the
    /// extended one is not.
    fn first_model<const K: usize>(
        &self,
        problems: &[Problem<'_>],
        data: &Data,
        ends: Vec<End>,
    ) -> Result<Fit, IdentificationError> {
        let mut refusal = IdentificationError::Size("starts", self.options.starts, [1, usize::MAX]);
        let mut ends = self.believed::<K>(data, ends);
        while !ends.is_empty() {
            let later = ends.split_off(finalists(&ends, data.count()));
            for Robust { data, end, outliers } in self.on_all_rows::<K>(data, &ends) {
                match self.finish::<K>(problems, &data, end) {
                    Ok(fit) => return Ok(Fit { outliers, ..fit }),
                    Err(error) => refusal = IdentificationError::Invalid(error),
                }
            }
            ends = later;
        }
        Err(refusal)
    }

    fn finish<const K: usize>(
        &self,
        problems: &[Problem<'_>],
        data: &Data,
        (start, Reached { reason, .. }): End,
    ) -> Result<Fit, ParameterError> {
        let _part = self.work.begin(self.plan.uncertainty);
        let point = &Point::<K>::new(data, start, None);
        let (parameters, density) =
            raw::parameters(&data.structure, &point.inner, &point.grid, &point.linear, data.span)?;
        let parameters = parameters.with_preconditioned(point.at.preconditioned);
        let model = HostModel::try_new(&parameters)?;
        model.inverse()?;
        Ok(Fit {
            simulated: problems.iter().flat_map(|problem| simulate(&model, problem.input)).collect(),
            uncertainty: Uncertainty::new(data, point)?,
            termination: (&reason).into(),
            starts: self.options.starts,
            outliers: Vec::new(),
            model,
            parameters,
            density,
        })
    }
}

#[cfg(test)]
mod coverage;
#[cfg(test)]
mod long;
#[cfg(test)]
mod tests;
