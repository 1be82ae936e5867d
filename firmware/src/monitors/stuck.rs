//! A sensor whose code stays where it is while all moves that moves what it measures.

use core::ops::Sub;

use wire::fault::times::STUCK_TICKS;

/// How far codes of a sensor that stays where it is may be apart: noise of a single conversion of
/// up to 2 codes (`pressure_noise_bar` tells), 0.7 of the mean of eight, 1 of the difference of two
/// means, four of which one tick in 15,000 exceeds.
const STILL_CODES: u16 = 4;

/// What is remembered of one sensor, and of `N` quantities that move what it measures: one command,
/// or several of which each has to have moved.
#[derive(Clone, Copy, Debug)]
pub struct Stuck<Q, const N: usize> {
    /// Where it stays.
    code: u16,
    /// Since how many ticks.
    ticks: u16,
    /// The lowest and the highest of each quantity since then.
    moving: [(Q, Q); N],
}

impl<Q: Copy + Default, const N: usize> Default for Stuck<Q, N> {
    fn default() -> Self {
        Self { code: 0, ticks: 0, moving: [(Q::default(), Q::default()); N] }
    }
}

impl<Q: Copy + PartialOrd + Sub<Output = Q>, const N: usize> Stuck<Q, N> {
    /// Takes a code of the sensor and the quantities; `moved`: how far each of them has to move.
    ///
    /// # Errors
    /// `fault`, when the sensor is stuck.
    #[inline(always)]
    pub fn take<F>(&mut self, code: u16, moving: [Q; N], moved: [Q; N], fault: F) -> Result<(), F> {
        if code.abs_diff(self.code) > STILL_CODES {
            *self = Self { code, ticks: 0, moving: moving.map(|quantity| (quantity, quantity)) };
            return Ok(());
        }
        self.ticks = self.ticks.saturating_add(1);
        let mut have_moved = true;
        for ((ends, quantity), moved) in self.moving.iter_mut().zip(moving).zip(moved) {
            let (low, high) = *ends;
            *ends =
                (if quantity < low { quantity } else { low }, if quantity > high { quantity } else { high });
            have_moved = have_moved && ends.1 - ends.0 > moved;
        }
        if self.ticks >= STUCK_TICKS && have_moved { Err(fault) } else { Ok(()) }
    }
}
