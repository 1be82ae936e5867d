//! Dead time between input and contraction; between command and pressure it is the valve's.

use model_core::ExtensionParameters;
use model_core::extension::TransportDelayParameters;

use super::kind::{About, Kind, Law, RECORD_FAST, Stage};
use super::needs::{Judge, Judged, Lack};
use crate::carrier::Carrier;
use crate::effect::{Effect, Form, Parameter};
use crate::fitted::{Doubt, Fitted, Parameters};
use crate::plan::part::Part;
use crate::signals::Signals;
use crate::simulated::Simulated;
use crate::valve::{ORDINARY_LAG_S, ValvePart};

/// The name of its parameter.
const DELAY: &str = "delay_s";
/// The longest that is looked for. Unit: s.
const LONGEST_S: f64 = 3.0;

/// The cause.
pub struct TransportDelay;

impl Kind for TransportDelay {
    fn about(&self) -> &'static About {
        &About {
            name: "transport_delay",
            meaning: "The contraction answers the input after a dead time",
            law: Law::Delay,
            stage: Stage::Input,
            alike_without: &[Lack::Speeds],
            taken_for: &["viscous_lag", "inertia", "valve_lag"],
            in_valve: Some((ValvePart::Delay, DELAY)),
            told_from: &[
                ("valve_lag", "after a jump a delay leaves all still for its time, a lag begins at once"),
                ("viscous_lag", "after a jump a delay leaves all still for its time, a lag begins at once"),
                ("inertia", "after a jump a mass overshoots, a delay does not"),
            ],
            parts: &[Part::Speeds, Part::Jumps],
            note: Some(RECORD_FAST),
            ..About::PLAIN
        }
    }

    fn needs(&self, judge: &Judge<'_>) -> Judged {
        judge.lag()
    }

    fn starts(&self, signals: &Signals) -> Vec<Effect> {
        let longest_s = (signals.duration_s() / 3.0).min(LONGEST_S);
        let delay = |delay_s| {
            Effect::new(Form::Delay, [Parameter::new(delay_s, 0.0, longest_s, 0.1 * signals.step_s)])
        };
        [0.015, 0.04, 0.1, 0.25, 0.6].map(delay).to_vec()
    }

    fn parameters(&self, fitted: &Fitted<'_>) -> Parameters {
        vec![(DELAY, fitted.parameter(0))]
    }

    /// A delay that is as short, with the lag of the regulator before it, as any regulator's lag and half a row are.
    fn doubt(&self, fitted: &Fitted<'_>, _longest_hold_s: f64) -> Option<Doubt> {
        let late_s = fitted.regulator()?.lag_s + fitted.parameter(0);
        (late_s <= ORDINARY_LAG_S + 0.5 * fitted.signals.step_s).then_some(Doubt::Unseen)
    }

    fn extend(&self, carrier: &Carrier<'_>, all: &mut ExtensionParameters<f64>) {
        let delay_s = carrier.fitted.parameter(0).max(0.0);
        all.transport_delay = Some(TransportDelayParameters { delay_s });
    }

    fn written(&self, model: &Simulated<'_>) -> Option<Parameters> {
        model.extensions.transport_delay.map(|delay| vec![(DELAY, delay.delay_s)])
    }
}
