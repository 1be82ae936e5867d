//! The pressure follows the command as a first-order lag.
//!
//! Any regulator has one: up to [`ORDINARY_LAG_S`] it is not named.

use super::needs::{Judge, Judged, Lack, ValveView};
use super::{Experiment, Fits, Kind, Ordinary, Stage};
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

impl Kind for ValveLag {
    fn name(&self) -> &'static str {
        "valve_lag"
    }

    fn meaning(&self) -> &'static str {
        "The pressure follows the command late, as a first-order lag"
    }

    fn needs(&self, judge: &Judge<'_>) -> Judged {
        let valve = judge.valve_seen()?;
        let seen = match judge.valve {
            ValveView::Beside(excitation) => Judge { excitation, ..*judge }.lag()?,
            ValveView::Unseen | ValveView::InChain => judge.lag()?,
        };
        Ok(format!("{valve}; {seen}"))
    }

    fn fits(&self) -> Fits {
        Fits::Command
    }

    fn alike_without(&self) -> &'static [Lack] {
        &[Lack::Speeds]
    }

    fn starts(&self, signals: &Signals, _left: &[f64]) -> Vec<Effect> {
        let longest_s = signals.duration_s() / 3.0;
        let lag = |lag_s| {
            let low_s = LEAST_LAG * signals.step_s;
            Effect::new(Form::Lag, [Parameter::logarithm(lag_s, low_s, longest_s.clamp(low_s, LONGEST_S))])
        };
        [0.03, 0.1, 0.4].map(lag).to_vec()
    }

    fn taken_for(&self) -> &'static [&'static str] {
        &["transport_delay", "viscous_lag"]
    }

    fn parameters(&self, fitted: &Fitted<'_>) -> Parameters {
        vec![(TIME_CONSTANT, fitted.parameter(0).exp())]
    }

    fn in_valve(&self) -> Option<(ValvePart, &'static str)> {
        Some((ValvePart::Lag, TIME_CONSTANT))
    }

    fn ordinary(&self) -> Option<Ordinary> {
        let start = |signals: &Signals| {
            let low_s = LEAST_LAG * signals.step_s;
            let half_s = 0.5 * ORDINARY_LAG_S;
            let lag = || Effect::new(Form::Lag, [Parameter::logarithm(half_s, low_s, ORDINARY_LAG_S)]);
            (low_s < half_s).then(lag)
        };
        Some(Ordinary { up_to: (TIME_CONSTANT, ORDINARY_LAG_S), start })
    }

    fn stage(&self) -> Stage {
        Stage::Input
    }

    fn written(&self, model: &Simulated<'_>) -> Option<Parameters> {
        model.extensions.valve_lag.map(|lag| vec![(TIME_CONSTANT, lag.time_constant_s)])
    }

    /// What was found between command and pressure is nearer to the valve than a model of the whole chain.
    fn measured(&self, _model: &Simulated<'_>) -> Option<Parameters> {
        None
    }

    fn experiment(&self) -> Experiment {
        Experiment { parts: &[Part::Speeds, Part::Jumps], note: Some(super::RECORD_PRESSURE), by_hand: false }
    }
}
