//! The zero moves steadily with time.

use model_core::ExtensionParameters;
use model_core::extension::DriftParameters;

use super::kind::{About, Kind, Law, Stage};
use super::needs::{Judge, Judged};
use crate::carrier::Carrier;
use crate::effect::{Effect, Form};
use crate::fitted::{Fitted, Parameters};
use crate::plan::part::Part;
use crate::signals::Signals;
use crate::simulated::Simulated;

/// The name of its parameter.
const RATE: &str = "mm_per_s";

/// The cause.
pub struct Drift;

fn rate_per_s(fitted: &Fitted<'_>) -> f64 {
    fitted.weight(0) / fitted.signals.duration_s().max(1e-9)
}

impl Kind for Drift {
    fn about(&self) -> &'static About {
        &About {
            name: "drift",
            meaning: "The zero moves steadily with time",
            law: Law::Progress,
            stage: Stage::Output,
            taken_for: &["warm_up", "creep"],
            told_from: &[
                ("warm_up", "in the rest between the swings time goes on and travel does not"),
                ("temperature", "let the temperature rise and fall, so that it is not a measure of time"),
            ],
            parts: &[Part::Again],
            ..About::PLAIN
        }
    }

    fn needs(&self, judge: &Judge<'_>) -> Judged {
        judge.repeats()
    }

    fn starts(&self, _signals: &Signals) -> Vec<Effect> {
        vec![Effect::new(Form::Drift, [])]
    }

    fn parameters(&self, fitted: &Fitted<'_>) -> Parameters {
        vec![(RATE, rate_per_s(fitted))]
    }

    fn extend(&self, carrier: &Carrier<'_>, all: &mut ExtensionParameters<f64>) {
        all.drift = Some(DriftParameters { rate_per_s: rate_per_s(&carrier.fitted), compensated: false });
    }

    fn written(&self, model: &Simulated<'_>) -> Option<Parameters> {
        model.extensions.drift.map(|drift| vec![(RATE, drift.rate_per_s)])
    }
}
