//! A model that answers as the muscle does that a board has learnt.
//!
//! What a board learns ([`model_core::adaptation`]) stands beside its model. To keep it the model's
//! operator is identified again, with the same structure, from what the changed muscle would answer
//! to triangles through the whole input range. What the structure cannot follow is told.
//!
//! # Limits
//! Extensions stay as they are. Where some of them act behind the operator, the change is taken to
//! act there too.

use model_core::adaptation::{Adapter, Change};
use model_core::envelope::EnvelopeParameters;
use model_core::{Hysteresis, InputError};
use recording::model::{Density, HostModel, HostParameters};

use crate::{Fit, IdentificationError, Options, Problem, Weights, identify};

/// Triangles, each smaller than the one before, as in the paper's Fig. 8.
const TRIANGLES: usize = 6;
/// Rows from end to end of the input range.
const ROWS: usize = 400;

/// A model that follows a change.
#[derive(Clone, Debug)]
pub struct Followed {
    /// The model.
    pub fit: Fit,
    /// Root mean square of what the old model is off by from the changed muscle. Output unit.
    pub before: f64,
    /// The same of the new one. Output unit.
    pub after: f64,
    /// The highest less the lowest output of the changed muscle. Output unit.
    pub stroke: f64,
}

/// Why no model of the changed muscle was identified.
#[derive(Clone, Debug, PartialEq)]
pub enum AdaptedError {
    /// The model refuses its own inputs.
    Input(InputError),
    /// None can be identified.
    Identification(IdentificationError),
}

impl std::fmt::Display for AdaptedError {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Self::Input(error) => write!(f, "{error}"),
            Self::Identification(error) => write!(f, "{error}"),
        }
    }
}

impl std::error::Error for AdaptedError {}

/// Follows a change (output unit) of the muscle of a model, with as many starts as `options` has.
///
/// # Errors
/// See [`AdaptedError`].
pub fn follow(
    parameters: &HostParameters,
    density: &Density,
    change: Change<f64>,
    options: Options,
) -> Result<Followed, AdaptedError> {
    let refused = |error| AdaptedError::Identification(IdentificationError::Invalid(error));
    let model = HostModel::try_new(parameters).map_err(refused)?;
    let (low, high) = parameters.input();
    let adapter = Adapter::new(model.output_range(), (low, high));
    let mut adapted = adapter.remembered(adapter.in_halves(change));
    let mut state = model.rest_state();
    let input: Vec<f64> = triangles().map(|share| low + (high - low) * share).collect();
    let plain: Vec<f64> = input
        .iter()
        .map(|input| model.step(&mut state, *input))
        .collect::<Result<_, _>>()
        .map_err(AdaptedError::Input)?;
    let output: Vec<f64> = plain.iter().map(|plain| adapter.answered(&mut adapted, *plain)).collect();
    let scored = vec![true; input.len()];
    let problem = Problem { input: &input, output: &output, scored: &scored };
    let fit = identify(&problem, &like(parameters, density, options), &|_| ())
        .map_err(AdaptedError::Identification)?;
    let off = |answers: &[f64]| {
        let squares: f64 =
            answers.iter().zip(&output).map(|(answer, output)| (answer - output).powi(2)).sum();
        (squares / output.len() as f64).sqrt()
    };
    let ends = |of: fn(f64, f64) -> f64, start| output.iter().copied().fold(start, of);
    Ok(Followed {
        before: off(&plain),
        after: off(&fit.simulated),
        stroke: ends(f64::max, f64::NEG_INFINITY) - ends(f64::min, f64::INFINITY),
        fit,
    })
}

/// From 0 to 1 and back, and to ever less.
fn triangles() -> impl Iterator<Item = f64> {
    (1..=TRIANGLES).rev().flat_map(|triangle| {
        let peak = triangle as f64 / TRIANGLES as f64;
        let rows = ROWS * triangle / TRIANGLES;
        (0..2 * rows).map(move |row| peak * (1.0 - (row as f64 / rows as f64 - 1.0).abs()))
    })
}

/// Options by which a model of the same structure is identified.
fn like(parameters: &HostParameters, density: &Density, options: Options) -> Options {
    let (plays, dead_zones, knots) = match parameters {
        HostParameters::Cascade(cascade) => {
            let knots = match &cascade.envelope {
                EnvelopeParameters::PiecewiseLinear(envelope) => Some(envelope.inputs.len()),
                _ => None,
            };
            (cascade.plays.thresholds.len(), cascade.dead_zones.weights.len(), knots)
        }
        HostParameters::Agpi(agpi) => (agpi.plays.thresholds.len(), options.dead_zones, None),
        HostParameters::Egpi(egpi) => (egpi.agpi.plays.thresholds.len(), options.dead_zones, None),
    };
    let weights = match density {
        Density::Exponential { .. } => Weights::Exponential,
        Density::Free { .. } => Weights::Free,
    };
    Options { model: parameters.kind(), knots, plays, weights, dead_zones, ..options }
}
