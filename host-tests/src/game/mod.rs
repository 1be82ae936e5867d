//! The sealed game: a cause is hidden in a plant, a diagnosis sees nothing but the recording, and its verdict
//! is held against what was hidden.
//!
//! [`zoo`] has plants, experiments and effects drawn whole by a seed; [`judged`] holds a verdict against the truth, and
//! [`table`] counts.
//!
//! The two old plants: [`case`] lists the games, [`finder`] is who is examined, [`score`] counts; [`gain`] holds what an extension gains against
//! what the parameters in [`hidden`] would. Two plants hide the same effects in different forms, so that whoever has learnt one
//! of them fails on the other. Right is the exact set of causes; `hysteresis_shape` does not count, since it is true of both
//! plants under any finite model.

pub mod case;
pub mod finder;
pub mod gain;
pub mod hidden;
pub mod judged;
pub mod score;
pub mod table;
pub mod zoo;

use std::time::Instant;

use rayon::prelude::*;
use rig::plant::Plant;
use rig::protocol::Protocol;
use rig::recording::{Row, record, write_recording};
use rig::sensor::Columns;

use case::Case;
use finder::Finder;
use score::Outcome;

/// Rows a second of the recordings. Unit: Hz.
const RATE_HZ: f64 = 100.0;

impl Case {
    /// The plant of this game.
    fn plant(&self) -> Plant {
        Plant::new(&self.setup())
    }

    /// What is recorded of it: 12,000 rows.
    pub fn recording(&self) -> Vec<Row> {
        record(&Protocol::rich(self.seed), &mut self.plant(), RATE_HZ).collect()
    }

    /// Plays this game.
    pub fn play(&self, finder: &impl Finder) -> Outcome {
        let mut csv = Vec::new();
        let written = write_recording(&mut csv, &[], self.recording().into_iter(), Columns::All);
        let start = Instant::now();
        let found = written.map_err(Into::into).and_then(|()| finder.find(&csv));
        let found = found.map_err(|error| format!("{error:#}"));
        Outcome::new(self.clone(), self.plant().truth(), found, start.elapsed())
    }
}

/// Plays all games side by side, telling `finished` after each.
pub fn play(cases: &[Case], finder: &impl Finder, finished: impl Fn(&Outcome) + Sync) -> Vec<Outcome> {
    let one = |case: &Case| {
        let outcome = case.play(finder);
        finished(&outcome);
        outcome
    };
    cases.par_iter().map(one).collect()
}
