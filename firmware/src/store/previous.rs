//! Layout 1, the one before the present: tracking parameters alone, without limits of the plant.
//!
//! The struct is a frozen copy: what it reads was written by boards that are not at hand any more.
//! A test holds it to stored bytes.

use model_core::extension::ExtensionParameters;
use model_core::pid::PidParameters;
use model_core::{ModelParameters, TrackingParameters};
use serde::Deserialize;
use wire::{DEAD_ZONES, PLAYS};

use super::parameters::Parameters;

/// Number of the layout.
pub const LAYOUT: u16 = 1;

/// A set in layout 1.
#[derive(Deserialize)]
pub struct Previous {
    model: ModelParameters<f32, PLAYS, DEAD_ZONES>,
    pid: PidParameters<f32>,
    command_min: f32,
    command_max: f32,
    slew_bar_per_s: f32,
    period_s: f32,
}

impl From<Previous> for Parameters {
    /// The same parameters with the limits of a new board.
    fn from(previous: Previous) -> Self {
        let Previous { model, pid, command_min, command_max, slew_bar_per_s, period_s } = previous;
        let extensions = ExtensionParameters::default();
        let tracking =
            TrackingParameters { model, extensions, pid, command_min, command_max, slew_bar_per_s, period_s };
        Self { tracking: Some(tracking), ..Self::FACTORY }
    }
}
