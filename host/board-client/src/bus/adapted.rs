//! What a board has learnt of its muscle.

use std::fmt;

use serde_json::{Value, json};
use wire::registers::Id;

use super::Board;
use super::client::BusError;

/// What was learnt, beside the board's model. Unit: mm.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Adapted {
    /// How much further the muscle contracts in the middle of its range.
    pub offset_mm: f64,
    /// By how much more at the upper end.
    pub gain_mm: f64,
    /// By how much more at both ends.
    pub bend_mm: f64,
    /// How much further on the way up than in the middle of the loop.
    pub width_mm: f64,
    /// By how much more so at the upper end.
    pub flare_mm: f64,
    /// In how many steps.
    pub steps: u32,
}

impl Adapted {
    /// Asks the board.
    ///
    /// # Errors
    /// No answer, or firmware that is older.
    pub fn read(board: &mut Board) -> Result<Self, BusError> {
        let block = board.read(Id::AdaptedOffset, Id::AdaptedSteps)?;
        Ok(Self {
            offset_mm: block.number(Id::AdaptedOffset),
            gain_mm: block.number(Id::AdaptedGain),
            bend_mm: block.number(Id::AdaptedBend),
            width_mm: block.number(Id::AdaptedWidth),
            flare_mm: block.number(Id::AdaptedFlare),
            steps: block.whole(Id::AdaptedSteps),
        })
    }
}

impl Adapted {
    /// For programs.
    pub fn to_json(&self) -> Value {
        let Self { offset_mm, gain_mm, bend_mm, width_mm, flare_mm, steps } = self;
        json!({
            "offset_mm": offset_mm, "gain_mm": gain_mm, "bend_mm": bend_mm, "width_mm": width_mm,
            "flare_mm": flare_mm, "steps": steps,
        })
    }
}

impl fmt::Display for Adapted {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { offset_mm, gain_mm, bend_mm, width_mm, flare_mm, steps } = self;
        write!(
            f,
            "offset {offset_mm:+.2} mm, gain {gain_mm:+.2} mm, bend {bend_mm:+.2} mm, width {width_mm:+.2} mm, \
             flare {flare_mm:+.2} mm, in {steps} steps"
        )
    }
}
