//! The valve ignores command changes smaller than a band.
//!
//! It is looked for between command and pressure: in one chain with the muscle, a dead band is the muscle's own hysteresis.

use super::kind::{About, Fits, Kind, RECORD_PRESSURE, Stage};
use super::needs::{Judge, Judged, ValveView};
use crate::fitted::Parameters;
use crate::plan::part::Part;
use crate::simulated::Simulated;
use crate::valve::ValvePart;

/// The name of its parameter.
const BAND: &str = "band_bar";

/// The cause.
pub struct ValveDeadband;

impl Kind for ValveDeadband {
    fn about(&self) -> &'static About {
        &About {
            name: "valve_deadband",
            meaning: "The valve ignores changes of the command that are smaller than a band",
            stage: Stage::Valve,
            fits: Fits::Excited,
            in_valve: Some((ValvePart::Band, BAND)),
            told_from: &[(
                "hysteresis_shape",
                "record the pressure too: a dead band is between command and pressure, the loop after it",
            )],
            parts: &[Part::SmallSteps],
            note: Some(RECORD_PRESSURE),
            ..About::PLAIN
        }
    }

    fn needs(&self, judge: &Judge<'_>) -> Judged {
        match judge.valve {
            ValveView::InChain => {
                Err("the command alone was recorded: a dead band looks like the muscle's own hysteresis"
                    .to_owned())
            }
            ValveView::Unseen | ValveView::Beside(_) => judge.valve_seen(),
        }
    }

    fn written(&self, model: &Simulated<'_>) -> Option<Parameters> {
        model.extensions.valve_deadband.map(|deadband| vec![(BAND, deadband.band)])
    }
}
