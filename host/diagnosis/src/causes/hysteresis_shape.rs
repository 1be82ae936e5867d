//! What is left is rate-independent: the operator model is too poor.
//!
//! It has no effect in the search, whose baseline takes the form of any hysteresis: it is named where the model that is written does
//! not.

use super::needs::{Judge, Judged};
use super::{Fits, Kind, Law, Stage};

/// The least number of different heights of swings in which the shape of inner loops shows.
const HEIGHTS: usize = 3;

/// The cause.
pub struct HysteresisShape;

impl Kind for HysteresisShape {
    fn name(&self) -> &'static str {
        "hysteresis_shape"
    }

    fn meaning(&self) -> &'static str {
        "What is left does not depend on time or speed: the operator model is too poor"
    }

    fn law(&self) -> Law {
        Law::Form
    }

    fn needs(&self, judge: &Judge<'_>) -> Judged {
        judge.swings()?;
        Ok(match judge.excitation.heights {
            heights if heights < HEIGHTS => {
                format!("swings of {heights} different heights only: inner loops hardly show")
            }
            heights => format!("swings of {heights} different heights"),
        })
    }

    fn fits(&self) -> Fits {
        Fits::Excited
    }

    fn stage(&self) -> Stage {
        Stage::Hysteresis
    }
}
