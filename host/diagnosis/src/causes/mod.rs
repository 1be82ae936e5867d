//! The causes that can be named: a file each, which says all that the diagnosis knows of that cause.
//!
//! # Design
//! The selection asks a cause what it needs to know, through [`Kind`], and knows none by name: the modules of the causes are private.
//! What several causes have in common is a [`Law`], a lack of excitation that shows them alike, or a part of the valve, so that a new
//! cause is treated like those that are like it. Causes name each other, as rivals, by name alone: no file needs another one.
//!
//! | file | what it has |
//! |---|---|
//! | [`kind`] | what a cause says of itself |
//! | [`needs`] | what several causes need of a recording |
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
pub mod kind;
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
mod zero_step;

use std::fmt;
use std::ops::Deref;

pub use self::kind::{Fits, Kind, Law};
use crate::valve::ValvePart;

/// A cause that can be named: what can be wrong in a simulation, each a nested extension of the model in its physical place.
#[derive(Clone, Copy)]
pub struct Cause(&'static dyn Kind);

impl Cause {
    /// All of them, in the order in which they are listed.
    pub const ALL: [Self; 15] = [
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
        Self(&zero_step::ZeroStep),
        Self(&hysteresis_shape::HysteresisShape),
    ];

    /// The name in commands and files.
    pub fn name(self) -> &'static str {
        self.about().name
    }

    /// What it is, for people: a sentence without its full stop.
    pub fn meaning(self) -> &'static str {
        self.about().meaning
    }

    /// The law by which it acts.
    pub fn law(self) -> Law {
        self.about().law
    }

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
        let own = |cause: Self| cause.about().in_valve.map(|(own, name)| (own, (cause, name)));
        Self::ALL.into_iter().filter_map(own).find(|(own, _)| *own == part).map(|(_, found)| found)
    }

    /// The causes that it is most easily taken for, the likeliest first.
    pub fn rivals(self) -> impl Iterator<Item = Self> {
        self.about().taken_for.iter().filter_map(|name| Self::of_name(name))
    }

    /// Whether it acts within fractions of a second.
    pub fn is_fast(self) -> bool {
        self.law() == Law::Delay || self.resists_motion()
    }

    /// Whether it does the same whenever the input goes the same way: what the form of a model gets wrong over time is not like it.
    pub fn acts_at_once(self) -> bool {
        self.is_fast() || self.law() == Law::Ceiling
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

/// The cause of a name, for tests.
#[cfg(test)]
pub fn cause(name: &str) -> Cause {
    Cause::of_name(name).unwrap_or_else(|| panic!("no cause is called {name}"))
}

#[cfg(test)]
mod tests {
    use super::kind::About;
    use super::*;

    #[test]
    fn each_cause_has_a_name_of_its_own_and_names_only_others_that_there_are() {
        for (place, cause) in Cause::ALL.into_iter().enumerate() {
            assert_eq!(Cause::ALL.iter().position(|other| *other == cause), Some(place), "{cause}");
            let About { taken_for, told_from, .. } = cause.about();
            let named = taken_for.iter().chain(told_from.iter().map(|(name, _)| name));
            for name in named {
                assert!(Cause::of_name(name).is_some_and(|other| other != cause), "{cause}: {name}");
            }
        }
    }

    #[test]
    fn a_pair_that_an_experiment_tells_apart_is_in_one_file_alone() {
        for cause in Cause::ALL {
            for (name, _) in cause.about().told_from {
                let names = |(back, _): &(&str, &str)| *back == cause.name();
                assert!(!super::cause(name).about().told_from.iter().any(names), "{cause}: {name}");
            }
        }
    }

    #[test]
    fn the_page_on_adding_a_cause_shows_a_file_as_it_is() {
        let (page, file) = (include_str!("../../../../docs/add-a-cause.md"), include_str!("drift.rs"));
        let behind_uses = file.split_once("\n\n///").expect("a file").1;
        assert!(page.contains(behind_uses.trim_end()));
    }
}
