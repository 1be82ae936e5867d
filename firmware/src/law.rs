//! The control law as functions that are never inlined, so that what they cost can be counted in the images.

use model_core::envelope::{Envelope, PiecewiseLinearParameters, TanhEnvelope};
use model_core::pid::PidParameters;
use model_core::tracking::Command;
use model_core::{
    HysteresisState, InputError, InverseHysteresis, InverseMgpi, Invertible, MgpiParameters, Mode,
    ParameterError, PiecewiseMgpi, Range, TrackingParameters, TrackingState, paper,
};
use wire::{DEAD_ZONES, PLAYS};

use crate::order::BoardTracking;

/// The inverse model in the board's number type and capacity.
pub type BoardInverse = InverseMgpi<f32, PLAYS, DEAD_ZONES>;

/// Knots of the piecewise-linear envelope that is measured.
const KNOTS: usize = 16;

type PiecewiseModel = PiecewiseMgpi<f32, PLAYS, DEAD_ZONES, KNOTS>;
/// The inverse of a model with a piecewise-linear envelope.
pub type PiecewiseInverse = <PiecewiseModel as Invertible<f32, PLAYS>>::Inverse;

/// The paper's model and gains on a proportional valve, at the board's tick: what the law is measured with.
///
/// # Errors
/// None in practice, see [`paper::mgpi`].
pub fn paper_parameters() -> Result<TrackingParameters<f32, PLAYS, DEAD_ZONES>, ParameterError> {
    let model = paper::mgpi()?.convert()?;
    Ok(TrackingParameters {
        command_min: model.input_min,
        command_max: model.input_max,
        model,
        pid: PidParameters::paper(),
        slew_bar_per_s: 50.0,
        period_s: 1e-3,
    })
}

/// The inverse of a model whose envelope goes through points of the given one's, evenly spaced over its inputs.
///
/// # Errors
/// No such inverse.
pub fn piecewise_inverse(
    model: &MgpiParameters<f32, PLAYS, DEAD_ZONES>,
) -> Result<PiecewiseInverse, ParameterError> {
    let tanh = TanhEnvelope::try_new(model.envelope)?;
    let input_range = Range::try_new(model.input_min, model.input_max, "input range", "bar")?;
    let step = (model.input_max - model.input_min) / (KNOTS - 1) as f32;
    let mut envelope =
        PiecewiseLinearParameters { inputs: heapless::Vec::new(), values: heapless::Vec::new() };
    for knot in 0..KNOTS {
        let input = model.input_min + step * knot as f32;
        // As many as there is room for.
        let _ = envelope.inputs.push(input).and_then(|()| envelope.values.push(tanh.value(input)));
    }
    PiecewiseModel::try_new(&envelope, &model.plays, &model.dead_zones, input_range)?.inverse()
}

/// One sample of the inverse model alone. Reference: mm; result: bar.
///
/// # Errors
/// The reference is not finite; the state is then as it was.
#[inline(never)]
pub fn inverse_step(
    inverse: &BoardInverse,
    state: &mut HysteresisState<f32, PLAYS>,
    reference_mm: f32,
) -> Result<f32, InputError> {
    inverse.step(state, reference_mm)
}

/// [`inverse_step`] with a piecewise-linear envelope.
///
/// # Errors
/// The reference is not finite; the state is then as it was.
#[inline(never)]
pub fn piecewise_inverse_step(
    inverse: &PiecewiseInverse,
    state: &mut HysteresisState<f32, PLAYS>,
    reference_mm: f32,
) -> Result<f32, InputError> {
    inverse.step(state, reference_mm)
}

/// One sample of the whole controller: inverse model, PID, slew and limits. Reference and contraction: mm.
///
/// # Errors
/// Reference or contraction not finite; the state, and so the last command, is then as it was.
#[inline(never)]
pub fn controller_step(
    tracking: &BoardTracking,
    state: &mut TrackingState<f32, PLAYS>,
    mode: Mode,
    reference_mm: f32,
    contraction_mm: f32,
) -> Result<Command<f32>, InputError> {
    tracking.step(state, mode, reference_mm, contraction_mm)
}
