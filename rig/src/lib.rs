//! A pneumatic muscle on its valve as physics: a plant to record from and to test controllers
//! against.
//!
//! The muscle is a balance of forces ([`muscle`]), the valve a limited first-order lag ([`valve`]),
//! the sensors add seeded noise ([`sensor`]); [`plant`] composes them, [`protocol`] drives them,
//! [`recording`] and [`serve`] are the two ways out: a CSV file, and a dialogue line by line. All
//! physical parameters stand in [`parameters`]; [`command`] are the commands that offer all this.
//!
//! Effects can be hidden in it ([`effect`], [`effects`]), each in its physical place, and what is
//! hidden is told to those who ask ([`truth`]). A second muscle, an operator model ([`operator`]),
//! has the same effects in other forms.
//!
//! Two such muscles at one axis are a [`joint`].
//!
//! The rig deliberately shares no code with the models that are identified from it: what they
//! cannot follow is an honest error of structure. The same seed gives the same run.

#![forbid(unsafe_code)]

pub mod body;
mod braid;
mod bristle;
pub mod command;
mod creep;
mod delay;
mod draw;
pub mod dynamics;
pub mod effect;
pub mod effects;
mod gauge;
pub mod joint;
pub mod muscle;
pub mod operator;
pub mod output;
pub mod parameters;
pub mod plant;
pub mod protocol;
pub mod recording;
pub mod scale;
pub mod sensitivity;
pub mod sensor;
pub mod serve;
pub mod set_point;
pub mod surroundings;
pub mod truth;
pub mod valve;
mod wander;
pub mod zoo;
