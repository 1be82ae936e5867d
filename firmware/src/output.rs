//! The last stage before the valve: soft start and slew, whatever the controller asks for.
//!
//! In whole numbers, so that nothing here can be other than a code. Venting is at once: no limit
//! applies to it.

use wire::{Protection, Scaling};

use crate::board::DacCode;
use crate::scaling::{COMMAND, VENT};

/// Fraction bits of the ceiling.
const FRACTION: u32 = 16;
/// The ceiling of a valve that is all open.
const HIGHEST: u32 = (COMMAND.code_max as u32) << FRACTION;

/// The limits. Both at least 1.
#[derive(Clone, Copy, Debug)]
pub struct Limits {
    /// Rise of the ceiling in a tick. Unit: DAC code times `2^FRACTION`.
    soft_start: u32,
    /// Largest change in a tick. Unit: DAC code.
    slew: u16,
}

impl Limits {
    /// The protection's limits, for ticks that are `period_s` apart and this scaling of the
    /// command.
    pub fn new(protection: &Protection, command: &Scaling, period_s: f32) -> Self {
        let codes = |bar_per_s: f32| bar_per_s * period_s * command.codes_per_unit;
        Self {
            soft_start: ((codes(protection.soft_start_bar_per_s) * (1_u32 << FRACTION) as f32) as u32)
                .clamp(1, HIGHEST),
            // One more than the whole codes: rounding alone is not to be limited.
            slew: (codes(protection.slew_bar_per_s) as u16).saturating_add(1),
        }
    }
}

/// What was put out.
#[derive(Clone, Copy, Debug, Default)]
pub struct Output {
    code: u16,
    ceiling: u32,
}

impl Output {
    /// A vented output.
    pub const fn vented() -> Self {
        Self { code: VENT.0, ceiling: 0 }
    }

    /// The code that is out.
    pub fn code(&self) -> DacCode {
        DacCode(self.code)
    }

    /// Goes towards a code, as far as the limits allow in a tick.
    #[inline(always)]
    pub fn drive(&mut self, limits: &Limits, asked: DacCode) -> DacCode {
        self.ceiling = (self.ceiling + limits.soft_start).min(HIGHEST);
        let highest = self.code.saturating_add(limits.slew).min((self.ceiling >> FRACTION) as u16);
        self.code = asked.0.max(self.code.saturating_sub(limits.slew)).min(highest);
        self.code()
    }

    /// Vents, at once.
    #[inline(always)]
    pub fn vent(&mut self) -> DacCode {
        *self = Self::vented();
        VENT
    }
}
