//! A monotone piecewise-linear envelope through a handful of knots, and its exact inverse.
//!
//! The tanh envelope bounds how well a muscle can be described (its error falls from 0.8 to 0.4 mm
//! with twelve free knots); it also costs an atanh each tick, where this one costs a search among
//! the knots.

use crate::curve::MonotoneCurve;
use crate::envelope::Envelope;
use crate::error::{Check, ParameterError, Requirement};
use crate::list::List;
use crate::range::Range;
use crate::real::Real;

/// Raw parameters: the knots, at least two, both coordinates strictly increasing.
///
/// ```
/// use model_core::List;
/// use model_core::envelope::{PiecewiseLinear, PiecewiseLinearParameters};
///
/// let list = |numbers: [f64; 3]| List::<f64, 4>::from_iter(numbers);
/// let flat = PiecewiseLinearParameters { inputs: list([0.0, 1.0, 2.0]), values: list([0.0, 1.0, 1.0]) };
/// assert!(PiecewiseLinear::try_new(&flat).is_err()); // a level piece has no inverse
/// ```
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(
    feature = "serde",
    derive(serde::Serialize, serde::Deserialize),
    serde(bound = "T: Real + serde::Serialize + serde::de::DeserializeOwned")
)]
pub struct PiecewiseLinearParameters<T, const K: usize> {
    /// Inputs of the knots. Input unit.
    pub inputs: List<T, K>,
    /// The envelope there. Unit: 1.
    pub values: List<T, K>,
}

/// A validated envelope of at most `K` knots; outside them the end segments go on.
///
/// ```
/// use model_core::List;
/// use model_core::envelope::{Envelope, PiecewiseLinear, PiecewiseLinearParameters};
///
/// let list = |numbers: [f64; 3]| List::<f64, 4>::from_iter(numbers);
/// let knots = PiecewiseLinearParameters { inputs: list([0.0, 1.0, 6.0]), values: list([0.0, 2.0, 3.0]) };
/// let envelope = PiecewiseLinear::try_new(&knots)?;
/// assert_eq!(envelope.value(0.5), 1.0);
/// assert_eq!(envelope.inverse(2.5), 3.5);
/// # Ok::<(), Box<dyn core::error::Error>>(())
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct PiecewiseLinear<T, const K: usize> {
    curve: MonotoneCurve<T, K>,
}

impl<T: Real, const K: usize> PiecewiseLinear<T, K> {
    /// # Errors
    /// Fewer than two knots, lists of different length, a coordinate that does not increase or is
    /// not finite, a slope outside the number type.
    pub fn try_new(parameters: &PiecewiseLinearParameters<T, K>) -> Result<Self, ParameterError> {
        let PiecewiseLinearParameters { inputs, values } = parameters;
        if values.len() != inputs.len() {
            let requirement = Requirement::Exactly(inputs.len() as f64);
            return Err(Check::new("number of knot values", "").length(values.len(), requirement));
        }
        let mut knots = inputs.iter().copied().zip(values.iter().copied()).enumerate();
        let (Some((_, first)), true) = (knots.next(), inputs.len() >= 2) else {
            return Err(Check::new("knots", "").length(inputs.len(), Requirement::AtLeast(2.0)));
        };
        Check::at("knot inputs", 0, "input unit").finite(first.0)?;
        Check::at("knot values", 0, "").finite(first.1)?;
        let mut curve = None;
        let mut last = first;
        for (i, knot) in knots {
            Check::at("knot inputs", i, "input unit").above(knot.0, last.0)?;
            Check::at("knot values", i, "").above(knot.1, last.1)?;
            let slope = (knot.1 - last.1) / (knot.0 - last.0);
            let check = Check::at("knot slopes", i, "1/input unit");
            match &mut curve {
                None => curve = Some(MonotoneCurve::line(last, slope, check)?),
                Some(curve) => curve.bend(last, slope, check)?,
            }
            last = knot;
        }
        match curve {
            Some(curve) => Ok(Self { curve }),
            None => Err(Check::new("knots", "").length(inputs.len(), Requirement::AtLeast(2.0))),
        }
    }
}

impl<T: Real, const K: usize> Envelope<T> for PiecewiseLinear<T, K> {
    fn value(&self, x: T) -> T {
        self.curve.value(x)
    }

    #[inline(always)]
    fn inverse(&self, v: T) -> T {
        self.curve.inverse(v)
    }

    fn counted_from(&self, v: f64) -> Option<Self> {
        Some(Self { curve: self.curve.counted_from(0.0, v) })
    }

    /// That over all knots, whatever the range.
    fn least_slope(&self, _: &Range<T>) -> T {
        self.curve.smallest_slope()
    }
}
