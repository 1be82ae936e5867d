//! A pneumatic muscle on its valve as physics: a plant to record from and to test controllers against.
//!
//! The muscle is a balance of forces ([`muscle`]), the valve a limited first-order lag ([`valve`]), the
//! sensors add seeded noise ([`sensor`]); [`plant`] composes them, [`protocol`] drives them, [`recording`]
//! and [`serve`] are the two ways out: a CSV file, and a dialogue line by line. All physical parameters stand
//! in [`parameters`].
//!
//! The rig deliberately shares no code with the models that are identified from it: what they cannot follow
//! is an honest error of structure. The same seed gives the same run.

#![forbid(unsafe_code)]

mod braid;
mod bristle;
pub mod muscle;
pub mod output;
pub mod parameters;
pub mod plant;
pub mod protocol;
pub mod recording;
pub mod sensor;
pub mod serve;
pub mod valve;
