//! Recordings of a muscle, or of anything with hysteresis: tables of many loggers, units, columns;
//! and model files, what a model is worth, and its answer to a recording.
//!
//! # Design
//! A [`table::Table`] is a file as it stands; a [`Recording`] is what is used of it: times, an
//! input, an output, each with its unit, and which rows count. What was mended on the way is said
//! in notes. A [`model_file::ModelFile`] is a model with its units and figures. Whatever goes wrong
//! is an error that names file, line and column. [`lateness`] is what a recording shows of time and
//! noise beside its model.
//!
//! # Limits
//! A recording is held in memory, 8 bytes a value.

pub mod course;
pub mod day;
pub mod drop_out;
pub mod figures;
pub mod history;
pub mod input;
mod joined;
pub mod joint;
pub mod lateness;
pub mod left_out;
pub mod model;
pub mod model_file;
pub mod noise;
pub mod numbers;
mod recording;
pub mod simulation;
#[cfg(test)]
mod synthetic;
pub mod table;
mod transients;
pub mod turning;
pub mod unit;
pub mod valve_order;
mod viscosity;
pub mod worth;

pub use joined::Rest;
pub use recording::*;

/// Name and version of this tool, as files and reports carry them.
pub const TOOL: &str = concat!("mgpi ", env!("CARGO_PKG_VERSION"));
