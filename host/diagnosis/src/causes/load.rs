//! The recorded load moves the curve.

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
pub struct Load;

fn named((offset, gain): (f64, f64)) -> Parameters {
    vec![("offset_mm_per_n", offset), ("gain_per_n", gain)]
}

impl Kind for Load {
    fn about(&self) -> &'static About {
        &About {
            name: "load",
            meaning: "The load, which was recorded, moves the curve",
            stage: Stage::Offset,
            fits: Fits::Excited,
            parts: &[Part::Loads],
            note: Some("change the load where the plan says so, and record it as load_n"),
            by_hand: true,
            ..About::PLAIN
        }
    }

    fn needs(&self, judge: &Judge<'_>) -> Judged {
        judge.column("load", "N", judge.excitation.load)
    }

    fn starts(&self, signals: &Signals) -> Vec<Effect> {
        column::starts(signals, Driver::Load, &signals.load)
    }

    fn parameters(&self, fitted: &Fitted<'_>) -> Parameters {
        named(column::moved(&fitted.signals.knots, &fitted.changes()))
    }

    fn extend(&self, carrier: &Carrier<'_>, all: &mut ExtensionParameters<f64>) {
        let (schedule, site) = carrier.schedule(&carrier.columns.load_n);
        (all.load, all.sites.load) = (Some(schedule), site);
    }

    fn written(&self, model: &Simulated<'_>) -> Option<Parameters> {
        let all = model.extensions;
        column::written(model, &all.load, all.sites.load).map(named)
    }
}
