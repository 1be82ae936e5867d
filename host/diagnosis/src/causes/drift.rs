//! The zero moves steadily with time.

use super::needs::{Judge, Judged};
use super::{Experiment, Kind, Law, Stage};
use crate::effect::{Effect, Form};
use crate::fitted::{Fitted, Parameters};
use crate::plan::part::Part;
use crate::signals::Signals;
use crate::simulated::Simulated;

/// The name of its parameter.
const RATE: &str = "mm_per_s";

/// The cause.
pub struct Drift;

impl Kind for Drift {
    fn name(&self) -> &'static str {
        "drift"
    }

    fn meaning(&self) -> &'static str {
        "The zero moves steadily with time"
    }

    fn law(&self) -> Law {
        Law::Progress
    }

    fn needs(&self, judge: &Judge<'_>) -> Judged {
        judge.repeats()
    }

    fn starts(&self, _signals: &Signals, _left: &[f64]) -> Vec<Effect> {
        vec![Effect::new(Form::Drift, [])]
    }

    fn taken_for(&self) -> &'static [&'static str] {
        &["warm_up", "creep"]
    }

    fn parameters(&self, fitted: &Fitted<'_>) -> Parameters {
        vec![(RATE, fitted.weight(0) / fitted.signals.duration_s().max(1e-9))]
    }

    fn stage(&self) -> Stage {
        Stage::Output
    }

    fn written(&self, model: &Simulated<'_>) -> Option<Parameters> {
        model.extensions.drift.map(|drift| vec![(RATE, drift.rate_per_s)])
    }

    fn experiment(&self) -> Experiment {
        Experiment { parts: &[Part::Again], ..Experiment::default() }
    }
}
