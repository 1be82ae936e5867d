//! What a cause says of itself.

use model_core::ExtensionParameters;

use super::needs::{Judge, Judged, Lack};
use crate::carrier::Carrier;
use crate::effect::Effect;
use crate::extend::jump::Jump;
use crate::fitted::{Doubt, Fitted, Parameters};
use crate::plan::part::Part;
use crate::signals::Signals;
use crate::simulated::Simulated;
use crate::valve::ValvePart;

/// A note of the valve's causes.
pub const RECORD_PRESSURE: &str = "record the measured pressure as pressure_bar beside command_bar";
/// A note of fast causes.
pub const RECORD_FAST: &str = "record 100 rows a second or more: fast movements are short";

/// The law by which a cause acts, as far as others ask.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Law {
    /// The input comes later as it is.
    Delay,
    /// A force over the rate: the term of first order of the balance of forces, by which a mass is damped.
    Viscosity,
    /// A force over the acceleration: its term of second order, which has one of first order in it.
    Mass,
    /// The loop is wider by a power of the rate, as it is by much that a model gets wrong about a hysteresis.
    Width,
    /// The input ends at a level.
    Ceiling,
    /// Time or travel alone, whatever the input does.
    Progress,
    /// The form of the operator model itself.
    Form,
    /// None that others ask for.
    Own,
}

/// Recordings that a cause can be fitted to, whether they excite it or not.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Fits {
    /// Any of input and output.
    Any,
    /// Any of those whose input is the command: in others it acts before the input.
    Command,
    /// Those alone that excite it.
    Excited,
}

/// Where a model has a cause, on the way from the command to the contraction.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Stage {
    /// Between command and pressure, where its parameters are measured too.
    Valve,
    /// On the way of the input.
    Input,
    /// In what is taken off the input, or off the output.
    Offset,
    /// In the balance of forces.
    Motion,
    /// In the hysteresis.
    Hysteresis,
    /// Behind it.
    Output,
}

/// What is known of a cause.
#[derive(Clone, Copy, Debug)]
pub struct About {
    /// The name in commands and files.
    pub name: &'static str,
    /// What it is, for people: a sentence without its full stop.
    pub meaning: &'static str,
    /// The law by which it acts.
    pub law: Law,
    /// Where a model has it.
    pub stage: Stage,
    /// What it can be fitted to.
    pub fits: Fits,
    /// Without these it looks like the other causes that need them.
    pub alike_without: &'static [Lack],
    /// What it has to be better by than a cause that explains much the same with less.
    pub complexity: f64,
    /// What it has to be better by than a cause that it contains.
    pub containment: f64,
    /// The names of the causes that it is most easily taken for, the likeliest first.
    pub taken_for: &'static [&'static str],
    /// The part of a valve that it is, with the name of its parameter.
    pub in_valve: Option<(ValvePart, &'static str)>,
    /// Names of causes that an experiment tells it from, and how; a pair is in the file of one of the two.
    pub told_from: &'static [(&'static str, &'static str)],
    /// Parts of an excitation that show it, beside those that every one has.
    pub parts: &'static [Part],
    /// What has to be done beside playing the command.
    pub note: Option<&'static str>,
    /// Whether it shows by a hand on the muscle alone.
    pub by_hand: bool,
}

impl About {
    /// One that has nothing that others ask for.
    pub const PLAIN: Self = Self {
        name: "",
        meaning: "",
        law: Law::Own,
        stage: Stage::Output,
        fits: Fits::Any,
        alike_without: &[],
        complexity: 0.0,
        containment: 0.0,
        taken_for: &[],
        in_valve: None,
        told_from: &[],
        parts: &[],
        note: None,
        by_hand: false,
    };
}

/// A cause: what is known of it, and what it makes of a recording and of a model.
pub trait Kind: Sync {
    /// What is known of it.
    fn about(&self) -> &'static About;

    /// What it needs of a recording to be seen, met or not.
    fn needs(&self, judge: &Judge<'_>) -> Judged;

    /// In how many independent ways it may fit by chance: a jump at one time has little to do with a jump at another, and the one that fits best
    /// is what is found.
    fn hypotheses(&self) -> usize {
        1
    }

    /// The effects to try for it in the search, from their several starts; none where the recording has not what it takes.
    fn starts(&self, _signals: &Signals) -> Vec<Effect> {
        Vec::new()
    }

    /// The same where other effects leave this residual of the scored rows.
    fn starts_beside(&self, signals: &Signals, _left: &[f64]) -> Vec<Effect> {
        self.starts(signals)
    }

    /// More starts near the one that has turned out to be the most promising; none where it needs none. Asked again of the best of these.
    fn nearer(&self, _signals: &Signals, _start: &Effect) -> Vec<Effect> {
        Vec::new()
    }

    /// Its parameters in the units that people measure in, as the search has it.
    fn parameters(&self, _fitted: &Fitted<'_>) -> Parameters {
        Vec::new()
    }

    /// What speaks against it as the search has it, in a recording with this longest hold. Unit: s.
    fn doubt(&self, _fitted: &Fitted<'_>, _longest_hold_s: f64) -> Option<Doubt> {
        None
    }

    /// Adds its extension of a model to those of others, the nearest to its effect in the search.
    fn extend(&self, _carrier: &Carrier<'_>, _all: &mut ExtensionParameters<f64>) {}

    /// What it has done to the sensor's zero in the recording, which is no part of the muscle.
    fn jump(&self, _carrier: &Carrier<'_>) -> Option<Jump> {
        None
    }

    /// Its parameters where it extends a model; None where it does not.
    fn written(&self, _model: &Simulated<'_>) -> Option<Parameters> {
        None
    }

    /// Its parameters as a model with the named causes measures them, if that has something to say: of the valve it has not.
    fn measured(&self, model: &Simulated<'_>) -> Option<Parameters> {
        if self.about().stage == Stage::Valve { None } else { self.written(model) }
    }

    /// Takes over what was measured.
    fn take_over(&self, own: &mut Parameters, measured: Parameters) {
        *own = measured;
    }
}
