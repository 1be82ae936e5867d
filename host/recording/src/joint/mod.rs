//! A joint of two muscles: its recordings and its model file.
//!
//! | file | what it does |
//! |---|---|
//! | [`columns`] | a recording of both commands, both pressures, the angle and the torque |
//! | [`keys`] | the keys of its parameters, with their units |
//! | [`file`](mod@file) | the model file of a joint, format 2, both directions |

pub mod columns;
pub mod file;
pub mod keys;

/// The most stops of a joint on the host.
pub const STOPS: usize = 12;

/// Raw parameters of a joint on the host.
pub type HostJointParameters = model_core::joint::JointParameters<f64, STOPS>;
/// A joint on the host.
pub type HostJoint = model_core::joint::Joint<f64, STOPS>;
