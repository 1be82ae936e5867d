//! A memoryless cubic curve g(x) over the input range, which the extended generalized model adds.
//!
//! In Bernstein form, g = Σ δₖ Sₖ(t), k = 1 … 3, with t = 0 … 1 over the range and Sₖ = Σ_{j≥k}
//! C(3, j) tʲ (1 - t)³⁻ʲ, which rises from 0 to 1: so g is 0 at the lower end, the slope lies
//! between 3 min δ and 3 max δ per range, and δ ≥ 0 makes it non-decreasing. Any cubic with g = 0
//! at the lower end has this form. Outside the range it keeps its end values.

use crate::convert;
use crate::error::{Check, ParameterError};
use crate::range::Range;
use crate::real::Real;

/// Degree of the curve, and number of its parameters.
pub const DEGREE: usize = 3;

/// Raw parameters: the rises δ. Unit: output unit.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(
    feature = "serde",
    derive(serde::Serialize, serde::Deserialize),
    serde(bound = "T: Real + serde::Serialize + serde::de::DeserializeOwned")
)]
pub struct MemorylessParameters<T> {
    /// δ₁ … δ₃.
    pub rises: [T; DEGREE],
}

impl<T: Real> MemorylessParameters<T> {
    /// The same parameters in another number type.
    pub fn convert<U: Real>(&self) -> MemorylessParameters<U> {
        MemorylessParameters { rises: self.rises.map(convert::number) }
    }
}

/// A validated memoryless curve.
///
/// ```
/// use model_core::Range;
/// use model_core::memoryless::{Memoryless, MemorylessParameters};
///
/// let range = Range::try_new(0.0, 6.0, "input range", "bar")?;
/// let curve = Memoryless::try_new(&MemorylessParameters { rises: [1.0, 2.0, 3.0] }, &range)?;
/// assert_eq!((curve.value(0.0), curve.value(6.0)), (0.0, 6.0)); // from 0 to the sum of the rises
/// assert!(curve.value(4.0) > curve.value(2.0)); // no rise is negative: the curve does not fall
/// # Ok::<(), Box<dyn core::error::Error>>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Memoryless<T> {
    rises: [T; DEGREE],
    low: T,
    reciprocal_span: T,
}

impl<T: Real> Memoryless<T> {
    /// # Errors
    /// A rise that is not finite.
    pub fn try_new(parameters: &MemorylessParameters<T>, range: &Range<T>) -> Result<Self, ParameterError> {
        for (i, &rise) in parameters.rises.iter().enumerate() {
            Check::at("rises of the memoryless function", i, "output unit").finite(rise)?;
        }
        let span = range.max() - range.min();
        let reciprocal_span = Check::new("1/input range", "1/input unit").finite(T::ONE / span)?;
        Ok(Self { rises: parameters.rises, low: range.min(), reciprocal_span })
    }

    /// g(x). Unit: output unit.
    pub fn value(&self, x: T) -> T {
        let [one, two, three] = self.basis(x);
        let [first, second, third] = self.rises;
        first * one + second * two + third * three
    }

    /// S₁ … S₃ at x: the derivatives of g by the rises.
    pub fn basis(&self, x: T) -> [T; DEGREE] {
        let t = ((x - self.low) * self.reciprocal_span).limit(T::ZERO, T::ONE);
        let rest = T::ONE - t;
        let three = T::from_f64(3.0);
        let (last, middle) = (t * t * t, three * t * t * rest);
        [last + middle + three * t * rest * rest, last + middle, last]
    }

    /// Bounds of the values over the range: the curve lies between its partial sums of rises. Unit:
    /// output unit.
    pub fn values(&self) -> (T, T) {
        let (mut sum, mut low, mut high) = (T::ZERO, T::ZERO, T::ZERO);
        for rise in self.rises {
            sum += rise;
            low = if sum < low { sum } else { low };
            high = if sum > high { sum } else { high };
        }
        (low, high)
    }

    /// Bounds of the slope. Unit: output unit/input unit.
    pub fn slopes(&self) -> (T, T) {
        let scale = T::from_f64(DEGREE as f64) * self.reciprocal_span;
        let [first, ..] = self.rises;
        let (mut low, mut high) = (first, first);
        for rise in self.rises {
            low = if rise < low { rise } else { low };
            high = if rise > high { rise } else { high };
        }
        (low * scale, high * scale)
    }
}
