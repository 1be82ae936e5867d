//! Does the pressure follow the command? It may lag, by seconds for small differences and by
//! fractions of one for large ones: what counts is the integral of what they differ beyond a band.

use wire::Fault;

/// The limits.
#[derive(Clone, Copy, Debug)]
pub struct Limits {
    /// Unit: bar.
    pub band_bar: f32,
    /// Unit: bar times tick.
    pub limit: f32,
}

/// A pressure that has moved by less since the difference began does not answer at all. Unit: bar.
const STILL_BAR: f32 = 0.1;

/// What is remembered.
#[derive(Clone, Copy, Debug, Default)]
pub struct Following {
    /// Unit: bar times tick.
    excess: f32,
    /// The pressure when the excess began. Unit: bar.
    began_bar: f32,
}

impl Following {
    /// Takes a tick: command and pressure in bar.
    ///
    /// # Errors
    /// The pressure does not follow: it stays too high, or does not move, since the valve is stuck;
    /// or it is too low, since air is lost.
    #[inline(always)]
    pub fn take(&mut self, limits: &Limits, command_bar: f32, pressure_bar: f32) -> Result<(), Fault> {
        let missing_bar = command_bar - pressure_bar;
        let excess = self.excess + missing_bar.abs() - limits.band_bar;
        if excess > 0.0 {
            if self.excess == 0.0 {
                self.began_bar = pressure_bar;
            }
            self.excess = excess;
        } else {
            self.excess = 0.0;
        }
        if self.excess <= limits.limit {
            return Ok(());
        }
        let is_still = (pressure_bar - self.began_bar).abs() < STILL_BAR;
        Err(if missing_bar > 0.0 && !is_still { Fault::Leak } else { Fault::ValveStuck })
    }
}
