//! The coordinates that the optimiser moves in.
//!
//! Each is bounded; it is a smooth function of an unbounded variable (half a tanh of it across the
//! range), since the Levenberg-Marquardt kernel knows no bounds.

use nalgebra::DVector;

/// A coordinate's range, and the part of it where searches start.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Coordinate {
    /// Lower and upper bound.
    pub bounds: (f64, f64),
    /// Lower and upper end of the starts.
    pub starts: (f64, f64),
}

impl Coordinate {
    /// A coordinate with its bounds and the range of its starts.
    pub fn new(bounds: (f64, f64), starts: (f64, f64)) -> Self {
        Self { bounds, starts }
    }

    /// The logarithm of a positive quantity with these bounds and starts.
    pub fn logarithm(bounds: (f64, f64), starts: (f64, f64)) -> Self {
        let logarithms = |(low, high): (f64, f64)| (low.ln(), high.ln());
        Self::new(logarithms(bounds), logarithms(starts))
    }

    fn middle(&self) -> f64 {
        (self.bounds.0 + self.bounds.1) / 2.0
    }

    fn half(&self) -> f64 {
        (self.bounds.1 - self.bounds.0) / 2.0
    }

    /// Whether a value stands at a bound, within a thousandth of the range.
    pub fn is_at_bound(&self, value: f64) -> bool {
        let margin = 2e-3 * self.half();
        value < self.bounds.0 + margin || value > self.bounds.1 - margin
    }
}

/// The coordinates at the unbounded variables, and their derivatives by them.
pub fn bounded(coordinates: &[Coordinate], variables: &DVector<f64>) -> (Vec<f64>, Vec<f64>) {
    let at = |(coordinate, variable): (&Coordinate, &f64)| {
        let tanh = variable.tanh();
        (coordinate.middle() + coordinate.half() * tanh, coordinate.half() * (1.0 - tanh * tanh))
    };
    coordinates.iter().zip(variables.iter()).map(at).unzip()
}

/// The unbounded variables of values; those at a bound are taken a little inside.
pub fn unbounded(coordinates: &[Coordinate], values: &[f64]) -> DVector<f64> {
    let at = |(coordinate, value): (&Coordinate, &f64)| {
        ((value - coordinate.middle()) / coordinate.half()).clamp(-0.999, 0.999).atanh()
    };
    DVector::from_iterator(values.len(), coordinates.iter().zip(values).map(at))
}
