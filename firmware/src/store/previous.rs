//! Layout 2, the one before the present: without the bus's parameters, a calibration and an
//! observer.
//!
//! What it reads was written by boards that are not at hand any more. A test holds it to stored
//! bytes: should a part of it change, this becomes a frozen copy of what the part was, as that of
//! the controller is.

use model_core::extension::ExtensionParameters;
use model_core::pid::PidParameters;
use model_core::{ModelParameters, ObserverParameters, TrackingParameters};
use serde::Deserialize;
use wire::{DEAD_ZONES, PLAYS, Protection};

use super::parameters::Parameters;

/// Number of the layout.
pub const LAYOUT: u16 = 2;

/// A set in layout 2.
#[derive(Deserialize)]
pub struct Previous {
    protection: Protection,
    tracking: Option<Tracking>,
}

/// A controller without an observer.
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

impl From<Previous> for Parameters {
    /// The same parameters, reached as a new board is; the observer is off, as it was.
    fn from(Previous { protection, tracking }: Previous) -> Self {
        let tracking = tracking.map(|tracking| {
            let Tracking { model, extensions, pid, command_min, command_max, slew_bar_per_s, period_s } =
                tracking;
            let observer = ObserverParameters::default();
            TrackingParameters {
                model,
                extensions,
                pid,
                observer,
                command_min,
                command_max,
                slew_bar_per_s,
                period_s,
            }
        });
        Self { protection, tracking, ..Self::FACTORY }
    }
}
