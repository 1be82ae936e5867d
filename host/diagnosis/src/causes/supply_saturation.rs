//! Pressure never rises above the supply.
//!
//! Beside a measured pressure it is looked for in the valve. Of the command alone it is a ceiling of the input: what a muscle does below
//! it goes both ways at the same commands, where a curve that grows flat, or a loop that turns, goes at others.

use model_core::ExtensionParameters;
use model_core::extension::SupplySaturationParameters;

use super::kind::{About, Fits, Kind, Law, RECORD_PRESSURE, Stage};
use super::needs::{Judge, Judged};
use crate::carrier::Carrier;
use crate::effect::{Effect, Form, Parameter};
use crate::fitted::{Fitted, Parameters};
use crate::plan::part::Part;
use crate::signals::Signals;
use crate::simulated::Simulated;
use crate::valve::ValvePart;
use recording::numbers::range;

/// The name of its parameter.
const SUPPLY: &str = "supply_bar";
/// Where the search for a ceiling begins, and the lowest that it may come to, as shares of the input's span. Choices: of a supply below the
/// lowest less than half of the recording would be left.
const STARTS: [f64; 3] = [0.95, 0.85, 0.7];
const LOWEST: f64 = 0.4;
/// The difference that derivatives are taken by, as a share of the span.
const STEP: f64 = 1e-3;

/// The cause.
pub struct SupplySaturation;

impl Kind for SupplySaturation {
    fn about(&self) -> &'static About {
        &About {
            name: "supply_saturation",
            meaning: "The pressure never rises above the supply",
            law: Law::Ceiling,
            stage: Stage::Valve,
            fits: Fits::Command,
            in_valve: Some((ValvePart::Supply, SUPPLY)),
            parts: &[Part::Top],
            note: Some(RECORD_PRESSURE),
            ..About::PLAIN
        }
    }

    fn needs(&self, judge: &Judge<'_>) -> Judged {
        judge.valve_seen()
    }

    fn starts(&self, signals: &Signals) -> Vec<Effect> {
        let (low, high) = range(&signals.recorded.input);
        let at = |share: f64| low + share * (high - low);
        let ceiling = |share| Parameter::new(at(share), at(LOWEST), high, STEP * (high - low));
        STARTS.map(|share| Effect::new(Form::Ceiling, [ceiling(share)])).to_vec()
    }

    fn parameters(&self, fitted: &Fitted<'_>) -> Parameters {
        vec![(SUPPLY, fitted.parameter(0))]
    }

    fn extend(&self, carrier: &Carrier<'_>, all: &mut ExtensionParameters<f64>) {
        all.supply_saturation = Some(SupplySaturationParameters { supply: carrier.fitted.parameter(0) });
    }

    fn written(&self, model: &Simulated<'_>) -> Option<Parameters> {
        model.extensions.supply_saturation.map(|saturation| vec![(SUPPLY, saturation.supply)])
    }

    fn measured(&self, model: &Simulated<'_>) -> Option<Parameters> {
        // Of the command alone the model moves it, and beside a measured pressure it is the valve's.
        self.written(model)
    }
}
