//! Models on the host: sizes for which any model of the family has room, and what a model says of
//! an input.

pub mod named;

use model_core::{ExtendedModel, Hysteresis, Model, ModelParameters};

/// The largest number of plays of a model on the host.
pub const PLAYS: usize = 128;
/// The largest number of dead zones of a model on the host.
pub const DEAD_ZONES: usize = 128;
/// Raw parameters of a model on the host.
pub type HostParameters = ModelParameters<f64, PLAYS, DEAD_ZONES>;
/// A model on the host.
pub type HostModel = Model<f64, PLAYS, DEAD_ZONES>;
/// A model with its extensions on the host.
pub type HostExtendedModel = ExtendedModel<f64, PLAYS, DEAD_ZONES>;

/// What the thresholds and weights of the plays come from.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Density {
    /// Equations (9) and (10).
    Exponential {
        /// Weight of a play of threshold 0.
        rho: f64,
        /// Decay of the weights with the threshold.
        tau: f64,
        /// Distance of the thresholds.
        alpha: f64,
    },
    /// Equally spaced thresholds, equation (9), each with a weight of its own.
    Free {
        /// Distance of the thresholds.
        alpha: f64,
    },
}

/// The model's output for every input, from rest; the inputs are finite.
///
/// ```
/// use recording::model::{HostModel, HostParameters, simulate};
///
/// let muscle = HostParameters::Cascade(model_core::paper::mgpi()?.convert()?);
/// let answer = simulate(&HostModel::try_new(&muscle)?, &[0.0, 6.0, 3.0, 6.0, 3.0]);
/// assert!((answer[4] - answer[2]).abs() < 1e-9); // mm: a loop between 3 and 6 bar closes
/// # Ok::<(), Box<dyn core::error::Error>>(())
/// ```
pub fn simulate(model: &HostModel, input: &[f64]) -> Vec<f64> {
    let mut state = model.rest_state();
    input.iter().map(|&x| model.step(&mut state, x).unwrap_or(f64::NAN)).collect()
}
