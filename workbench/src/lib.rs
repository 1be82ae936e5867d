//! Everything that is done with a muscle on a desk: read its recordings, identify and simulate its model, run
//! the firmware in the loop, draw the reports. The command `mgpi` is this library's face.
//!
//! # Design
//! Each command is a file in [`commands`]; it reads (strictly), works, and writes all of its outputs at the
//! end and at once, or none. Whatever goes wrong is an [`Error`] whose message names the place.

/// Says a line for people ([`output::say`]).
macro_rules! say {
    ($($words:tt)*) => { crate::output::say(format_args!($($words)*)) };
}

pub mod backup;
pub mod bus;
pub mod child;
pub mod commands;
pub mod comparison;
pub mod course;
pub mod diagnosis;
pub mod direction;
pub mod drop_out;
pub mod emulator;
pub mod error;
pub mod figures;
pub mod history;
pub mod holdout;
pub mod identification;
pub mod input;
pub mod left_out;
pub mod live;
pub mod model;
pub mod model_file;
pub mod noise;
pub mod numbers;
pub mod output;
pub mod part;
pub mod pil;
pub mod plan;
pub mod progress;
pub mod recording;
pub mod report;
pub mod simulation;
pub mod smoothing;
#[cfg(test)]
mod synthetic;
pub mod table;
pub mod turning;
pub mod unit;
pub mod worth;

pub use error::Error;

/// Name and version of this tool, as files and reports carry them.
pub const TOOL: &str = concat!("mgpi ", env!("CARGO_PKG_VERSION"));
