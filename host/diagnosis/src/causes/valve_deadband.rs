//! The valve ignores command changes smaller than a band.
//!
//! It is looked for between command and pressure: in one chain with the muscle, a dead band is the muscle's own hysteresis.

use super::needs::{Judge, Judged, ValveView};
use super::{Experiment, Fits, Kind, Stage};
use crate::fitted::Parameters;
use crate::plan::part::Part;
use crate::simulated::Simulated;
use crate::valve::ValvePart;

/// The name of its parameter.
const BAND: &str = "band_bar";

/// The cause.
pub struct ValveDeadband;

impl Kind for ValveDeadband {
    fn name(&self) -> &'static str {
        "valve_deadband"
    }

    fn meaning(&self) -> &'static str {
        "The valve ignores changes of the command that are smaller than a band"
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

    fn fits(&self) -> Fits {
        Fits::Excited
    }

    fn in_valve(&self) -> Option<(ValvePart, &'static str)> {
        Some((ValvePart::Band, BAND))
    }

    fn stage(&self) -> Stage {
        Stage::Input
    }

    fn written(&self, model: &Simulated<'_>) -> Option<Parameters> {
        model.extensions.valve_deadband.map(|deadband| vec![(BAND, deadband.band)])
    }

    /// It is measured at the valve.
    fn measured(&self, _model: &Simulated<'_>) -> Option<Parameters> {
        None
    }

    fn experiment(&self) -> Experiment {
        Experiment { parts: &[Part::SmallSteps], note: Some(super::RECORD_PRESSURE), by_hand: false }
    }
}
