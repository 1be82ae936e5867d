//! What a board keeps.

use model_core::TrackingParameters;
use serde::{Deserialize, Serialize};
use wire::{Configuration, DEAD_ZONES, PLAYS, Refusal, Request, VERSION};

use crate::order::{Order, prepare};

/// A set of parameters, saved and loaded as a whole.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Parameters {
    /// How the board behaves.
    pub settings: Settings,
    /// Model, gains and limits, as a host has configured them; none before that. Raw: validated each time that they are
    /// installed.
    pub tracking: Option<TrackingParameters<f32, PLAYS, DEAD_ZONES>>,
}

/// How a board behaves, whatever muscle it drives.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Settings {
    /// Address on the bus, 1 to 247 (Modbus).
    pub bus_address: u8,
    /// How long the bus may be silent while the valve is driven; 0: for ever. Unit: ms.
    pub silence_ms: u16,
    /// Whether a stored model that is not valid leaves the feedback to track alone; else the board stays off.
    pub feedback_without_model: bool,
}

impl Settings {
    /// Those of a new board.
    pub const FACTORY: Self = Self { bus_address: 1, silence_ms: 1_000, feedback_without_model: false };
}

impl Parameters {
    /// The set of a new board: no model, since one of another muscle would drive this one wrongly.
    pub const FACTORY: Self = Self { settings: Settings::FACTORY, tracking: None };

    /// The order that installs the stored model, gains and limits, if there are any.
    ///
    /// # Errors
    /// They are not valid, see [`prepare`].
    pub fn install(&self) -> Option<Result<Order, Refusal>> {
        let tracking = self.tracking.clone()?;
        Some(prepare(Request::Configure(Configuration { version: VERSION, tracking })))
    }
}
