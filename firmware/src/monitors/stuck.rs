//! A sensor whose code stays where it is while the command moves.

use wire::Fault;
use wire::fault::times::STUCK_TICKS;

/// How far codes of a sensor that stays where it is may be apart: noise of a single conversion of
/// up to 2 codes (`pressure_noise_bar` tells), 0.7 of the mean of eight, 1 of the difference of two
/// means, four of which one tick in 15,000 exceeds.
const STILL_CODES: u16 = 4;

/// What is remembered of one sensor.
#[derive(Clone, Copy, Debug, Default)]
pub struct Stuck {
    /// Where it stays.
    code: u16,
    /// Since how many ticks.
    ticks: u16,
    /// The command's lowest and highest code since then.
    command: (u16, u16),
}

impl Stuck {
    /// Takes a code of the sensor and of the command; `moved`: how far the command has to move (DAC
    /// code).
    ///
    /// # Errors
    /// `fault`, when the sensor is stuck.
    #[inline(always)]
    pub fn take(&mut self, code: u16, command: u16, moved: u16, fault: Fault) -> Result<(), Fault> {
        if code.abs_diff(self.code) > STILL_CODES {
            *self = Self { code, ticks: 0, command: (command, command) };
            return Ok(());
        }
        self.ticks = self.ticks.saturating_add(1);
        let (low, high) = self.command;
        self.command = (low.min(command), high.max(command));
        let has_moved = self.command.1 - self.command.0 > moved;
        if self.ticks >= STUCK_TICKS && has_moved { Err(fault) } else { Ok(()) }
    }
}
