//! The control law as functions that are never inlined, so that what they cost can be counted in the images.

use model_core::cascade::CascadeParameters;
use model_core::envelope::{AnyEnvelope, Envelope, EnvelopeParameters, PiecewiseLinearParameters};
use model_core::extension::{
    CreepParameters, DeadbandForm, DriftParameters, PeriodicDisturbanceParameters, ProfileParameters,
    RateDependentThresholdsParameters, RateDependentWidthParameters, ScheduleParameters, Sites,
    SupplySaturationParameters, TransportDelayParameters, ValveDeadbandParameters, ValveLagParameters,
    WarmUpParameters,
};
use model_core::pid::PidParameters;
use model_core::tracking::{Command, Prepared};
use model_core::{
    ExtensionParameters, HysteresisState, InputError, InverseHysteresis, InverseModel, Measured, Mode,
    ModelParameters, ParameterError, Surroundings, TrackingParameters, TrackingState, paper,
};
use wire::{DEAD_ZONES, PLAYS};

use crate::order::BoardTracking;

/// The inverse model in the board's number type and capacity.
pub type BoardInverse = InverseModel<f32, PLAYS, DEAD_ZONES>;

/// The slew limit and the tick that are measured.
pub(crate) const MEASURED_SLEW_BAR_PER_S: f32 = 50.0;
pub(crate) const MEASURED_PERIOD_S: f32 = 1e-3;
/// Knots of the piecewise-linear envelope that is measured.
pub const MEASURED_KNOTS: usize = 8;

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
        slew_bar_per_s: MEASURED_SLEW_BAR_PER_S,
        period_s: MEASURED_PERIOD_S,
    })
}

/// The same with a piecewise-linear envelope.
///
/// # Errors
/// None in practice, see [`paper::mgpi`].
pub fn piecewise_parameters() -> Result<TrackingParameters<f32, PLAYS, DEAD_ZONES>, ParameterError> {
    let model = paper::mgpi()?.convert()?;
    let envelope = EnvelopeParameters::PiecewiseLinear(measured_knots(&model)?);
    Ok(TrackingParameters {
        model: ModelParameters::Cascade(CascadeParameters { envelope, ..model }),
        ..paper_parameters()?
    })
}

/// The piecewise-linear envelope that is measured: through [`MEASURED_KNOTS`] points of the model's own, evenly spaced over
/// its inputs. `K`: at least as many.
///
/// # Errors
/// None in practice: the model's envelope is valid.
pub fn measured_knots<const N: usize, const M: usize, const K: usize>(
    model: &CascadeParameters<f32, N, M>,
) -> Result<PiecewiseLinearParameters<f32, K>, ParameterError> {
    let own = AnyEnvelope::try_new(&model.envelope)?;
    let step = (model.input_max - model.input_min) / (MEASURED_KNOTS - 1) as f32;
    let mut knots = PiecewiseLinearParameters { inputs: heapless::Vec::new(), values: heapless::Vec::new() };
    for knot in 0..MEASURED_KNOTS {
        let input = model.input_min + step * knot as f32;
        // There is room.
        let _ = knots.inputs.push(input).and_then(|()| knots.values.push(own.value(input)));
    }
    Ok(knots)
}

/// The same with every extension, each about as strong as muscles and valves have it.
///
/// # Errors
/// None in practice, see [`paper::mgpi`].
pub fn extended_parameters() -> Result<TrackingParameters<f32, PLAYS, DEAD_ZONES>, ParameterError> {
    let profile = |values: [f32; 3]| ProfileParameters {
        knots: [10.0, 60.0, 110.0].into_iter().collect(),
        values: values.into_iter().collect(),
    };
    let extensions = ExtensionParameters {
        valve_deadband: Some(ValveDeadbandParameters { band: 0.02, form: DeadbandForm::Backlash }),
        supply_saturation: Some(SupplySaturationParameters { supply: 5.8 }),
        valve_lag: Some(ValveLagParameters::new(0.05)),
        transport_delay: Some(TransportDelayParameters { delay_s: 0.0155 }),
        load: Some(ScheduleParameters { reference: 20.0, offset: profile([0.01, 0.02, 0.04]) }),
        temperature: Some(ScheduleParameters { reference: 25.0, offset: profile([-0.01, 0.01, 0.02]) }),
        warm_up: Some(WarmUpParameters { travel: 1000.0, offset: profile([0.3, 0.2, 0.1]) }),
        viscous_lag: Some(profile([0.002, 0.003, 0.006])),
        inertia: Some(profile([2e-5, 3e-5, 2e-5])),
        rate_dependent_width: Some(RateDependentWidthParameters {
            radius: 0.1,
            exponent: 0.5,
            filter_s: 0.01,
            width: profile([0.05, 0.1, 0.2]),
        }),
        rate_dependent_thresholds: Some(RateDependentThresholdsParameters {
            exponent: 0.5,
            filter_s: 0.01,
            gain: profile([0.02, 0.03, 0.04]),
            pressure: None,
        }),
        creep: Some(CreepParameters {
            time_constants_s: [0.1, 1.0, 10.0, 100.0, 1000.0, 10_000.0].into_iter().collect(),
            fractions: [0.01, 0.02, 0.03, 0.03, 0.02, 0.01].into_iter().collect(),
        }),
        drift: Some(DriftParameters { rate_per_s: 0.01, compensated: true }),
        periodic_disturbance: Some(PeriodicDisturbanceParameters {
            amplitude: 0.5,
            frequency_hz: 3.0,
            phase_rad: 1.0,
            compensated: true,
        }),
        sites: Sites::default(),
    };
    Ok(TrackingParameters { extensions, ..paper_parameters()? })
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

/// The first half of a sample of the controller, which is the inverse of the extended model. Reference: mm.
///
/// # Errors
/// A value that is not finite; the state is then as it was.
#[inline(never)]
pub fn controller_prepare(
    tracking: &BoardTracking,
    state: &mut TrackingState<f32, PLAYS>,
    reference_mm: f32,
    surroundings: &Surroundings<f32>,
) -> Result<Prepared<f32>, InputError> {
    tracking.prepare(state, reference_mm, surroundings)
}

/// The second half: PID, slew and limits. Contraction: mm.
///
/// # Errors
/// The contraction is not finite; the last command is then as it was.
#[inline(never)]
pub fn controller_act(
    tracking: &BoardTracking,
    state: &mut TrackingState<f32, PLAYS>,
    mode: Mode,
    prepared: Prepared<f32>,
    contraction_mm: f32,
) -> Result<Command<f32>, InputError> {
    tracking.act(state, mode, prepared, contraction_mm)
}

/// One sample of the whole controller, both halves in one. Reference: mm.
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
