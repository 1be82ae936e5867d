//! What a model is put through before it may control: once over its whole range and back, each
//! sample inverted again.
//!
//! That gives two things. The *round trip* tells whether the inverse, in the board's arithmetic,
//! gives back what the model was given. The *loop* tells between which contractions the muscle is
//! at each pressure: the two branches of the outermost loop, as a table. Both are made when a
//! configuration arrives, outside the tick.

use model_core::{Hysteresis, InverseHysteresis, InverseModel, Model, ModelParameters, ParameterError};
use wire::{DEAD_ZONES, PLAYS};

/// Rows of the table.
const ROWS: usize = 33;
/// The most that the inverse may miss by, as a share of the range of inputs: a twentieth of a bar
/// in 5.
const ROUND_TRIP: f32 = 0.01;

/// The outermost loop of a model.
#[derive(Clone, Debug)]
pub struct Loop {
    start_bar: f32,
    rows_per_bar: f32,
    /// Contraction on the way up and on the way down. Unit: mm.
    rows: [(f32, f32); ROWS],
    /// Unit: mm.
    stroke_mm: f32,
}

/// What was found.
#[derive(Clone, Debug)]
pub struct Survey {
    /// The outermost loop.
    pub outermost: Loop,
    /// Whether the inverse gives back what the model was given.
    pub is_invertible: bool,
}

/// Surveys a model and its inverse.
///
/// Not inlined: it needs much stack, and only while it runs.
///
/// # Errors
/// The first parameter that no model can be made of.
#[inline(never)]
pub fn survey(
    model: &ModelParameters<f32, PLAYS, DEAD_ZONES>,
    inverse: &InverseModel<f32, PLAYS, DEAD_ZONES>,
) -> Result<Survey, ParameterError> {
    let model = Model::try_new(model)?;
    let (start, end) = (model.input_range().min(), model.input_range().max());
    let step = (end - start) / (ROWS - 1) as f32;
    let (mut state, mut inverse_state) = (model.rest_state(), inverse.rest_state());
    let mut worst = 0.0;
    let mut contraction = |row: usize| {
        let input = start + step * row as f32;
        let output = model.step(&mut state, input).unwrap_or(f32::NAN);
        let again = inverse.step(&mut inverse_state, output).unwrap_or(f32::NAN);
        let error = (again - input).abs();
        // Not the larger of the two, which would drop a NaN.
        if error > worst || error.is_nan() {
            worst = error;
        }
        output
    };
    let mut rows = [(0.0, 0.0); ROWS];
    rows.iter_mut().enumerate().for_each(|(row, entry)| entry.0 = contraction(row));
    rows.iter_mut().enumerate().rev().for_each(|(row, entry)| entry.1 = contraction(row));
    let (low, high) = model.output_range();
    let outermost = Loop { start_bar: start, rows_per_bar: step.recip(), rows, stroke_mm: high - low };
    Ok(Survey { outermost, is_invertible: worst <= ROUND_TRIP * (end - start) })
}

impl Loop {
    /// Whether a muscle at a pressure (bar) may have a contraction (mm), give or take a share of
    /// the stroke.
    #[inline(always)]
    pub fn is_plausible(&self, pressure_bar: f32, contraction_mm: f32, share: f32) -> bool {
        let place = (pressure_bar - self.start_bar) * self.rows_per_bar;
        // Below the first row the conversion answers 0, beyond the last one the rows end.
        let row = (place as usize).min(ROWS - 2);
        let (Some(below), Some(above)) = (self.rows.get(row), self.rows.get(row + 1)) else {
            return true;
        };
        let part = (place - row as f32).clamp(0.0, 1.0);
        let between = |from: f32, to: f32| from + part * (to - from);
        let (up, down) = (between(below.0, above.0), between(below.1, above.1));
        let margin = share * self.stroke_mm;
        contraction_mm >= up.min(down) - margin && contraction_mm <= up.max(down) + margin
    }
}
