//! The pressure follows the command as a first-order lag.
//!
//! Any regulator has one: up to [`ORDINARY_LAG_S`] it is not named.

use model_core::ExtensionParameters;
use model_core::extension::ValveLagParameters;

use super::kind::{About, Fits, Kind, Ordinary, RECORD_PRESSURE, Stage};
use super::needs::{Judge, Judged, Lack, ValveView};
use crate::carrier::Carrier;
use crate::effect::{Effect, Form, Parameter};
use crate::fitted::{Fitted, Parameters};
use crate::plan::part::Part;
use crate::signals::Signals;
use crate::simulated::Simulated;
use crate::valve::{ORDINARY_LAG_S, ValvePart};

/// The name of its parameter.
const TIME_CONSTANT: &str = "time_constant_s";
/// The shortest lag that is looked for, in steps of the recording: a shorter one is over before the next sample.
const LEAST_LAG: f64 = 0.2;
/// The longest. Unit: s.
const LONGEST_S: f64 = 10.0;

/// The cause.
pub struct ValveLag;

/// The start of a lag no longer than any regulator's.
fn ordinary_lag(signals: &Signals) -> Option<Effect> {
    let low_s = LEAST_LAG * signals.step_s;
    let half_s = 0.5 * ORDINARY_LAG_S;
    let lag = || Effect::new(Form::Lag, [Parameter::logarithm(half_s, low_s, ORDINARY_LAG_S)]);
    (low_s < half_s).then(lag)
}

impl Kind for ValveLag {
    fn about(&self) -> &'static About {
        &About {
            name: "valve_lag",
            meaning: "The pressure follows the command late, as a first-order lag",
            stage: Stage::Valve,
            fits: Fits::Command,
            alike_without: &[Lack::Speeds],
            taken_for: &["transport_delay", "viscous_lag"],
            in_valve: Some((ValvePart::Lag, TIME_CONSTANT)),
            told_from: &[(
                "viscous_lag",
                "record the pressure too: it follows the command late, or it does not",
            )],
            parts: &[Part::Speeds, Part::Jumps],
            note: Some(RECORD_PRESSURE),
            ordinary: Some(Ordinary { up_to: (TIME_CONSTANT, ORDINARY_LAG_S), start: ordinary_lag }),
            ..About::PLAIN
        }
    }

    fn needs(&self, judge: &Judge<'_>) -> Judged {
        let valve = judge.valve_seen()?;
        let seen = match judge.valve {
            ValveView::Beside(excitation) => Judge { excitation, ..*judge }.lag()?,
            ValveView::Unseen | ValveView::InChain => judge.lag()?,
        };
        Ok(format!("{valve}; {seen}"))
    }

    fn starts(&self, signals: &Signals) -> Vec<Effect> {
        let longest_s = signals.duration_s() / 3.0;
        let lag = |lag_s| {
            let low_s = LEAST_LAG * signals.step_s;
            Effect::new(Form::Lag, [Parameter::logarithm(lag_s, low_s, longest_s.clamp(low_s, LONGEST_S))])
        };
        [0.03, 0.1, 0.4].map(lag).to_vec()
    }

    fn parameters(&self, fitted: &Fitted<'_>) -> Parameters {
        vec![(TIME_CONSTANT, fitted.parameter(0).exp())]
    }

    fn extend(&self, carrier: &Carrier<'_>, all: &mut ExtensionParameters<f64>) {
        all.valve_lag = Some(ValveLagParameters::new(carrier.fitted.parameter(0).exp()));
    }

    fn written(&self, model: &Simulated<'_>) -> Option<Parameters> {
        model.extensions.valve_lag.map(|lag| vec![(TIME_CONSTANT, lag.time_constant_s)])
    }
}
