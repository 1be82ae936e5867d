//! Does the pressure fall once the valve is vented?
//!
//! A converter, an amplifier or a regulator that is stuck is not vented by a code. So the measured
//! pressure is looked at: in each [`VENTING_TICKS`] it has to reach what counts as vented, or to
//! lose a fifth of what it was. A muscle that empties with a time constant of up to 1.3 s does.

use wire::fault::times::VENTING_TICKS;
use wire::{Fault, Protection, Scaling};

use crate::scaling::level;

/// What the codes are compared with. Unit: ADC code.
#[derive(Clone, Copy, Debug)]
pub struct Limits {
    /// That of no pressure.
    pub zero: u16,
    /// Up to this the muscle is vented.
    pub vented: u16,
}

impl Limits {
    /// The protection's limit in codes of a pressure.
    pub fn new(protection: &Protection, pressure: &Scaling) -> Self {
        Self { zero: level(pressure, 0.0), vented: level(pressure, protection.vented_bar) }
    }
}

/// What is remembered of the codes since a window began.
#[derive(Clone, Copy, Debug, Default)]
pub struct Venting {
    first: u16,
    /// A single sample that is wrong makes no fault: one too low ends it, one too high puts it off
    /// to the next window.
    lowest: u16,
    ticks: u16,
}

impl Venting {
    /// Takes the code of a tick.
    ///
    /// # Errors
    /// A window has ended, and the pressure has not fallen.
    #[inline(always)]
    pub fn take(&mut self, limits: &Limits, is_driven: bool, code: u16) -> Result<(), Fault> {
        if is_driven {
            self.ticks = 0;
            return Ok(());
        }
        if self.ticks == 0 {
            (self.first, self.lowest) = (code, code);
        }
        self.lowest = self.lowest.min(code);
        self.ticks += 1;
        if self.ticks < VENTING_TICKS {
            return Ok(());
        }
        self.ticks = 0;
        let above = |code: u16| u32::from(code.saturating_sub(limits.zero));
        let has_fallen = 5 * above(self.lowest) <= 4 * above(self.first);
        if self.lowest <= limits.vented || has_fallen { Ok(()) } else { Err(Fault::VentIneffective) }
    }
}
