//! Pressure never rises above the supply.

use super::needs::{Judge, Judged};
use super::{Experiment, Fits, Kind, Stage};
use crate::fitted::Parameters;
use crate::plan::part::Part;
use crate::simulated::Simulated;
use crate::valve::ValvePart;

/// The name of its parameter.
const SUPPLY: &str = "supply_bar";

/// The cause.
pub struct SupplySaturation;

impl Kind for SupplySaturation {
    fn name(&self) -> &'static str {
        "supply_saturation"
    }

    fn meaning(&self) -> &'static str {
        "The pressure never rises above the supply"
    }

    fn needs(&self, judge: &Judge<'_>) -> Judged {
        judge.valve_seen()
    }

    fn fits(&self) -> Fits {
        Fits::Excited
    }

    fn in_valve(&self) -> Option<(ValvePart, &'static str)> {
        Some((ValvePart::Supply, SUPPLY))
    }

    fn stage(&self) -> Stage {
        Stage::Input
    }

    fn written(&self, model: &Simulated<'_>) -> Option<Parameters> {
        model.extensions.supply_saturation.map(|saturation| vec![(SUPPLY, saturation.supply)])
    }

    /// It is measured at the valve.
    fn measured(&self, _model: &Simulated<'_>) -> Option<Parameters> {
        None
    }

    fn experiment(&self) -> Experiment {
        Experiment { parts: &[Part::Top], note: Some(super::RECORD_PRESSURE), by_hand: false }
    }
}
