//! Which samples of a recording are not scored, and why: one rule for all commands.

use serde_json::{Value, json};

use crate::drop_out::{self, DropOut};
use crate::history::UnknownPast;

/// Samples of a recording that are not scored, apart from those that are not valid.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct LeftOut {
    /// What the sensors did not measure.
    pub drop_outs: Vec<DropOut>,
    /// The first samples, where what came before them is not known.
    pub unknown_past: Option<UnknownPast>,
}

impl LeftOut {
    /// A sentence without its full stop for each kind that there is.
    pub fn in_words(&self) -> Vec<String> {
        let past = self.unknown_past.as_ref().map(UnknownPast::in_words);
        past.into_iter().chain(drop_out::in_words(&self.drop_outs)).collect()
    }

    /// The time that what came before is not known until. Unit: s.
    pub fn past_unknown_until_s(&self) -> Option<f64> {
        self.unknown_past.map(|past| past.until_s)
    }

    /// For programs.
    pub fn to_json(&self) -> Value {
        json!({
            "past_unknown_until_s": self.past_unknown_until_s(),
            "history_only_samples": self.unknown_past.map_or(0, |past| past.samples),
            "drop_outs": drop_out::to_json(&self.drop_outs),
        })
    }
}
