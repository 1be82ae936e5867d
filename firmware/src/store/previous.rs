//! The layouts before the present one.
//!
//! What they read was written by boards that are not at hand any more. A test holds each to stored
//! bytes: should a part of one change, this becomes a frozen copy of what the part was, as that of
//! the controller is.

use model_core::extension::ExtensionParameters;
use model_core::pid::PidParameters;
use model_core::{ModelParameters, ObserverParameters};
use serde::Deserialize;
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

/// A controller of these layouts.
#[derive(Deserialize)]
struct Tracking {
    model: ModelParameters<f32, PLAYS, DEAD_ZONES>,
    extensions: ExtensionParameters<f32>,
    pid: PidParameters<f32>,
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
