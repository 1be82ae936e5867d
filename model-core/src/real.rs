//! The floating-point numbers that the models are generic over.
//!
//! Elementary functions are `libm`'s for both types and on every machine: the platform's own differ
//! in the last bit, and the host could then not repeat a run of the board bit for bit. The one
//! exception, ours on every machine, is [`crate::atanh`] in `f32`.

use core::fmt::{Debug, Display};
use core::ops::{Add, AddAssign, Div, Mul, Neg, Sub, SubAssign};

/// A floating-point number: `f32` on the board, `f64` on the host.
///
/// ```
/// use model_core::Real;
///
/// fn share_left<T: Real>(time_s: T, constant_s: T) -> T {
///     (-time_s / constant_s).exp()
/// }
/// assert!((share_left(1.0_f64, 1.0) - 0.36788).abs() < 1e-5);
/// assert!((share_left(1.0_f32, 1.0) - 0.36788).abs() < 1e-5);
/// ```
pub trait Real:
    Copy
    + Debug
    + Default
    + Display
    + PartialEq
    + PartialOrd
    + Add<Output = Self>
    + AddAssign
    + Div<Output = Self>
    + Mul<Output = Self>
    + Neg<Output = Self>
    + Sub<Output = Self>
    + SubAssign
    + 'static
{
    /// 0
    const ZERO: Self;
    /// 1
    const ONE: Self;
    /// Above every finite number.
    const INFINITY: Self;
    /// The distance from 1 to the next larger number.
    const EPSILON: Self;

    /// The nearest number of this type.
    fn from_f64(value: f64) -> Self;
    /// This number in double precision.
    fn to_f64(self) -> f64;
    /// Whether this is neither infinite nor NaN.
    fn is_finite(self) -> bool;
    /// Hyperbolic tangent.
    fn tanh(self) -> Self;
    /// atanh((a - b)/(a + b)) = ½ ln(a/b) for a and b above 0, below a quarter of the largest
    /// number.
    fn atanh_of_ratio(a: Self, b: Self) -> Self;
    /// Exponential function.
    fn exp(self) -> Self;
    /// Square root of a number that is not negative.
    fn sqrt(self) -> Self;

    /// This number, or the limits that it passes. NaN stays NaN.
    fn limit(self, min: Self, max: Self) -> Self {
        if self < min { min } else { self.at_most(max) }
    }

    /// This number, or the limit that it passes. NaN stays NaN.
    ///
    /// Compare and select: on a Cortex-M4F `f32::max` and `min` are library calls, this is not.
    fn at_most(self, max: Self) -> Self {
        if self > max { max } else { self }
    }

    /// This number, or the limit that it falls below. NaN stays NaN.
    fn at_least(self, min: Self) -> Self {
        if self < min { min } else { self }
    }

    /// Magnitude.
    fn abs(self) -> Self {
        if self < Self::ZERO { -self } else { self }
    }
}

macro_rules! real {
    ($float:ident, $tanh:path, $atanh_of_ratio:path, $exp:path, $sqrt:path) => {
        impl Real for $float {
            const ZERO: Self = 0.0;
            const ONE: Self = 1.0;
            const INFINITY: Self = $float::INFINITY;
            const EPSILON: Self = $float::EPSILON;

            fn from_f64(value: f64) -> Self {
                value as Self
            }
            fn to_f64(self) -> f64 {
                self as f64
            }
            fn is_finite(self) -> bool {
                $float::is_finite(self)
            }
            fn tanh(self) -> Self {
                $tanh(self)
            }
            #[inline(always)]
            fn atanh_of_ratio(a: Self, b: Self) -> Self {
                $atanh_of_ratio(a, b)
            }
            fn exp(self) -> Self {
                $exp(self)
            }
            fn sqrt(self) -> Self {
                $sqrt(self)
            }
        }
    };
}

real!(f32, libm::tanhf, crate::atanh::atanh_of_ratio, libm::expf, libm::sqrtf);
real!(f64, libm::tanh, atanh_of_ratio, libm::exp, libm::sqrt);

/// In double precision, where the ratio itself may leave the number type.
fn atanh_of_ratio(a: f64, b: f64) -> f64 {
    0.5 * (libm::log(a) - libm::log(b))
}
