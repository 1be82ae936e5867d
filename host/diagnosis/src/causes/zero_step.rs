//! The zero of the sensor jumps once.

use super::kind::{About, Fits, Kind, Law, Stage};
use super::needs::{Judge, Judged};
use crate::carrier::Carrier;
use crate::effect::{Effect, Form, Parameter};
use crate::extend::jump::Jump;
use crate::fitted::{Fitted, Parameters};
use crate::plan::part::Part;
use crate::signals::Signals;
use crate::simulated::Simulated;

/// How near the ends of the recording no jump is looked for, as a share of its duration: a jump at the beginning is one with the
/// unknown memory of the muscle. A choice.
const END: f64 = 0.05;
/// Times between these that are tried first.
const TIMES: usize = 40;
/// Beside the most promising time, and beside the one that is it then, so many more on either side, until they are samples: those of
/// a grid that is finer by one more than that.
const BESIDE: i32 = 4;

/// The cause.
pub struct ZeroStep;

/// A step at this time, of several so far apart. Unit: s.
fn step(time_s: f64, apart_s: f64) -> Effect {
    Effect::new(Form::Step, [Parameter::new(time_s, time_s, time_s, apart_s)])
}

/// `height`: output unit.
fn named(Jump { time_s, height }: Jump) -> Parameters {
    vec![("height_mm", height), ("time_s", time_s)]
}

fn jump(fitted: &Fitted<'_>) -> Jump {
    Jump { time_s: fitted.parameter(0), height: fitted.weight(0) }
}

impl Kind for ZeroStep {
    fn about(&self) -> &'static About {
        &About {
            name: "zero_step",
            meaning: "The zero of the sensor jumps once",
            law: Law::Progress,
            stage: Stage::Output,
            fits: Fits::Excited,
            taken_for: &["drift", "warm_up"],
            told_from: &[
                ("drift", "play the same swings again behind the jump: a drift goes on there"),
                ("warm_up", "play the same swings again behind the jump: what settles settles further there"),
            ],
            parts: &[Part::Again],
            note: Some("fasten the sensor before the next recording: this one shows that it has moved"),
            ..About::PLAIN
        }
    }

    fn needs(&self, judge: &Judge<'_>) -> Judged {
        judge.repeats()
    }

    fn starts(&self, signals: &Signals) -> Vec<Effect> {
        let first_s = signals.time_s.first().copied().unwrap_or(0.0) + END * signals.duration_s();
        let apart_s = (1.0 - 2.0 * END) * signals.duration_s() / (TIMES - 1) as f64;
        (0..TIMES).map(|place| step(first_s + place as f64 * apart_s, apart_s)).collect()
    }

    fn nearer(&self, signals: &Signals, start: &Effect) -> Vec<Effect> {
        let Some(time) = start.parameters.first().filter(|time| time.step > signals.step_s) else {
            return Vec::new();
        };
        let apart_s = time.step / f64::from(BESIDE + 1);
        (-BESIDE..=BESIDE).map(|place| step(time.value + f64::from(place) * apart_s, apart_s)).collect()
    }

    fn parameters(&self, fitted: &Fitted<'_>) -> Parameters {
        named(jump(fitted))
    }

    fn jump(&self, carrier: &Carrier<'_>) -> Option<Jump> {
        Some(jump(&carrier.fitted))
    }

    fn written(&self, model: &Simulated<'_>) -> Option<Parameters> {
        model.jump.map(named)
    }
}
