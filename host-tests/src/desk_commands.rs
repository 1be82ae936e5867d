//! The commands of the bench against a board on a desk, in a directory of their own.

use std::ops::Deref;

use serde_json::Value;
use wire::Protection;
use wire::image::Linked;
use wire::registers::UNIT;

use crate::commands::Commands;
use crate::desk::Desk;
use fleet::board::Board;
use fleet::line::Way;

/// How much faster time passes there.
const PACE: f64 = 5.0;

/// A board on a desk, with a directory for `mgpi`.
#[derive(Debug)]
pub struct DeskBench {
    /// Its boards run until it is dropped.
    _desk: Desk,
    commands: Commands,
}

impl DeskBench {
    /// A board whose bus is sound, and the paper's model as `paper.toml`.
    pub fn new() -> Self {
        Self::disturbed(|_, bytes| bytes)
    }

    /// The same, on a bus whose bytes `disturb` may change.
    ///
    /// # Panics
    /// There is no directory for it, or no model.
    pub fn disturbed(disturb: impl FnMut(Way, Vec<u8>) -> Vec<u8> + Send + 'static) -> Self {
        Self::at(Desk::new(PACE, disturb))
    }

    /// Boards of these numbers on one line.
    ///
    /// # Panics
    /// There is no directory for it, or no model.
    pub fn line(units: &[u8]) -> Self {
        Self::at(Desk::line(PACE, units, |_, bytes| bytes))
    }

    /// A board that takes images; the one that it runs has this head.
    ///
    /// # Panics
    /// There is no directory for it, or no model.
    pub fn with_images(
        linked: Linked,
        disturb: impl FnMut(Way, Vec<u8>) -> Vec<u8> + Send + 'static,
    ) -> Self {
        Self::at(Desk::of(
            PACE,
            move || vec![Board::of_number(UNIT, Protection::SIMULATED).with_images(&linked)],
            disturb,
        ))
    }

    fn at(desk: Desk) -> Self {
        let commands = Commands::at(desk.port());
        let model = concat!(env!("CARGO_MANIFEST_DIR"), "/../examples/paper-tables-1-2.toml");
        std::fs::copy(model, commands.path("paper.toml")).expect("the paper's model");
        Self { _desk: desk, commands }
    }

    /// What `mgpi status` says, for programs.
    ///
    /// # Panics
    /// It says nothing.
    pub fn status(&self) -> Value {
        serde_json::from_str(&self.succeeds("status --json")).expect("JSON")
    }
}

impl Deref for DeskBench {
    type Target = Commands;

    fn deref(&self) -> &Commands {
        &self.commands
    }
}

impl Default for DeskBench {
    fn default() -> Self {
        Self::new()
    }
}
