//! What the board of a joint is set to beside its model: the limits of the plant, and the lines of
//! its sensors.
//!
//! The board keeps them without power; a new one has the standard ones.

use serde::{Deserialize, Serialize};

use crate::registers::Id;
use crate::{Line, Protection};

/// Limits and lines, taken as a whole or not at all.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct JointSettings {
    /// Limits of the plant, both muscles' alike: those of [`LIMITS`] count.
    pub protection: Protection,
    /// Of the sensors.
    pub calibration: JointCalibration,
}

/// The lines of a joint's sensors; none: that of the standard sensor.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct JointCalibration {
    /// ADC code of either pressure in bar, of the muscle that turns the joint to larger angles
    /// first.
    pub pressures: [Option<Line>; 2],
    /// ADC code of the angle in rad.
    pub angle: Option<Line>,
}

/// The limits that count at a joint, by the registers that they are on a board with one muscle,
/// with the same ranges. Those that are not here are of a contraction, or of a self-test that a
/// joint has none of.
pub const LIMITS: [Id; 13] = [
    Id::VentedBar,
    Id::OverpressureHard,
    Id::OverpressureSoft,
    Id::SupplyMin,
    Id::PressureJump,
    Id::StuckCommand,
    Id::FollowingBand,
    Id::FollowingLimit,
    Id::Authority,
    Id::BusSilent,
    Id::SoftStart,
    Id::Slew,
    Id::TemperatureMax,
];
