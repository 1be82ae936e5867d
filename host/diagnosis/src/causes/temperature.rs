//! The recorded temperature moves the curve.

use model_core::ExtensionParameters;

use super::column;
use super::kind::{About, Fits, Kind, Stage};
use super::needs::{Judge, Judged};
use crate::carrier::Carrier;
use crate::effect::{Driver, Effect};
use crate::fitted::{Fitted, Parameters};
use crate::plan::part::Part;
use crate::signals::Signals;
use crate::simulated::Simulated;

/// The cause.
pub struct Temperature;

fn named((offset, gain): (f64, f64)) -> Parameters {
    vec![("offset_mm_per_k", offset), ("gain_per_k", gain)]
}

impl Kind for Temperature {
    fn about(&self) -> &'static About {
        &About {
            name: "temperature",
            meaning: "The temperature, which was recorded, moves the curve",
            stage: Stage::Offset,
            fits: Fits::Excited,
            parts: &[Part::Again],
            note: Some("record temperature_c, and let it rise and fall by some K while the plan is played"),
            ..About::PLAIN
        }
    }

    fn needs(&self, judge: &Judge<'_>) -> Judged {
        judge.column("temperature", "K", judge.excitation.temperature)
    }

    fn starts(&self, signals: &Signals) -> Vec<Effect> {
        column::starts(signals, Driver::Temperature, &signals.temperature)
    }

    fn parameters(&self, fitted: &Fitted<'_>) -> Parameters {
        named(column::moved(&fitted.signals.knots, &fitted.changes()))
    }

    fn extend(&self, carrier: &Carrier<'_>, all: &mut ExtensionParameters<f64>) {
        let (schedule, site) = carrier.schedule(&carrier.columns.temperature_c);
        (all.temperature, all.sites.temperature) = (Some(schedule), site);
    }

    fn written(&self, model: &Simulated<'_>) -> Option<Parameters> {
        let all = model.extensions;
        column::written(model, &all.temperature, all.sites.temperature).map(named)
    }
}
