//! Pressure never rises above the supply.

use super::kind::{About, Fits, Kind, RECORD_PRESSURE, Stage};
use super::needs::{Judge, Judged};
use crate::fitted::Parameters;
use crate::plan::part::Part;
use crate::simulated::Simulated;
use crate::valve::ValvePart;

/// The name of its parameter.
const SUPPLY: &str = "supply_bar";

/// The cause.
pub struct SupplySaturation;

impl Kind for SupplySaturation {
    fn about(&self) -> &'static About {
        &About {
            name: "supply_saturation",
            meaning: "The pressure never rises above the supply",
            stage: Stage::Valve,
            fits: Fits::Excited,
            in_valve: Some((ValvePart::Supply, SUPPLY)),
            parts: &[Part::Top],
            note: Some(RECORD_PRESSURE),
            ..About::PLAIN
        }
    }

    fn needs(&self, judge: &Judge<'_>) -> Judged {
        judge.valve_seen()
    }

    fn written(&self, model: &Simulated<'_>) -> Option<Parameters> {
        model.extensions.supply_saturation.map(|saturation| vec![(SUPPLY, saturation.supply)])
    }
}
