//! Hysteresis models of pneumatic artificial muscles, their inverses, and the controller built on
//! them.
//!
//! # Design
//! One operator a file, forward and inverse side by side. Raw parameters (`…Parameters`, plain
//! public fields) are checked once by a `try_new` and become an immutable operator; what changes
//! from sample to sample is a small state of its own. Only operators that passed the check can be
//! put into a [`tracking::Tracking`] controller.
//!
//! | module | what it is | source |
//! |---|---|---|
//! | [`envelope`] | the tanh curve that shapes every play | (11) |
//! | [`play`] | bank of weighted plays and its inverse, which is a bank again | (6), (7), (18), (19), (21) |
//! | [`dead_zone`] | weighted dead zones and their inverse | (12) to (14), (20) |
//! | [`cascade`] | the cascade of the three, and the inverse cascade | (16), (17) |
//! | [`cpi`], [`sgpi`], [`mpi`], [`mgpi`] | the cascades that have a name | (6), (16) |
//! | [`agpi`] | two envelopes | (2) to (8) |
//! | [`egpi`], [`memoryless`] | two envelopes and a memoryless function | |
//! | [`model`] | one of them, chosen at run time | |
//! | [`extension`] | what a muscle on a valve does beside hysteresis, and its compensation | |
//! | [`pid`] | the feedback controller | (24) |
//! | [`observer`] | gains by the slope of the inverse | |
//! | [`adaptation`] | offset, gain and width that follow the muscle | |
//! | [`tracking`] | feed-forward plus feedback, limits, slew | Fig. 10 |
//! | [`joint`] | two muscles at one axis: model, and control of angle and stiffness | |
//! | [`paper`] | the paper's Tables 1 and 2 as a model | |
//!
//! Equation and table numbers are those of the paper on the modified generalized Prandtl-Ishlinskii
//! (MGPI) model of pneumatic artificial muscles.
//!
//! # Contract
//! * `no_std`, no heap, no `unsafe`; every loop is bounded by a const capacity.
//! * Generic over `f32` (board) and `f64` (host). Elementary functions come from `libm` on both, so
//!   that the same inputs give the same bits on the board, in the emulator and on the host.
//! * A non-finite input is refused by a typed error and leaves the state as it was.
//!
//! # Capacity
//! `N` is the largest number of plays, `M` of dead zones, that a type can hold; the numbers in use
//! are those of the parameters.
#![no_std]
#![forbid(unsafe_code)]
#![cfg_attr(
    not(test),
    deny(clippy::unwrap_used, clippy::expect_used, clippy::indexing_slicing, clippy::panic)
)]

pub mod adaptation;
pub mod agpi;
pub mod atanh;
pub mod cascade;
mod convert;
pub mod cpi;
pub mod curve;
pub mod dead_zone;
mod direction;
pub mod egpi;
pub mod envelope;
pub mod error;
pub mod extension;
mod few_plays;
pub mod hysteresis;
pub mod joint;
pub mod law;
pub mod list;
mod loading_curve;
pub mod memoryless;
pub mod mgpi;
pub mod model;
pub mod mpi;
pub mod observer;
pub mod paper;
pub mod pid;
pub mod play;
mod play_move;
mod play_parameters;
mod play_state;
pub mod range;
pub mod real;
pub mod sgpi;
pub mod tracking;
mod turn_stack;
mod turning_points;

pub use error::{InputError, ParameterError, Requirement};
pub use extension::{ExtendedInverse, ExtendedModel, ExtensionParameters, Surroundings};
pub use hysteresis::{Hysteresis, HysteresisState, InverseHysteresis, Invertible};
pub use list::List;
pub use mgpi::{InverseMgpi, Mgpi, MgpiParameters};
pub use model::{InverseModel, Kind, Model, ModelParameters};
pub use observer::ObserverParameters;
pub use play::PlayState;
pub use range::Range;
pub use real::Real;
pub use tracking::{Measured, Mode, Tracking, TrackingParameters, TrackingState};
