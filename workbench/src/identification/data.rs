//! A recording, checked and normalised for the search.

use model_core::Range;
use model_core::envelope::KNOTS;
use model_core::memoryless::{Memoryless, MemorylessParameters};

use super::coordinates::Coordinate;
use super::structure::Structure;
use super::{DEAD_ZONES, FREE, IdentificationError, Options, PLAYS, Problem, Weights};

/// The smallest slope that the stage behind the plays may get, as a share of the mean slope: how far a model is
/// kept from being non-invertible.
const LEAST_SLOPE: f64 = 1e-2;

/// Lowest input and span of the inputs. Input unit.
pub type Span = (f64, f64);

/// The inputs of a recording.
#[derive(Clone)]
pub struct Drive {
    /// The inputs, 0 … 1 over their span.
    pub inputs: Vec<f64>,
    /// Whether each is on a rising branch; one that rests keeps its branch.
    pub rising: Vec<bool>,
    /// Number of first inputs that rest at the lowest one: their branch is that of what was before.
    pub resting: usize,
}

impl Drive {
    /// Inputs from 0 to 1.
    pub fn new(inputs: Vec<f64>) -> Self {
        let mut last = (0.0, true);
        let is_rising = |&t: &f64| {
            let rising = if t == last.0 { last.1 } else { t > last.0 };
            last = (t, rising);
            rising
        };
        Self {
            rising: inputs.iter().map(is_rising).collect(),
            resting: inputs.iter().take_while(|&&t| t == 0.0).count(),
            inputs,
        }
    }
}

/// A recording, normalised for the search.
#[derive(Clone)]
pub struct Data {
    /// The inputs.
    pub drive: Drive,
    /// Lowest input and span of the inputs. Input unit.
    pub span: Span,
    /// The rows that count.
    pub rows: Vec<usize>,
    /// The outputs of those rows. Output unit.
    pub outputs: Vec<f64>,
    /// Added functions of the input at those rows.
    pub added: Vec<Vec<f64>>,
    /// The smallest slope allowed. Output unit per unit of u.
    pub least_slope: f64,
    /// What is identified.
    pub structure: Structure,
    /// Its coordinates.
    pub coordinates: Vec<Coordinate>,
}

/// Checks a problem and normalises it for the search.
///
/// # Errors
/// See [`IdentificationError`].
pub fn normalise(problem: &Problem<'_>, options: &Options) -> Result<Data, IdentificationError> {
    let Problem { input, output, scored } = *problem;
    if input.len() != output.len() || input.len() != scored.len() {
        return Err(IdentificationError::Lengths);
    }
    for (name, value, limits) in [
        ("plays", options.plays, [1, PLAYS]),
        ("dead zones", options.dead_zones, [1, DEAD_ZONES]),
        ("knots", options.knots.unwrap_or(KNOTS), [3, KNOTS]),
        ("plays with free weights", free_weights(options).unwrap_or(1), [1, FREE]),
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
    let parameters = options.unknowns();
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
        drive: Drive::new(input.iter().map(|x| (x - low) / (high - low)).collect()),
        span,
        outputs: rows.iter().map(|&row| output[row]).collect(),
        added: added(&structure, &rows, input, (low, high))?,
        rows,
        least_slope: LEAST_SLOPE * (output_high - output_low),
        structure,
        coordinates,
    })
}

/// Number of free weights, if they are.
fn free_weights(options: &Options) -> Option<usize> {
    (options.weights == Weights::Free).then_some(options.plays)
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

impl Data {
    /// The same recording for a model of the same structure, but with free weights of the plays.
    pub fn with_free_weights(&self) -> Self {
        let structure = Structure { weights: Weights::Free, ..self.structure };
        Self { coordinates: structure.coordinates(), structure, ..self.clone() }
    }
}
