//! The layouts before the present one.
//!
//! What they read was written by boards that are not at hand any more. A test holds each to stored
//! bytes: should a part of one change, this becomes a frozen copy of what the part was, as that of
//! the controller is.

use model_core::extension::{
    CreepParameters, DriftParameters, ExtensionParameters, PeriodicDisturbanceParameters, ProfileParameters,
    RateDependentThresholdsParameters, RateDependentWidthParameters, ScheduleParameters, Sites,
    SupplySaturationParameters, TransportDelayParameters, ValveDeadbandParameters, ValveLagForm,
    ValveLagParameters, WarmUpParameters,
};
use model_core::pid::PidParameters;
use model_core::{ModelParameters, ObserverParameters};
use serde::{Deserialize, Deserializer};
use wire::{BoardParameters, BusParameters, Calibration, DEAD_ZONES, Inputs, Line, PLAYS, Protection};

use super::parameters::Parameters;
use super::sealed::Sealed;

/// Number of the layout without the bus's parameters and a calibration.
pub const WITHOUT_BUS: u16 = 2;
/// Number of the layout whose calibration has no checksum of its own.
pub const UNSEALED: u16 = 3;
/// Number of the layout whose sensors are all ratiometric.
pub const RATIOMETRIC: u16 = 4;
/// Number of the layout whose controller has no observer.
pub const UNOBSERVED: u16 = 5;

/// Number of the layout whose valves lag by one time constant each.
pub const FIRST_ORDER: u16 = 6;

/// The lag of a valve of these layouts: of the first order.
#[derive(Deserialize)]
struct Lag {
    time_constant_s: f32,
    lead_limit: f32,
}

/// What a muscle of these layouts does beside hysteresis.
#[derive(Deserialize)]
struct Extensions {
    valve_deadband: Option<ValveDeadbandParameters<f32>>,
    supply_saturation: Option<SupplySaturationParameters<f32>>,
    valve_lag: Option<Lag>,
    transport_delay: Option<TransportDelayParameters<f32>>,
    load: Option<ScheduleParameters<f32>>,
    temperature: Option<ScheduleParameters<f32>>,
    warm_up: Option<WarmUpParameters<f32>>,
    viscous_lag: Option<ProfileParameters<f32>>,
    inertia: Option<ProfileParameters<f32>>,
    rate_dependent_width: Option<RateDependentWidthParameters<f32>>,
    rate_dependent_thresholds: Option<RateDependentThresholdsParameters<f32>>,
    creep: Option<CreepParameters<f32>>,
    drift: Option<DriftParameters<f32>>,
    periodic_disturbance: Option<PeriodicDisturbanceParameters<f32>>,
    sites: Sites,
}

/// A controller of layouts 2 to 5.
#[derive(Deserialize)]
struct Tracking {
    model: ModelParameters<f32, PLAYS, DEAD_ZONES>,
    #[serde(deserialize_with = "extensions")]
    extensions: ExtensionParameters<f32>,
    pid: PidParameters<f32>,
    command_min: f32,
    command_max: f32,
    slew_bar_per_s: f32,
    period_s: f32,
}

/// A controller of layout 6.
#[derive(Deserialize)]
struct Observing {
    model: ModelParameters<f32, PLAYS, DEAD_ZONES>,
    #[serde(deserialize_with = "extensions")]
    extensions: ExtensionParameters<f32>,
    pid: PidParameters<f32>,
    observer: ObserverParameters<f32>,
    command_min: f32,
    command_max: f32,
    slew_bar_per_s: f32,
    period_s: f32,
}

/// A set in layout 2.
#[derive(Deserialize)]
pub struct WithoutBus {
    protection: Protection,
    tracking: Option<Tracking>,
}

/// A set in layout 3.
#[derive(Deserialize)]
pub struct Unsealed {
    protection: Protection,
    tracking: Option<Tracking>,
    bus: BusParameters,
    calibration: Option<Lines>,
}

/// A set in layout 4.
#[derive(Deserialize)]
pub struct Ratiometric {
    protection: Protection,
    tracking: Option<Tracking>,
    bus: BusParameters,
    /// Under the checksum of its lines.
    calibration: Option<(Lines, u32)>,
}

/// A set in layout 5.
#[derive(Deserialize)]
pub struct Unobserved {
    protection: Protection,
    tracking: Option<Tracking>,
    bus: BusParameters,
    calibration: Option<Sealed>,
}

/// A set in layout 6.
#[derive(Deserialize)]
pub struct OfFirstOrder {
    protection: Protection,
    tracking: Option<Observing>,
    bus: BusParameters,
    calibration: Option<Sealed>,
}

/// A calibration of layouts 3 and 4.
#[derive(Deserialize)]
struct Lines {
    pressure: Line,
    contraction: Line,
    supply: Line,
    command: Line,
    day: u32,
}

impl From<Lines> for Calibration {
    /// Of ratiometric sensors.
    fn from(Lines { pressure, contraction, supply, command, day }: Lines) -> Self {
        Self { pressure, contraction, supply, command, day, inputs: Inputs::STANDARD }
    }
}

/// Reads what a muscle of these layouts does beside hysteresis. Never inlined: it is long, and
/// every layout has it.
#[inline(never)]
fn extensions<'de, D: Deserializer<'de>>(bytes: D) -> Result<ExtensionParameters<f32>, D::Error> {
    let old = Extensions::deserialize(bytes)?;
    let first_order = |Lag { time_constant_s, lead_limit }| ValveLagParameters {
        time_constant_s,
        lead_limit,
        form: ValveLagForm::FirstOrder,
    };
    Ok(ExtensionParameters {
        valve_deadband: old.valve_deadband,
        supply_saturation: old.supply_saturation,
        valve_lag: old.valve_lag.map(first_order),
        transport_delay: old.transport_delay,
        load: old.load,
        temperature: old.temperature,
        warm_up: old.warm_up,
        viscous_lag: old.viscous_lag,
        inertia: old.inertia,
        rate_dependent_width: old.rate_dependent_width,
        rate_dependent_thresholds: old.rate_dependent_thresholds,
        creep: old.creep,
        drift: old.drift,
        periodic_disturbance: old.periodic_disturbance,
        sites: old.sites,
    })
}

impl From<Observing> for BoardParameters {
    fn from(tracking: Observing) -> Self {
        let Observing {
            model,
            extensions,
            pid,
            observer,
            command_min,
            command_max,
            slew_bar_per_s,
            period_s,
        } = tracking;
        Self { model, extensions, pid, observer, command_min, command_max, slew_bar_per_s, period_s }
    }
}

impl From<Tracking> for BoardParameters {
    /// The observer is off, as it was.
    fn from(tracking: Tracking) -> Self {
        let Tracking { model, extensions, pid, command_min, command_max, slew_bar_per_s, period_s } =
            tracking;
        let observer = ObserverParameters::default();
        Self { model, extensions, pid, observer, command_min, command_max, slew_bar_per_s, period_s }
    }
}

impl From<WithoutBus> for Parameters {
    /// The same parameters, reached as a new board is.
    fn from(WithoutBus { protection, tracking }: WithoutBus) -> Self {
        Self { protection, tracking: tracking.map(Tracking::into), ..Self::FACTORY }
    }
}

impl From<Unsealed> for Parameters {
    /// The same parameters. The record's checksum has just been right, so that the calibration is
    /// as it was written.
    fn from(Unsealed { protection, tracking, bus, calibration }: Unsealed) -> Self {
        let calibration = calibration.map(|lines| Sealed::new(lines.into()));
        Self { protection, tracking: tracking.map(Tracking::into), bus, calibration }
    }
}

impl From<Ratiometric> for Parameters {
    /// The same parameters; the lines stay under the checksum that was found with them.
    fn from(Ratiometric { protection, tracking, bus, calibration }: Ratiometric) -> Self {
        let calibration = calibration.map(|(lines, checksum)| Sealed::found(lines.into(), checksum));
        Self { protection, tracking: tracking.map(Tracking::into), bus, calibration }
    }
}

impl From<Unobserved> for Parameters {
    /// The same parameters.
    fn from(Unobserved { protection, tracking, bus, calibration }: Unobserved) -> Self {
        Self { protection, tracking: tracking.map(Tracking::into), bus, calibration }
    }
}

impl From<OfFirstOrder> for Parameters {
    /// The same parameters.
    fn from(OfFirstOrder { protection, tracking, bus, calibration }: OfFirstOrder) -> Self {
        Self { protection, tracking: tracking.map(Observing::into), bus, calibration }
    }
}
