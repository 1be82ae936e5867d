//! Dead time between input and contraction; between command and pressure it is the valve's.

use super::needs::{Judge, Judged, Lack};
use super::{Experiment, Kind, Law, Stage};
use crate::effect::{Effect, Form, Parameter};
use crate::fitted::{Fitted, Parameters};
use crate::plan::part::Part;
use crate::signals::Signals;
use crate::simulated::Simulated;
use crate::valve::ValvePart;

/// The name of its parameter.
const DELAY: &str = "delay_s";
/// The longest that is looked for. Unit: s.
const LONGEST_S: f64 = 3.0;

/// The cause.
pub struct TransportDelay;

impl Kind for TransportDelay {
    fn name(&self) -> &'static str {
        "transport_delay"
    }

    fn meaning(&self) -> &'static str {
        "The contraction answers the input after a dead time"
    }

    fn law(&self) -> Law {
        Law::Delay
    }

    fn needs(&self, judge: &Judge<'_>) -> Judged {
        judge.lag()
    }

    fn alike_without(&self) -> &'static [Lack] {
        &[Lack::Speeds]
    }

    fn starts(&self, signals: &Signals, _left: &[f64]) -> Vec<Effect> {
        let longest_s = (signals.duration_s() / 3.0).min(LONGEST_S);
        let delay = |delay_s| {
            Effect::new(Form::Delay, [Parameter::new(delay_s, 0.0, longest_s, 0.1 * signals.step_s)])
        };
        [0.015, 0.04, 0.1, 0.25, 0.6].map(delay).to_vec()
    }

    fn taken_for(&self) -> &'static [&'static str] {
        &["viscous_lag", "inertia", "valve_lag"]
    }

    fn parameters(&self, fitted: &Fitted<'_>) -> Parameters {
        vec![(DELAY, fitted.parameter(0))]
    }

    fn in_valve(&self) -> Option<(ValvePart, &'static str)> {
        Some((ValvePart::Delay, DELAY))
    }

    fn stage(&self) -> Stage {
        Stage::Input
    }

    fn written(&self, model: &Simulated<'_>) -> Option<Parameters> {
        model.extensions.transport_delay.map(|delay| vec![(DELAY, delay.delay_s)])
    }

    fn experiment(&self) -> Experiment {
        Experiment { parts: &[Part::Speeds, Part::Jumps], note: Some(super::RECORD_FAST), by_hand: false }
    }
}
