//! The tanh envelope γ(x) = c0 tanh(c1 x + c2) + c3 of equation (11), and its inverse.
//!
//! It turns the input (pressure) into the inner coordinate v that drives the plays. It saturates as
//! the muscle does, and carries no memory.
//!
//! # Limits
//! The inverse exists inside (c3 - c0, c3 + c0) only. Values and arguments of the inverse are kept
//! a few roundings inside it, so that the answer is always finite.

use crate::convert;
use crate::envelope::Envelope;
use crate::error::{Check, ParameterError};
use crate::range::Range;
use crate::real::Real;

/// Raw parameters of the envelope, equation (11).
///
/// ```
/// use model_core::envelope::{TanhEnvelope, TanhParameters};
///
/// // An envelope that does not rise has no inverse.
/// let falling = TanhParameters { c1: -0.3, ..model_core::paper::ENVELOPE };
/// assert_eq!(TanhEnvelope::try_new(falling).unwrap_err().parameter, "c1");
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct TanhParameters<T> {
    /// Half of the height. Unit: 1, above 0.
    pub c0: T,
    /// Steepness. Unit: 1/input unit, above 0.
    pub c1: T,
    /// Shift along the input. Unit: 1.
    pub c2: T,
    /// Middle of the height. Unit: 1.
    pub c3: T,
}

impl<T: Real> TanhParameters<T> {
    /// The same parameters in another number type.
    pub fn convert<U: Real>(&self) -> TanhParameters<U> {
        let Self { c0, c1, c2, c3 } = *self;
        TanhParameters {
            c0: convert::number(c0),
            c1: convert::number(c1),
            c2: convert::number(c2),
            c3: convert::number(c3),
        }
    }
}

/// A validated envelope.
///
/// ```
/// use model_core::envelope::{Envelope, TanhEnvelope};
///
/// let envelope = TanhEnvelope::try_new(model_core::paper::ENVELOPE)?;
/// assert!(envelope.value(3.1) > envelope.value(3.0)); // it rises,
/// assert!((envelope.inverse(envelope.value(3.0)) - 3.0).abs() < 1e-12); // so that it has an inverse
/// # Ok::<(), Box<dyn core::error::Error>>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TanhEnvelope<T> {
    parameters: TanhParameters<T>,
    /// The largest and smallest values, a few roundings inside c3 - c0 and c3 + c0.
    low: T,
    high: T,
    /// How far these are from 0 without the roundings: c0 - c3 and c0 + c3.
    below: T,
    above: T,
    reciprocal_c1: T,
    /// The input at the middle of the height, -c2/c1.
    centre: T,
}

impl<T: Real> TanhEnvelope<T> {
    /// # Errors
    /// c0 or c1 not above 0, any of the four (or -c2/c1, 1/c1) not finite, or a height lost in the
    /// rounding of c3.
    pub fn try_new(parameters: TanhParameters<T>) -> Result<Self, ParameterError> {
        let TanhParameters { c0, c1, c2, c3 } = parameters;
        let c0 = Check::new("c0", "").above(c0, T::ZERO)?;
        let c1 = Check::new("c1", "1/input unit").above(c1, T::ZERO)?;
        let c2 = Check::new("c2", "").finite(c2)?;
        let c3 = Check::new("c3", "").finite(c3)?;
        let reciprocal_c1 = Check::new("1/c1", "input unit").finite(T::ONE / c1)?;
        let centre = Check::new("-c2/c1", "input unit").finite(-c2 / c1)?;
        let margin = T::from_f64(4.0) * T::EPSILON * (c0 + c3.abs());
        let low = Check::new("c3 - c0", "").finite(c3 - c0 + margin)?;
        let high = Check::new("c3 + c0", "").above(c3 + c0 - margin, low)?;
        let (below, above) = (c0 - c3, c0 + c3);
        Ok(Self { parameters, low, high, below, above, reciprocal_c1, centre })
    }
}

impl<T: Real> Envelope<T> for TanhEnvelope<T> {
    fn value(&self, x: T) -> T {
        let TanhParameters { c0, c1, c2, c3 } = self.parameters;
        (c0 * (c1 * x + c2).tanh() + c3).limit(self.low, self.high)
    }

    fn inverse(&self, v: T) -> T {
        self.inverse_inside(v.limit(self.low, self.high))
    }

    /// γ⁻¹(v) = (atanh((v - c3)/c0) - c2)/c1. Half the distances from the two ends, c0 + (v - c3)
    /// and c0 - (v - c3), take the place of the quotient.
    #[inline(always)]
    fn inverse_inside(&self, v: T) -> T {
        T::atanh_of_ratio(self.below + v, self.above - v) * self.reciprocal_c1 + self.centre
    }

    fn counted_from(&self, v: f64) -> Option<Self> {
        let TanhParameters { c0, c3, .. } = self.parameters;
        let (c0, moved) = (c0.to_f64(), c3.to_f64() - v);
        Some(Self {
            parameters: TanhParameters { c3: T::from_f64(moved), ..self.parameters },
            low: convert::counted_from(self.low, v),
            high: convert::counted_from(self.high, v),
            below: T::from_f64(c0 - moved),
            above: T::from_f64(c0 + moved),
            ..*self
        })
    }

    fn values(&self) -> (T, T) {
        (self.low, self.high)
    }

    /// γ' = c0 c1 (1 - tanh²) has its least value at one of the ends.
    fn least_slope(&self, range: &Range<T>) -> T {
        let TanhParameters { c0, c1, c2, .. } = self.parameters;
        let slope = |x| {
            let tanh = (c1 * x + c2).tanh();
            c0 * c1 * (T::ONE - tanh * tanh)
        };
        let (low, high) = (slope(range.min()), slope(range.max()));
        if low < high { low } else { high }
    }
}
