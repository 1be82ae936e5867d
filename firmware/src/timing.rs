//! How long ticks take, measured in every one of them.

use wire::fault::times::LATE_IN_A_ROW;

use crate::monitors::persistence::InARow;

/// The end of a tick, as its clock tells.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct TickEnd {
    /// From the moment that it was due. Unit: core clock cycle.
    pub elapsed_cycles: u32,
    /// Whether the next one is due already.
    pub is_overrun: bool,
}

/// What was measured.
#[derive(Clone, Copy, Debug, Default)]
pub struct Timing {
    /// Longest. Unit: core clock cycle.
    pub worst_cycles: u32,
    /// Mean of the last some 256. Unit: 1/256 core clock cycle.
    mean: u32,
    /// Ticks that found the one before unfinished.
    pub overruns: u32,
    /// Ticks that ended after their deadline.
    pub late: u32,
    in_a_row: InARow,
}

impl Timing {
    /// Takes a tick, whose deadline is in cycles too; answers whether it is one too many that ended
    /// late.
    pub fn take(&mut self, end: TickEnd, deadline_cycles: u32) -> bool {
        let TickEnd { elapsed_cycles, is_overrun } = end;
        self.worst_cycles = self.worst_cycles.max(elapsed_cycles);
        self.mean = self.mean - (self.mean >> 8) + elapsed_cycles;
        let is_late = is_overrun || elapsed_cycles > deadline_cycles;
        self.overruns = self.overruns.wrapping_add(u32::from(is_overrun));
        self.late = self.late.wrapping_add(u32::from(is_late));
        self.in_a_row.holds_for(LATE_IN_A_ROW, is_late)
    }

    /// Mean of the last some 256. Unit: core clock cycle.
    pub fn mean_cycles(&self) -> u32 {
        self.mean >> 8
    }
}
