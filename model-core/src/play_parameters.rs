//! The raw parameters of a bank of plays, see [`crate::play`].

use crate::convert;
use crate::error::{Check, ParameterError, Requirement};
use crate::list::List;
use crate::real::Real;

/// Raw parameters of a bank of at most `N` plays.
///
/// ```
/// use model_core::play::PlayParameters;
///
/// // Equations (9) and (10): equally spaced thresholds, weights that fade.
/// let plays = PlayParameters::<f64, 3>::exponential(3, 0.3, 0.2, 5.0, 0.1)?;
/// assert!((plays.thresholds[2] - 0.3).abs() < 1e-15);
/// assert!(plays.weights[0] > plays.weights[1] && plays.weights[1] > plays.weights[2]);
/// assert!(PlayParameters::<f64, 3>::exponential(4, 0.3, 0.2, 5.0, 0.1).is_err()); // no room for four
/// # Ok::<(), Box<dyn core::error::Error>>(())
/// ```
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(
    feature = "serde",
    derive(serde::Serialize, serde::Deserialize),
    serde(bound = "T: Real + serde::Serialize + serde::de::DeserializeOwned")
)]
pub struct PlayParameters<T, const N: usize> {
    /// Weight of the direct term. Unit: 1, above 0.
    pub q: T,
    /// Thresholds r, strictly increasing and above 0. Unit: that of the inner coordinate (1).
    pub thresholds: List<T, N>,
    /// Weights p, as many as thresholds. Unit: 1.
    pub weights: List<T, N>,
}

impl<T: Real, const N: usize> PlayParameters<T, N> {
    /// Equally spaced thresholds rᵢ = α i, equation (9), with weights pᵢ = ρ exp(-τ rᵢ), equation
    /// (10), for i = 1 … `count`.
    ///
    /// # Errors
    /// `count` is above the capacity `N`.
    pub fn exponential(count: usize, q: T, rho: T, tau: T, alpha: T) -> Result<Self, ParameterError> {
        let mut parameters = Self { q, thresholds: List::new(), weights: List::new() };
        let too_many = |_| Check::new("plays", "").length(count, Requirement::AtMost(N as f64));
        for i in 1..=count {
            let threshold = alpha * T::from_f64(i as f64);
            parameters.thresholds.push(threshold).map_err(too_many)?;
            parameters.weights.push(rho * (-tau * threshold).exp()).map_err(too_many)?;
        }
        Ok(parameters)
    }

    /// The same parameters in another number type or capacity.
    ///
    /// # Errors
    /// The other capacity is too small.
    pub fn convert<U: Real, const N2: usize>(&self) -> Result<PlayParameters<U, N2>, ParameterError> {
        Ok(PlayParameters {
            q: convert::number(self.q),
            thresholds: convert::list("plays", &self.thresholds)?,
            weights: convert::list("plays", &self.weights)?,
        })
    }
}
