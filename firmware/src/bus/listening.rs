//! By which parameters the board listens: its own, or where nobody is heard by them, those of a new
//! board in turns.
//!
//! A rate or parity that no master of the line has would make a board unreachable for ever. So
//! behind each start, and behind each change, it waits for a whole frame, whoever it is for; where
//! none comes it tries the line of a new board, then its own again, [`SILENT_S`] each. The first
//! whole frame settles it.

use wire::BusParameters;
use wire::registers::BusListens;

/// How long it listens by the same parameters while nobody is heard. Unit: s.
pub const SILENT_S: u32 = 10;

/// Its parameters, and which of them are in use.
#[derive(Debug)]
pub struct Listening {
    own: BusParameters,
    in_use: BusParameters,
    /// Whether a whole frame has come since the last change.
    is_heard: bool,
    /// When the parameters in use were taken.
    since: u32,
}

impl Listening {
    /// By the standard, until [`Listening::begin`].
    pub const fn new() -> Self {
        Self { own: BusParameters::STANDARD, in_use: BusParameters::STANDARD, is_heard: false, since: 0 }
    }

    /// Those in use.
    pub const fn in_use(&self) -> &BusParameters {
        &self.in_use
    }

    /// Takes parameters; such as no board has are those of a new one.
    pub fn begin(&mut self, kept: &BusParameters, moment: u32) {
        self.own = if kept.is_valid() { *kept } else { BusParameters::STANDARD };
        (self.in_use, self.is_heard, self.since) = (self.own, false, moment);
    }

    /// A whole frame has come.
    pub fn hear(&mut self) {
        self.is_heard = true;
    }

    /// Tries the others, where nobody is heard for `patience`.
    pub fn look(&mut self, patience: u32, moment: u32) {
        if !self.is_heard && moment.wrapping_sub(self.since) >= patience {
            let standard = self.own.on_standard_line();
            self.in_use = if self.in_use == self.own { standard } else { self.own };
            self.since = moment;
        }
    }

    /// What a host is told, beside what is kept now.
    pub fn told(&self, kept: &BusParameters) -> BusListens {
        if self.in_use == *kept {
            BusListens::Stored
        } else if self.in_use == self.own {
            BusListens::Former
        } else {
            BusListens::Standard
        }
    }
}
