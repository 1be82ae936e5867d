//! What a model gets wrong, and why.

pub mod anatomy;
pub mod cause;
