//! How much a feedback may put on its feed-forward for good.

use wire::Fault;
use wire::fault::times::AUTHORITY_TICKS;

use super::persistence::InARow;

/// What is remembered.
#[derive(Clone, Copy, Debug, Default)]
pub struct Authority {
    beyond: InARow,
}

impl Authority {
    /// Takes a tick; `is_beyond`: whether the feedback asks for more than it may.
    ///
    /// # Errors
    /// It has done so for [`AUTHORITY_TICKS`]: feed-forward and measurement contradict each other.
    #[inline(always)]
    pub fn take(&mut self, is_beyond: bool) -> Result<(), Fault> {
        if self.beyond.holds_for(AUTHORITY_TICKS, is_beyond) { Err(Fault::Authority) } else { Ok(()) }
    }
}
