//! One analogue sensor: from its raw codes to codes that can be used, or to a fault.
//!
//! A code outside the plausible ones (open wire, short) or a jump that nothing physical makes
//! (interference) is *bridged*: the last good code stands for it. Bridging ends in a fault: after
//! [`BAD_IN_A_ROW`] implausible codes in a row, or when jumps come too close together.

use wire::fault::times::{BAD_IN_A_ROW, JUMPS_IN_A_ROW};
use wire::{Fault, Scaling};

use super::persistence::InARow;

/// What a jump puts into a bucket that loses 1 in every tick without one.
const JUMP_WEIGHT: u16 = 16;
/// More than this in the bucket is a fault: five jumps in a row, or one in fewer than 16 ticks for
/// long.
const JUMP_LIMIT: u16 = (JUMPS_IN_A_ROW - 1) * JUMP_WEIGHT;

/// What tells a good code from a bad one.
#[derive(Clone, Copy, Debug)]
pub struct Limits {
    /// Its plausible codes.
    pub scaling: Scaling,
    /// Largest credible change in a tick. Unit: ADC code.
    pub jump: u16,
    /// What implausible and jumping codes are.
    pub faults: [Fault; 2],
}

/// What is remembered of the codes.
#[derive(Clone, Copy, Debug, Default)]
pub struct Sensor {
    /// The last good code; none before the first.
    code: Option<u16>,
    implausible: InARow,
    jumps: u16,
    /// Codes that were bridged.
    pub bridged: u32,
}

impl Sensor {
    /// Takes the code of a tick; answers the code to use.
    ///
    /// # Errors
    /// The code cannot be trusted any more.
    #[inline(always)]
    pub fn take(&mut self, limits: &Limits, code: u16) -> Result<u16, Fault> {
        let [implausible, jumping] = limits.faults;
        let is_plausible = limits.scaling.is_plausible(code);
        if self.implausible.holds_for(BAD_IN_A_ROW, !is_plausible) {
            return Err(implausible);
        }
        let last = self.code.unwrap_or(if is_plausible { code } else { limits.scaling.code(0.0) });
        let jumps = is_plausible && code.abs_diff(last) > limits.jump;
        self.jumps = if jumps { self.jumps + JUMP_WEIGHT } else { self.jumps.saturating_sub(1) };
        if self.jumps > JUMP_LIMIT {
            self.jumps = 0;
            return Err(jumping);
        }
        if !is_plausible || jumps {
            self.bridged = self.bridged.wrapping_add(1);
            return Ok(last);
        }
        self.code = Some(code);
        Ok(code)
    }

    /// Forgets what it has of the past.
    pub fn restart(&mut self) {
        *self = Self { bridged: self.bridged, ..Self::default() };
    }
}
