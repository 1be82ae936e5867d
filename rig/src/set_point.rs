//! What a regulator makes of its command before it moves any air: dead band, then the limits.

use crate::effects::Effects;
use crate::parameters::{SUPPLY_BAR, VALVE_RANGE_BAR};

/// How a valve ignores small changes of its command.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum DeadBand {
    /// A command nearer than the band to the last accepted one is ignored, any other accepted
    /// whole.
    Hold,
    /// The accepted command is dragged behind at half the band: play.
    Backlash,
}

/// The last command that was accepted, and the limits.
#[derive(Debug, Clone)]
pub(crate) struct SetPoint {
    dead_band: DeadBand,
    band_bar: f64,
    supply_bar: f64,
    accepted_bar: f64,
}

impl SetPoint {
    /// That of a vented regulator with what of `effects` is the command's.
    pub(crate) fn with(effects: &Effects, dead_band: DeadBand) -> Self {
        Self {
            dead_band,
            band_bar: effects.valve_deadband.as_ref().map_or(0.0, |hidden| hidden.band_bar),
            supply_bar: effects.supply_saturation.as_ref().map_or(SUPPLY_BAR, |hidden| hidden.supply_bar),
            accepted_bar: 0.0,
        }
    }

    /// The pressure that is aimed at under a command, bar.
    pub(crate) fn target_bar(&mut self, command_bar: f64) -> f64 {
        self.accepted_bar = match self.dead_band {
            DeadBand::Hold if (command_bar - self.accepted_bar).abs() < self.band_bar => self.accepted_bar,
            DeadBand::Hold => command_bar,
            DeadBand::Backlash => {
                let half_bar = 0.5 * self.band_bar;
                self.accepted_bar.clamp(command_bar - half_bar, command_bar + half_bar)
            }
        };
        self.accepted_bar.clamp(0.0, VALVE_RANGE_BAR.min(self.supply_bar))
    }

    /// Pressure of the supply, bar.
    pub(crate) fn supply_bar(&self) -> f64 {
        self.supply_bar
    }
}
