//! The scalings of a joint's sensors, by what they have been calibrated to, and what a board takes
//! of limits.

use core::f32::consts::PI;

use wire::joint::{JointCalibration, JointSettings};
use wire::registers::fields::excess_of_protection;
use wire::{Line, Protection, Refusal, Scaling};

use super::ANGLE;
use crate::ceilings;
use crate::scaling::{PRESSURE, calibrated};

/// Span of the standard sensors: 10 bar, half a turn.
const PRESSURE_SPAN_BAR: f32 = 10.0;
const ANGLE_SPAN_RAD: f32 = PI;

/// The scalings of a joint's sensors.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct JointScalings {
    /// Of both pressures, in bar.
    pub pressures: [Scaling; 2],
    /// Of the angle, in rad.
    pub angle: Scaling,
}

impl JointScalings {
    /// Of the standard sensors.
    pub const STANDARD: Self = Self { pressures: [PRESSURE; 2], angle: ANGLE };

    /// Those of a calibration. What counts as a broken wire stays.
    ///
    /// # Errors
    /// A line that no working sensor of its kind has, by name, value and limits.
    pub fn calibrated(calibration: &JointCalibration) -> Result<Self, Refusal> {
        let JointCalibration { pressures: [a, b], angle } = *calibration;
        let of = |name, standard: &Scaling, line: Option<Line>, span| {
            line.map_or(Ok(*standard), |line| calibrated(name, standard, line, span))
        };
        Ok(Self {
            pressures: [
                of("pressure a", &PRESSURE, a, PRESSURE_SPAN_BAR)?,
                of("pressure b", &PRESSURE, b, PRESSURE_SPAN_BAR)?,
            ],
            angle: of("angle", &ANGLE, angle, ANGLE_SPAN_RAD)?,
        })
    }
}

/// Looks at settings before they are taken. `has_muscles`: whether there is more than a simulation
/// behind the board, which has no ceilings.
///
/// # Errors
/// The first limit or line that cannot be, by name, value and limits.
pub fn checked(settings: &JointSettings, has_muscles: bool) -> Result<(Protection, JointScalings), Refusal> {
    let protection = checked_limits(&settings.protection, has_muscles)?;
    Ok((protection, JointScalings::calibrated(&settings.calibration)?))
}

/// The same of the limits alone.
///
/// # Errors
/// The first limit that cannot be, by name, value and limits.
pub fn checked_limits(protection: &Protection, has_muscles: bool) -> Result<Protection, Refusal> {
    let protection = protection.checked()?;
    if has_muscles {
        ceilings::refused(excess_of_protection(&protection))?;
    }
    Ok(protection)
}
