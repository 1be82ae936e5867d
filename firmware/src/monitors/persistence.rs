//! How long something has to last before it counts.

/// Ticks in a row in which a condition held.
#[derive(Clone, Copy, Debug, Default)]
pub struct InARow {
    ticks: u16,
}

impl InARow {
    /// Takes a tick; answers whether the condition has now held for `needed` ticks in a row.
    #[inline(always)]
    pub fn holds_for(&mut self, needed: u16, condition: bool) -> bool {
        self.ticks = if condition { self.ticks.saturating_add(1) } else { 0 };
        self.ticks >= needed
    }
}

/// The average of a code over some `2^SHIFT` ticks: a first-order filter in whole numbers.
#[derive(Clone, Copy, Debug, Default)]
pub struct Average<const SHIFT: u32> {
    /// 0 before the first code. Unit: code times `2^SHIFT`.
    sum: u32,
}

impl<const SHIFT: u32> Average<SHIFT> {
    /// Takes a code, answers the average. The first code counts as one that has lasted.
    #[inline(always)]
    pub fn of(&mut self, code: u16) -> u16 {
        let code = u32::from(code);
        self.sum = if self.sum == 0 { code << SHIFT } else { self.sum - (self.sum >> SHIFT) + code };
        (self.sum >> SHIFT) as u16
    }
}
