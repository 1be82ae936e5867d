//! The path that vents beside the regulator: emergency stop and dump valve.

use wire::fault::times::STOP_TICKS;
use wire::{Fault, State};

use super::Control;

impl Control {
    /// Takes what the emergency stop reads back: whether its contacts are open. One sample may be a
    /// spark.
    pub fn hear_stop(&mut self, is_open: bool) {
        if self.stop.holds_for(STOP_TICKS, is_open) {
            self.report(Fault::EmergencyStop);
        }
    }

    /// Whether the dump valve behind the regulator is to be kept closed, tick by tick. It opens
    /// without that: at a fault, before a configuration, and with a program that stands still.
    pub fn keeps_dump_closed(&self) -> bool {
        !matches!(self.state, State::Off | State::Fault)
    }
}
