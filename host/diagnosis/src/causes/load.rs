//! The recorded load moves the curve.

use super::column;
use super::needs::{Judge, Judged};
use super::{Experiment, Fits, Kind, Stage};
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
    fn name(&self) -> &'static str {
        "load"
    }

    fn meaning(&self) -> &'static str {
        "The load, which was recorded, moves the curve"
    }

    fn needs(&self, judge: &Judge<'_>) -> Judged {
        judge.column("load", "N", judge.excitation.load)
    }

    fn fits(&self) -> Fits {
        Fits::Excited
    }

    fn starts(&self, signals: &Signals, _left: &[f64]) -> Vec<Effect> {
        column::starts(signals, Driver::Load, &signals.load)
    }

    fn parameters(&self, fitted: &Fitted<'_>) -> Parameters {
        named(column::moved(&fitted.signals.knots, &fitted.changes()))
    }

    fn stage(&self) -> Stage {
        Stage::Offset
    }

    fn written(&self, model: &Simulated<'_>) -> Option<Parameters> {
        let all = model.extensions;
        column::written(model, &all.load, all.sites.load).map(named)
    }

    fn experiment(&self) -> Experiment {
        Experiment {
            parts: &[Part::Loads],
            note: Some("change the load where the plan says so, and record it as load_n"),
            by_hand: true,
        }
    }
}
