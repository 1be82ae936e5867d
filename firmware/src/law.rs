//! The control law as two functions that are never inlined, so that what they cost can be counted in the images.

use model_core::cascade::CascadeParameters;
use model_core::envelope::{AnyEnvelope, Envelope, EnvelopeParameters, PiecewiseLinearParameters};
use model_core::pid::PidParameters;
use model_core::tracking::Command;
use model_core::{
    ExtensionParameters, HysteresisState, InputError, InverseHysteresis, InverseModel, Measured, Mode,
    ModelParameters, ParameterError, TrackingParameters, TrackingState, paper,
};
use wire::{DEAD_ZONES, PLAYS};

use crate::order::BoardTracking;

/// The inverse model in the board's number type and capacity.
pub type BoardInverse = InverseModel<f32, PLAYS, DEAD_ZONES>;

/// Knots of the piecewise-linear envelope that is measured.
const MEASURED_KNOTS: u8 = 16;

/// The paper's model and gains on a proportional valve, at the board's tick: what the law is measured with.
///
/// # Errors
/// None in practice, see [`paper::mgpi`].
pub fn paper_parameters() -> Result<TrackingParameters<f32, PLAYS, DEAD_ZONES>, ParameterError> {
    let model = paper::mgpi()?.convert()?;
    Ok(TrackingParameters {
        command_min: model.input_min,
        command_max: model.input_max,
        model: ModelParameters::Cascade(model),
        extensions: ExtensionParameters::default(),
        pid: PidParameters::paper(),
        slew_bar_per_s: 50.0,
        period_s: 1e-3,
    })
}

/// The same with a piecewise-linear envelope, through points of the tabled one, evenly spaced over its inputs.
///
/// # Errors
/// None in practice, see [`paper::mgpi`].
pub fn piecewise_parameters() -> Result<TrackingParameters<f32, PLAYS, DEAD_ZONES>, ParameterError> {
    let model = paper::mgpi()?.convert()?;
    let tabled = AnyEnvelope::try_new(&model.envelope)?;
    let step = (model.input_max - model.input_min) / f32::from(MEASURED_KNOTS - 1);
    let mut knots = PiecewiseLinearParameters { inputs: heapless::Vec::new(), values: heapless::Vec::new() };
    for knot in 0..MEASURED_KNOTS {
        let input = model.input_min + step * f32::from(knot);
        // There is room for more.
        let _ = knots.inputs.push(input).and_then(|()| knots.values.push(tabled.value(input)));
    }
    let envelope = EnvelopeParameters::PiecewiseLinear(knots);
    Ok(TrackingParameters {
        model: ModelParameters::Cascade(CascadeParameters { envelope, ..model }),
        ..paper_parameters()?
    })
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

/// One sample of the whole controller: inverse of the extended model, PID, slew and limits. Reference: mm.
///
/// # Errors
/// A value that is not finite; the state, and so the last command, is then as it was.
#[inline(never)]
pub fn controller_step(
    tracking: &BoardTracking,
    state: &mut TrackingState<f32, PLAYS>,
    mode: Mode,
    reference_mm: f32,
    measured: Measured<f32>,
) -> Result<Command<f32>, InputError> {
    tracking.step(state, mode, reference_mm, measured)
}
