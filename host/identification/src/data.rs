//! A recording, checked and normalised for the search.

use model_core::envelope::KNOTS;
use model_core::memoryless::{DEGREE, Memoryless, MemorylessParameters};
use model_core::{ParameterError, Range};

use super::coordinates::Coordinate;
use super::row::{Row, Span};
use super::structure::Structure;
use super::{DEAD_ZONES, FREE, IdentificationError, Options, PLAYS, Problem, Weights};
use recording::numbers::range;

/// The smallest slope allowed in the stage behind the plays, as a share of the mean slope: how
/// far a model is kept from being non-invertible.
const LEAST_SLOPE: f64 = 1e-2;

/// A recording, normalised for the search.
#[derive(Clone)]
pub struct Data {
    /// The rows up to the last that counts.
    pub rows: Vec<Row>,
    /// Number of first rows that rest at the lowest input: their branch is that of what was before.
    pub resting: usize,
    /// Lowest input and span of the inputs. Input unit.
    pub span: Span,
    /// The functions of the input over its span that are added, if there are any.
    pub added: Option<Memoryless<f64>>,
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
    let count = scored.iter().filter(|&&scored| scored).count();
    let parameters = options.unknowns();
    if count <= parameters {
        return Err(IdentificationError::TooFewRows { rows: count, parameters });
    }
    let (low, high) = range(input);
    if low == high {
        return Err(IdentificationError::ConstantInput(low));
    }
    let outputs = output.iter().zip(scored).filter(|(_, scored)| **scored).map(|(output, _)| output);
    let (output_low, output_high) = range(outputs);
    if output_low == output_high {
        return Err(IdentificationError::ConstantOutput(output_low));
    }
    let span = (low, high - low);
    let rows = rows(problem, span);
    Ok(Data {
        resting: rows.iter().take_while(|row| row.input == 0.0).count(),
        rows,
        span,
        added: (structure.added() > 0).then(added).transpose().map_err(IdentificationError::Invalid)?,
        least_slope: LEAST_SLOPE * (output_high - output_low),
        structure,
        coordinates,
    })
}

/// The functions of an input of 0 … 1 that are added.
fn added() -> Result<Memoryless<f64>, ParameterError> {
    let range = Range::try_new(0.0, 1.0, "input range", "input unit")?;
    Memoryless::try_new(&MemorylessParameters { rises: [0.0; DEGREE] }, &range)
}

/// The rows up to the last that counts.
fn rows(problem: &Problem<'_>, (low, span): Span) -> Vec<Row> {
    let Problem { input, output, scored } = *problem;
    let end = scored.iter().rposition(|&scored| scored).map_or(0, |last| last + 1);
    let (mut before, mut rising) = (0.0, true);
    let row = |((x, &output), &scored): ((&f64, &f64), &bool)| {
        let input = (x - low) / span;
        rising = if input == before { rising } else { input > before };
        before = input;
        Row { input, output, weight: f32::from(u8::from(scored)), rising }
    };
    input[..end].iter().zip(output).zip(scored).map(row).collect()
}

/// Number of free weights, if they are.
fn free_weights(options: &Options) -> Option<usize> {
    (options.weights == Weights::Free).then_some(options.plays)
}

impl Data {
    /// Number of rows that count.
    pub fn count(&self) -> usize {
        self.rows.iter().filter(|row| row.weight > 0.0).count()
    }

    /// The recording without those rows at which a fresh and a preconditioned muscle differ, all
    /// before the input is first at its highest. None if that leaves less than half.
    pub fn where_kinds_agree(&self) -> Option<Self> {
        let mut agreed = self.clone();
        let first = agreed.rows.iter().position(|row| row.input == 1.0)?;
        agreed.rows[..first].iter_mut().for_each(|row| row.weight = 0.0);
        let weight = |rows: &[Row]| rows.iter().map(|row| f64::from(row.weight)).sum::<f64>();
        (2.0 * weight(&agreed.rows) >= weight(&self.rows)).then_some(agreed)
    }

    /// The same recording for a model of the same structure, but with free weights of the plays.
    pub fn with_free_weights(self) -> Self {
        let structure = Structure { weights: Weights::Free, ..self.structure };
        Self { coordinates: structure.coordinates(), structure, ..self }
    }
}
