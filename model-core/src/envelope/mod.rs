//! Envelopes: the curve γ that turns the input into the inner coordinate v which drives the plays.
//!
//! Strictly increasing and without memory. A file each: [`tanh`] (the paper's),
//! [`piecewise_linear`] (free knots), [`identity`] (linear plays, for the classical and the
//! modified model), and [`any`], which is one of the three.

pub mod any;
pub mod identity;
pub mod piecewise_linear;
pub mod tanh;

use crate::range::Range;
use crate::real::Real;

pub use any::{AnyEnvelope, EnvelopeParameters, KNOTS};
pub use identity::Identity;
pub use piecewise_linear::{PiecewiseLinear, PiecewiseLinearParameters};
pub use tanh::{TanhEnvelope, TanhParameters};

/// A validated, strictly increasing envelope.
pub trait Envelope<T: Real> {
    /// γ(x). Input: input unit; result: inner coordinate, unit 1.
    fn value(&self, x: T) -> T;

    /// γ⁻¹(v). Input: inner coordinate; result: input unit, finite for every finite v.
    fn inverse(&self, v: T) -> T;

    /// [`inverse`](Self::inverse) for v strictly within [`values`](Self::values), where it needs no
    /// care for its ends. Elsewhere the answer is meaningless.
    #[inline(always)]
    fn inverse_inside(&self, v: T) -> T {
        self.inverse(v)
    }

    /// The same envelope where v counts from an origin on; None where it cannot.
    fn counted_from(&self, _v: f64) -> Option<Self>
    where
        Self: Sized,
    {
        None
    }

    /// The ends of the open interval in which [`inverse_inside`](Self::inverse_inside) has a
    /// meaning. Unit: 1.
    fn values(&self) -> (T, T) {
        (-T::INFINITY, T::INFINITY)
    }

    /// A lower bound, above 0, of the slope of γ over a range of inputs. Unit: 1/input unit.
    fn least_slope(&self, range: &Range<T>) -> T;
}
