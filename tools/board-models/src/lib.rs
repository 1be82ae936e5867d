//! What boards are measured and tested with: the paper's model with its gains, the same with a
//! piecewise-linear envelope and with every extension, and one model of each kind ([`family`]); and
//! a joint of two muscles ([`joint`]).

pub mod family;
pub mod joint;

use model_core::cascade::CascadeParameters;
use model_core::envelope::{AnyEnvelope, Envelope, EnvelopeParameters, KNOTS, PiecewiseLinearParameters};
use model_core::extension::{
    CreepParameters, DeadbandForm, DriftParameters, PeriodicDisturbanceParameters, ProfileParameters,
    RateDependentThresholdsParameters, RateDependentWidthParameters, ScheduleParameters, Sites,
    SupplySaturationParameters, TransportDelayParameters, ValveDeadbandParameters, ValveLagParameters,
    WarmUpParameters,
};
use model_core::pid::PidParameters;
use model_core::{ExtensionParameters, ModelParameters, ObserverParameters, ParameterError, paper};
use wire::{BoardParameters, DEAD_ZONES, PLAYS};

/// Slew limit of the command. Unit: bar/s.
const MEASURED_SLEW_BAR_PER_S: f32 = 50.0;
/// The board's tick. Unit: s.
const MEASURED_PERIOD_S: f32 = 1e-3;
/// Knots of the piecewise-linear envelope that is measured.
const MEASURED_KNOTS: usize = 8;

/// The paper's model and gains on a proportional valve, at the board's tick: what the law is
/// measured with.
///
/// # Errors
/// None in practice, see [`paper::mgpi`].
pub fn paper_parameters() -> Result<BoardParameters, ParameterError> {
    let model = paper::mgpi()?.convert()?;
    Ok(BoardParameters {
        command_min: model.input_min,
        command_max: model.input_max,
        model: ModelParameters::Cascade(model),
        extensions: ExtensionParameters::default(),
        pid: PidParameters::paper(),
        observer: ObserverParameters::default(),
        slew_bar_per_s: MEASURED_SLEW_BAR_PER_S,
        period_s: MEASURED_PERIOD_S,
    })
}

/// The same with a piecewise-linear envelope.
///
/// # Errors
/// None in practice, see [`paper::mgpi`].
pub fn piecewise_parameters() -> Result<BoardParameters, ParameterError> {
    let model = paper::mgpi()?.convert()?;
    let envelope = EnvelopeParameters::PiecewiseLinear(measured_knots(&model)?);
    Ok(BoardParameters {
        model: ModelParameters::Cascade(CascadeParameters { envelope, ..model }),
        ..paper_parameters()?
    })
}

/// The same with every extension, each about as strong as muscles and valves have it.
///
/// # Errors
/// None in practice, see [`paper::mgpi`].
pub fn extended_parameters() -> Result<BoardParameters, ParameterError> {
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
    Ok(BoardParameters { extensions, ..paper_parameters()? })
}

/// The piecewise-linear envelope that is measured: through [`MEASURED_KNOTS`] points of the model's
/// own, evenly spaced over its inputs.
fn measured_knots(
    model: &CascadeParameters<f32, PLAYS, DEAD_ZONES>,
) -> Result<PiecewiseLinearParameters<f32, KNOTS>, ParameterError> {
    let own = AnyEnvelope::try_new(&model.envelope)?;
    let step = (model.input_max - model.input_min) / (MEASURED_KNOTS - 1) as f32;
    let inputs = (0..MEASURED_KNOTS).map(|knot| model.input_min + step * knot as f32);
    let values = inputs.clone().map(|input| own.value(input)).collect();
    Ok(PiecewiseLinearParameters { inputs: inputs.collect(), values })
}
