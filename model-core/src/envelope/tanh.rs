//! The tanh envelope γ(x) = c0 tanh(c1 x + c2) + c3 of equation (11), and its inverse.
//!
//! It turns the input (pressure) into the inner coordinate v that drives the plays. It saturates as the
//! muscle does, and carries no memory.
//!
//! # Limits
//! The inverse exists inside (c3 - c0, c3 + c0) only. Outside, and closer to the ends than the number type
//! can resolve, its argument is clamped, so that the answer is always finite.

use crate::envelope::Envelope;
use crate::error::{Check, ParameterError};
use crate::range::Range;
use crate::real::Real;

/// Raw parameters of the envelope, equation (11).
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

/// A validated envelope.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TanhEnvelope<T> {
    parameters: TanhParameters<T>,
    reciprocal_c0: T,
    reciprocal_c1: T,
    /// The largest argument of atanh whose value is finite and still means something.
    largest_argument: T,
}

impl<T: Real> TanhEnvelope<T> {
    /// # Errors
    /// c0 or c1 not above 0, or any of the four (or a reciprocal) not finite.
    pub fn try_new(parameters: TanhParameters<T>) -> Result<Self, ParameterError> {
        let TanhParameters { c0, c1, c2, c3 } = parameters;
        let c0 = Check::new("c0", "").above(c0, T::ZERO)?;
        let c1 = Check::new("c1", "1/input unit").above(c1, T::ZERO)?;
        Check::new("c2", "").finite(c2)?;
        Check::new("c3", "").finite(c3)?;
        let reciprocal_c0 = Check::new("1/c0", "").finite(T::ONE / c0)?;
        let reciprocal_c1 = Check::new("1/c1", "input unit").finite(T::ONE / c1)?;
        Ok(Self { parameters, reciprocal_c0, reciprocal_c1, largest_argument: T::ONE - T::EPSILON })
    }
}

impl<T: Real> Envelope<T> for TanhEnvelope<T> {
    fn value(&self, x: T) -> T {
        let TanhParameters { c0, c1, c2, c3 } = self.parameters;
        c0 * (c1 * x + c2).tanh() + c3
    }

    /// γ⁻¹(v) = (atanh((v - c3)/c0) - c2)/c1.
    fn inverse(&self, v: T) -> T {
        let argument = ((v - self.parameters.c3) * self.reciprocal_c0)
            .limit(-self.largest_argument, self.largest_argument);
        (argument.atanh() - self.parameters.c2) * self.reciprocal_c1
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
