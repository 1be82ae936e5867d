//! Recordings of one muscle, checked and normalised for the search: their rows one after the other,
//! each recording from rest.

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

/// Recordings of one muscle, normalised for the search.
#[derive(Clone)]
pub struct Data {
    /// The rows up to the last that counts, those of each recording behind those of the one before.
    pub rows: Vec<Row>,
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

/// Checks recordings of one muscle and normalises them for the search.
///
/// # Errors
/// See [`IdentificationError`].
pub fn normalise(problems: &[Problem<'_>], options: &Options) -> Result<Data, IdentificationError> {
    let have_one_length = |&Problem { input, output, scored }: &Problem<'_>| {
        input.len() == output.len() && input.len() == scored.len()
    };
    if !problems.iter().all(have_one_length) {
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
    for Problem { input, output, .. } in problems {
        for (name, list) in [("input", input), ("output", output)] {
            if let Some(row) = list.iter().position(|value| !value.is_finite()) {
                return Err(IdentificationError::NotFinite(name, row));
            }
        }
    }
    let structure = Structure::new(options);
    let coordinates = structure.coordinates();
    let outputs = || problems.iter().flat_map(Problem::scored_output);
    let count = outputs().count();
    let parameters = options.unknowns();
    if count <= parameters {
        return Err(IdentificationError::TooFewRows { rows: count, parameters });
    }
    let (low, high) = range(problems.iter().flat_map(|problem| problem.input));
    if low == high {
        return Err(IdentificationError::ConstantInput(low));
    }
    let (output_low, output_high) = range(outputs());
    if output_low == output_high {
        return Err(IdentificationError::ConstantOutput(output_low));
    }
    let span = (low, high - low);
    let mut rows: Vec<Row> = problems.iter().flat_map(|problem| rows(problem, span)).collect();
    rows.truncate(rows.iter().rposition(|row| row.weight > 0.0).map_or(0, |last| last + 1));
    Ok(Data {
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

/// The rows of a recording.
fn rows(problem: &Problem<'_>, (low, span): Span) -> Vec<Row> {
    let Problem { input, output, scored } = *problem;
    let (mut before, mut rising, mut rests) = (0.0, true, true);
    let row = |place: usize| {
        let input = (input[place] - low) / span;
        rising = if input == before { rising } else { input > before };
        rests &= input == 0.0;
        before = input;
        let weight = f32::from(u8::from(scored[place]));
        Row { input, output: output[place], weight, rising, begins: place == 0, rests }
    };
    (0..input.len()).map(row).collect()
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

    /// The recordings without those rows at which a fresh and a preconditioned muscle differ, all
    /// before the input of a recording is first at the highest of all. None if that leaves less
    /// than half.
    pub fn where_kinds_agree(&self) -> Option<Self> {
        let mut agreed = self.clone();
        let mut has_been_highest = false;
        for row in &mut agreed.rows {
            has_been_highest = row.input == 1.0 || has_been_highest && !row.begins;
            if !has_been_highest {
                row.weight = 0.0;
            }
        }
        let weight = |rows: &[Row]| rows.iter().map(|row| f64::from(row.weight)).sum::<f64>();
        (2.0 * weight(&agreed.rows) >= weight(&self.rows)).then_some(agreed)
    }

    /// The same recording for a model of the same structure, but with free weights of the plays.
    pub fn with_free_weights(self) -> Self {
        let structure = Structure { weights: Weights::Free, ..self.structure };
        Self { coordinates: structure.coordinates(), structure, ..self }
    }
}
