//! A strictly increasing piecewise-linear curve, evaluated in both directions by a search for the segment.
//!
//! The common form of the dead-zone stage and of the piecewise-linear envelope.

use heapless::Vec;

use crate::error::{Check, ParameterError, Requirement};
use crate::real::Real;

#[derive(Clone, Copy, Debug, PartialEq)]
struct Segment<T> {
    /// A point on it: where it starts, or any point of the first segment.
    x: T,
    y: T,
    slope: T,
    reciprocal_slope: T,
}

/// A curve of at most `K` + 1 segments; the first and the last go on without end.
#[derive(Clone, Debug, PartialEq)]
pub struct MonotoneCurve<T, const K: usize> {
    first: Segment<T>,
    rest: Vec<Segment<T>, K>,
}

impl<T: Real, const K: usize> MonotoneCurve<T, K> {
    /// A straight line through a point.
    ///
    /// # Errors
    /// The slope, which `check` names, or its reciprocal is not above 0 and finite.
    pub(crate) fn line(point: (T, T), slope: T, check: Check) -> Result<Self, ParameterError> {
        Ok(Self { first: Segment::try_new(point, slope, check)?, rest: Vec::new() })
    }

    /// Goes on from `point`, a point of the last segment and beyond its start, with another slope.
    ///
    /// # Errors
    /// As for [`line`](Self::line); or there is no room for another segment.
    pub(crate) fn bend(&mut self, point: (T, T), slope: T, check: Check) -> Result<(), ParameterError> {
        let segment = Segment::try_new(point, slope, check)?;
        self.rest.push(segment).map_err(|_| check.length(K + 2, Requirement::AtMost((K + 1) as f64)))
    }

    /// y at x.
    pub fn value(&self, x: T) -> T {
        let segment = self.segment(|segment| segment.x <= x);
        segment.y + segment.slope * (x - segment.x)
    }

    /// x at y.
    pub fn inverse(&self, y: T) -> T {
        let segment = self.segment(|segment| segment.y <= y);
        segment.x + segment.reciprocal_slope * (y - segment.y)
    }

    /// The smallest slope.
    pub fn smallest_slope(&self) -> T {
        self.rest.iter().fold(self.first.slope, |least, s| if s.slope < least { s.slope } else { least })
    }

    /// The last segment that has started; the first where none has.
    fn segment(&self, started: impl Fn(&Segment<T>) -> bool) -> &Segment<T> {
        let started = self.rest.partition_point(started);
        self.rest.get(started.wrapping_sub(1)).unwrap_or(&self.first)
    }
}

impl<T: Real> Segment<T> {
    fn try_new((x, y): (T, T), slope: T, check: Check) -> Result<Self, ParameterError> {
        let slope = check.above(slope, T::ZERO)?;
        let reciprocal_slope = check.named("reciprocal slope").finite(T::ONE / slope)?;
        Ok(Self { x, y, slope, reciprocal_slope })
    }
}
