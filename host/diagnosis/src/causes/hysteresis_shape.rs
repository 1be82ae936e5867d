//! What is left is rate-independent: the operator model is too poor.
//!
//! It has no effect in the search, whose baseline takes the form of any hysteresis: it is named where the model that is written does
//! not.

use super::kind::{About, Fits, Kind, Law, Stage};
use super::needs::{Judge, Judged};

/// The least number of different heights of swings in which the shape of inner loops shows.
const HEIGHTS: usize = 3;

/// The cause.
pub struct HysteresisShape;

impl Kind for HysteresisShape {
    fn about(&self) -> &'static About {
        &About {
            name: "hysteresis_shape",
            meaning: "What is left does not depend on time or speed: the operator model is too poor",
            law: Law::Form,
            stage: Stage::Hysteresis,
            fits: Fits::Excited,
            ..About::PLAIN
        }
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
}
