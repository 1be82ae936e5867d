//! What a model is worth: its error as a share of the stroke, in a word, and what limits it.
//!
//! # Design
//! | file | what it does |
//! |---|---|
//! | `mod` | the error in percent of stroke, and the word for it |
//! | `limit` | what limits a model, found where it is identified and kept in the model file |
//! | `shape` | the output over the input, by direction: whether it rises, falls, turns, or leads |
//!
//! The error is the larger of that on held-out samples, if there are any, and that on the samples
//! of the fit: a model has to do on both.

mod limit;
mod shape;

use std::fmt;

pub use limit::Limit;
use serde_json::{Value, json};

use crate::figures::Figures;

/// A good model's largest error. Unit: share of stroke. The paper's model, ten plays and ten dead
/// zones on one muscle, has an RMSE of 0.7 % of stroke; with the sensor and the muscle of another
/// bench 1 % is as good.
pub const GOOD: f64 = 0.01;
/// The largest error of a model that may drive a valve. Unit: share of stroke. A straight line
/// through the recordings of measured and simulated muscles leaves 8 to 15 %: a model with more
/// than 10 % is no better than none.
pub const DEPLOYABLE: f64 = 0.1;

/// The word for an error.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Grade {
    /// At most [`GOOD`].
    Good,
    /// At most [`DEPLOYABLE`].
    Fair,
    /// Above, or not known.
    Poor,
}

impl Grade {
    /// The word.
    pub fn name(self) -> &'static str {
        match self {
            Self::Good => "good",
            Self::Fair => "fair",
            Self::Poor => "poor",
        }
    }
}

/// What a model is worth.
///
/// ```
/// use recording::worth::{DEPLOYABLE, Worth};
///
/// let poor = Worth { share: 2.0 * DEPLOYABLE, is_heldout: true, limit: None };
/// assert!(!poor.may_deploy());
/// assert!(Worth { share: 0.005, ..poor }.may_deploy());
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Worth {
    /// Root mean square error. Unit: share of stroke.
    pub share: f64,
    /// Whether the error is that on samples that took no part in the fit, which is the larger one
    /// then.
    pub is_heldout: bool,
    /// What limits the model; None where that is not known.
    pub limit: Option<Limit>,
}

impl Worth {
    /// That of a model with these figures and this stroke. Output unit.
    pub fn from_figures(
        training: &Figures,
        heldout: Option<&Figures>,
        stroke: f64,
        limit: Option<Limit>,
    ) -> Self {
        let worse = heldout.filter(|heldout| heldout.rmse >= training.rmse);
        Self { share: worse.unwrap_or(training).rmse / stroke, is_heldout: worse.is_some(), limit }
    }

    /// Root mean square error. Unit: percent of stroke.
    pub fn percent(&self) -> f64 {
        100.0 * self.share
    }

    /// The word for it. An error that is not a number is poor.
    pub fn grade(&self) -> Grade {
        if self.share <= GOOD {
            Grade::Good
        } else if self.share <= DEPLOYABLE {
            Grade::Fair
        } else {
            Grade::Poor
        }
    }

    /// Whether the model may drive a valve without the user's `--force`.
    pub fn may_deploy(&self) -> bool {
        self.grade() != Grade::Poor
    }

    /// Why the model is no better, as a sentence without its full stop; None where that is not
    /// known.
    pub fn reason(&self) -> Option<&'static str> {
        self.limit.map(Limit::reason)
    }

    /// For programs.
    pub fn to_json(&self) -> Value {
        json!({
            "grade": self.grade().name(),
            "rmse_percent_of_stroke": self.percent(),
            "is_heldout": self.is_heldout,
            "may_deploy": self.may_deploy(),
            "limited_by": self.limit.map(Limit::key),
            "reason": self.reason(),
        })
    }
}

/// For people: `fair, RMSE 3.21 % of stroke on held-out samples; <reason>`.
impl fmt::Display for Worth {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let samples = if self.is_heldout { "held-out samples" } else { "the samples of the fit" };
        write!(f, "{}, RMSE {:.2} % of stroke on {samples}", self.grade().name(), self.percent())?;
        self.reason().map_or(Ok(()), |reason| write!(f, "; {reason}"))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn worth(share: f64) -> Worth {
        Worth { share, is_heldout: true, limit: None }
    }

    #[test]
    fn a_model_above_ten_percent_of_stroke_or_without_a_figure_may_not_deploy() {
        let grades = [0.007, 0.01, 0.02, 0.1, 0.11, f64::NAN].map(|share| worth(share).grade());
        assert_eq!(grades, [Grade::Good, Grade::Good, Grade::Fair, Grade::Fair, Grade::Poor, Grade::Poor]);
        assert!(worth(0.1).may_deploy() && !worth(0.101).may_deploy() && !worth(f64::NAN).may_deploy());
    }

    #[test]
    fn it_is_said_in_a_line() {
        let falls = Worth { limit: Some(Limit::Falls), ..worth(0.27) };
        let words = falls.to_string();
        assert!(words.starts_with("poor, RMSE 27.00 % of stroke on held-out samples; "), "{words}");
    }
}
