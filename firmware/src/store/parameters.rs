//! What a board with one muscle keeps.

use serde::{Deserialize, Serialize};
use wire::{BoardParameters, BusParameters, Configuration, Protection, Request, VERSION};

use super::sealed::Sealed;

/// A set of parameters, saved and loaded as a whole. Raw: validated each time that it is taken.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Parameters {
    /// Limits of the plant.
    pub protection: Protection,
    /// Model, gains and limits, as a host has configured them; none before that.
    pub tracking: Option<BoardParameters>,
    /// How the board is reached on its bus.
    pub bus: BusParameters,
    /// What the sensors have shown; none before that. A new model leaves it.
    pub calibration: Option<Sealed>,
}

impl Parameters {
    /// The set of a new board: no model, since one of another muscle would drive this one wrongly.
    pub const FACTORY: Self = Self {
        protection: Protection::STANDARD,
        tracking: None,
        bus: BusParameters::STANDARD,
        calibration: None,
    };

    /// What a host would ask a new board for over the link, to give it this set; the bus takes its
    /// own by itself.
    pub fn requests(&self) -> impl Iterator<Item = Request> {
        let configure = |tracking| Request::Configure(Configuration { version: VERSION, tracking });
        [Request::Protect(self.protection)].into_iter().chain(self.tracking.clone().map(configure))
    }

    /// The set after a request that the board has accepted; `None` if it leaves the set as it was.
    pub fn changed_by(&self, request: &Request) -> Option<Self> {
        match request {
            Request::Protect(protection) => Some(Self { protection: *protection, ..self.clone() }),
            Request::Configure(configuration) => {
                Some(Self { tracking: Some(configuration.tracking.clone()), ..*self })
            }
            _ => None,
        }
    }
}
