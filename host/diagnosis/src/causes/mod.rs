//! The causes that can be named: a file each, which says all that the diagnosis knows of that cause.
//!
//! # Design
//! The selection asks a cause what it needs to know, through [`Kind`], and knows none by name. What several causes have in common is a
//! [`Law`], a [`Stage`] or a part of the valve, so that a new cause is treated like those that are like it. Causes name each other, as
//! rivals, by name alone: no file needs another one.
//!
//! | file | what it has |
//! |---|---|
//! | `needs` | what several causes need of a recording |
//! | `column` | what a recorded column moves |
//! | all others | a cause each, by its name |
//!
//! To add one: its file, a line in [`Cause::ALL`], and what `docs/add-a-cause.md` says of tests and the game.
//!
//! # Limits
//! A cause of a new form needs that form in `effect`, with its columns in `equivalent` or `output`, and an extension of the operator
//! model where it shall be simulated. A part of the valve is searched for in `valve`.

mod column;
mod creep;
mod drift;
mod hysteresis_shape;
mod inertia;
mod load;
pub mod needs;
mod periodic_disturbance;
mod rate_dependent_width;
mod supply_saturation;
mod temperature;
mod transport_delay;
mod valve_deadband;
mod valve_lag;
mod viscous_lag;
mod warm_up;

use std::fmt;
use std::hash::{Hash, Hasher};
use std::ops::Deref;

use self::needs::{Judge, Judged, Lack};
use crate::effect::Effect;
use crate::fitted::{Doubt, Fitted, Parameters};
use crate::plan::part::Part;
use crate::signals::Signals;
use crate::simulated::Simulated;
use crate::valve::ValvePart;

/// A cause that can be named: what can be wrong in a simulation, each a nested extension of the model in its physical place.
#[derive(Clone, Copy)]
pub struct Cause(&'static dyn Kind);

impl Cause {
    /// All of them, in the order in which they are listed.
    pub const ALL: [Self; 14] = [
        Self(&valve_lag::ValveLag),
        Self(&valve_deadband::ValveDeadband),
        Self(&supply_saturation::SupplySaturation),
        Self(&transport_delay::TransportDelay),
        Self(&viscous_lag::ViscousLag),
        Self(&rate_dependent_width::RateDependentWidth),
        Self(&inertia::Inertia),
        Self(&creep::Creep),
        Self(&load::Load),
        Self(&temperature::Temperature),
        Self(&drift::Drift),
        Self(&warm_up::WarmUp),
        Self(&periodic_disturbance::PeriodicDisturbance),
        Self(&hysteresis_shape::HysteresisShape),
    ];

    /// The cause of this name.
    pub fn of_name(name: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|cause| cause.name() == name)
    }

    /// The first cause of a law.
    pub fn of_law(law: Law) -> Option<Self> {
        Self::ALL.into_iter().find(|cause| cause.law() == law)
    }

    /// The cause that a part of a valve is, with the name of its parameter.
    pub fn of_valve(part: ValvePart) -> Option<(Self, &'static str)> {
        let of =
            |cause: Self| cause.in_valve().filter(|(own, _)| *own == part).map(|(_, name)| (cause, name));
        Self::ALL.into_iter().find_map(of)
    }

    /// The causes that it is most easily taken for, the likeliest first.
    pub fn rivals(self) -> impl Iterator<Item = Self> {
        self.taken_for().iter().filter_map(|name| Self::of_name(name))
    }

    /// Whether it acts within fractions of a second.
    pub fn is_fast(self) -> bool {
        self.law() == Law::Delay || self.resists_motion()
    }

    /// Whether it resists motion by a law over the rate: three forms of much the same.
    pub fn resists_motion(self) -> bool {
        self.is_of_second_order() || self.law() == Law::Width
    }

    /// Whether it is a term of the equation of second order that mass and viscosity are together.
    pub fn is_of_second_order(self) -> bool {
        matches!(self.law(), Law::Viscosity | Law::Mass)
    }
}

impl Deref for Cause {
    type Target = dyn Kind;

    fn deref(&self) -> &Self::Target {
        self.0
    }
}

impl PartialEq for Cause {
    fn eq(&self, other: &Self) -> bool {
        self.name() == other.name()
    }
}

impl Eq for Cause {}

impl Hash for Cause {
    fn hash<H: Hasher>(&self, state: &mut H) {
        self.name().hash(state);
    }
}

impl fmt::Debug for Cause {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.name())
    }
}

impl fmt::Display for Cause {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.name())
    }
}

/// What the valve's causes ask for beside the command.
const RECORD_PRESSURE: &str = "record the measured pressure as pressure_bar beside command_bar";
/// What fast causes ask for.
const RECORD_FAST: &str = "record 100 rows a second or more: fast movements are short";

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

/// What any recording of a command has of a cause.
#[derive(Clone, Copy, Debug)]
pub struct Ordinary {
    /// The parameter, and up to where it is ordinary.
    pub up_to: (&'static str, f64),
    /// Its effect, no larger than that; None where the samples are too far apart for one.
    pub start: fn(&Signals) -> Option<Effect>,
}

/// What an experiment has to have for a cause.
#[derive(Clone, Copy, Debug, Default)]
pub struct Experiment {
    /// Parts of the excitation beside those that every one has.
    pub parts: &'static [Part],
    /// What has to be done beside playing the command.
    pub note: Option<&'static str>,
    /// Whether it shows by a hand on the muscle alone.
    pub by_hand: bool,
}

/// All that the diagnosis knows of a cause.
pub trait Kind: Sync {
    /// The name in commands and files.
    fn name(&self) -> &'static str;

    /// What it is, for people: a sentence without its full stop.
    fn meaning(&self) -> &'static str;

    /// The law by which it acts.
    fn law(&self) -> Law {
        Law::Own
    }

    /// What it needs of a recording to be seen, met or not.
    fn needs(&self, judge: &Judge<'_>) -> Judged;

    /// What it can be fitted to.
    fn fits(&self) -> Fits {
        Fits::Any
    }

    /// Without these it looks like the other causes that need them.
    fn alike_without(&self) -> &'static [Lack] {
        &[]
    }

    /// The effects to try for it in the search, from their several starts, where others leave this residual of the scored rows; none
    /// where the recording has not what it takes.
    fn starts(&self, _signals: &Signals, _left: &[f64]) -> Vec<Effect> {
        Vec::new()
    }

    /// What it has to be better by than a cause that explains much the same with less.
    fn complexity(&self) -> f64 {
        0.0
    }

    /// What it has to be better by than a cause that it contains.
    fn containment(&self) -> f64 {
        0.0
    }

    /// The names of the causes that it is most easily taken for, the likeliest first.
    fn taken_for(&self) -> &'static [&'static str] {
        &[]
    }

    /// Its parameters in the units that people measure in, as the search has it.
    fn parameters(&self, _fitted: &Fitted<'_>) -> Parameters {
        Vec::new()
    }

    /// What speaks against it as the search has it, in a recording with this longest hold. Unit: s.
    fn doubt(&self, _fitted: &Fitted<'_>, _longest_hold_s: f64) -> Option<Doubt> {
        None
    }

    /// The part of a valve that it is, with the name of its parameter.
    fn in_valve(&self) -> Option<(ValvePart, &'static str)> {
        None
    }

    /// What of it is nothing that is wrong.
    fn ordinary(&self) -> Option<Ordinary> {
        None
    }

    /// Where a model has it.
    fn stage(&self) -> Stage;

    /// Its parameters where it extends a model; None where it does not.
    fn written(&self, _model: &Simulated<'_>) -> Option<Parameters> {
        None
    }

    /// Its parameters as a model with the named causes measures them, if that has something to say.
    fn measured(&self, model: &Simulated<'_>) -> Option<Parameters> {
        self.written(model)
    }

    /// Takes over what was measured.
    fn take_over(&self, own: &mut Parameters, measured: Parameters) {
        *own = measured;
    }

    /// What shows it.
    fn experiment(&self) -> Experiment {
        Experiment::default()
    }
}

/// The cause of a name, for tests.
#[cfg(test)]
pub fn cause(name: &str) -> Cause {
    Cause::of_name(name).unwrap_or_else(|| panic!("no cause is called {name}"))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn each_cause_has_a_name_of_its_own_and_names_only_others_that_there_are() {
        for (place, cause) in Cause::ALL.into_iter().enumerate() {
            let named = Cause::of_name(cause.name()).expect("a name");
            assert!(Cause::ALL.iter().position(|other| *other == named) == Some(place), "{cause}");
            assert_eq!(cause.rivals().count(), cause.taken_for().len(), "{cause}");
            assert!(cause.rivals().all(|rival| rival != cause), "{cause}");
        }
    }
}
