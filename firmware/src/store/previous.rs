//! The layouts before the present one.
//!
//! What they read was written by boards that are not at hand any more. A test holds each to stored
//! bytes: should a part of one change, this becomes a frozen copy of what the part was.

use serde::Deserialize;
use wire::{BoardParameters, BusParameters, Calibration, Inputs, Line, Protection};

use super::parameters::Parameters;
use super::sealed::Sealed;

/// Number of the layout without the bus's parameters and a calibration.
pub const WITHOUT_BUS: u16 = 2;
/// Number of the layout whose calibration has no checksum of its own.
pub const UNSEALED: u16 = 3;
/// Number of the layout whose sensors are all ratiometric.
pub const RATIOMETRIC: u16 = 4;

/// A set in layout 2.
#[derive(Deserialize)]
pub struct WithoutBus {
    protection: Protection,
    tracking: Option<BoardParameters>,
}

/// A set in layout 3.
#[derive(Deserialize)]
pub struct Unsealed {
    protection: Protection,
    tracking: Option<BoardParameters>,
    bus: BusParameters,
    calibration: Option<Lines>,
}

/// A set in layout 4.
#[derive(Deserialize)]
pub struct Ratiometric {
    protection: Protection,
    tracking: Option<BoardParameters>,
    bus: BusParameters,
    /// Under the checksum of its lines.
    calibration: Option<(Lines, u32)>,
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

impl From<WithoutBus> for Parameters {
    /// The same parameters, reached as a new board is.
    fn from(WithoutBus { protection, tracking }: WithoutBus) -> Self {
        Self { protection, tracking, ..Self::FACTORY }
    }
}

impl From<Unsealed> for Parameters {
    /// The same parameters. The record's checksum has just been right, so that the calibration is
    /// as it was written.
    fn from(Unsealed { protection, tracking, bus, calibration }: Unsealed) -> Self {
        Self { protection, tracking, bus, calibration: calibration.map(|lines| Sealed::new(lines.into())) }
    }
}

impl From<Ratiometric> for Parameters {
    /// The same parameters; the lines stay under the checksum that was found with them.
    fn from(Ratiometric { protection, tracking, bus, calibration }: Ratiometric) -> Self {
        let calibration = calibration.map(|(lines, checksum)| Sealed::found(lines.into(), checksum));
        Self { protection, tracking, bus, calibration }
    }
}
