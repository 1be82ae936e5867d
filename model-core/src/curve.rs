//! A strictly increasing piecewise-linear curve, evaluated in both directions by a search for the
//! segment.
//!
//! The common form of the dead-zone stage and the piecewise-linear envelope. The loading curve of
//! the plays is another one (`loading_curve`), of the same segments.
//!
//! # The search
//! Unused places of the array hold segments that never start, so that its length is a constant. Up
//! to 16 segments, which is more than ten operators need, it is halved in four steps, or in fewer
//! where the array is shorter: forward without a branch, in the inverse, which the control law
//! takes, by branches, so that what is loaded stands at an address that the compiler knows. More
//! segments cost a loop.

use crate::convert::counted_from;
use crate::error::{Check, ParameterError, Requirement};
use crate::real::Real;

/// Up to this many segments the search is unrolled. A power of two.
const FEW_SEGMENTS: usize = 16;

/// A straight piece of a curve.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Segment<T> {
    /// A point on it: where it starts, or any point of the first segment.
    x: T,
    y: T,
    slope: T,
    reciprocal_slope: T,
    /// How many segments start before this one.
    pub(crate) place: usize,
}

/// x at y on those of `count` segments from a place on, by halves that overlap where the number is
/// odd: on the last that has started, or the first where none has. Unrolled: the number is known
/// where it is inlined.
macro_rules! halved {
    ($name:ident, $of_half:ident) => {
        #[inline(always)]
        fn $name(&self, from: usize, count: usize, y: T) -> T {
            let half = count / 2;
            let from_half = from + (count - half);
            let started = |segment: &Segment<T>| segment.y <= y;
            if half > 0 && self.segments.get(from_half).is_some_and(started) {
                self.$of_half(from_half, half, y)
            } else {
                self.$of_half(from, count - half, y)
            }
        }
    };
}

/// A curve of at most `K` segments; the first and the last go on without end.
#[derive(Clone, Debug, PartialEq)]
pub struct MonotoneCurve<T, const K: usize> {
    /// By rising start. At least the first one is in use.
    segments: [Segment<T>; K],
    /// How many segments are in use.
    len: usize,
}

impl<T: Real, const K: usize> MonotoneCurve<T, K> {
    /// A straight line through a point.
    ///
    /// # Errors
    /// The slope, which `check` names, or its reciprocal is not above 0 and finite; or there is no
    /// room for it.
    pub(crate) fn line(point: (T, T), slope: T, check: Check) -> Result<Self, ParameterError> {
        let mut curve = Self { segments: [Segment::never(); K], len: 0 };
        curve.bend(point, slope, check)?;
        Ok(curve)
    }

    /// Goes on from `point`, a point of the last segment and beyond its start, with another slope.
    ///
    /// # Errors
    /// As for [`line`](Self::line).
    pub(crate) fn bend(&mut self, point: (T, T), slope: T, check: Check) -> Result<(), ParameterError> {
        let segment = Segment::try_new(point, slope, self.len, check)?;
        let too_many = || check.length(K + 1, Requirement::AtMost(K as f64));
        *self.segments.get_mut(self.len).ok_or_else(too_many)? = segment;
        self.len += 1;
        Ok(())
    }

    /// The same curve where x and y count from an origin on.
    pub(crate) fn counted_from(&self, x: f64, y: f64) -> Self {
        let moved = |segment: Segment<T>| Segment {
            x: counted_from(segment.x, x),
            y: counted_from(segment.y, y),
            ..segment
        };
        Self { segments: self.segments.map(moved), len: self.len }
    }

    /// So many places the unrolled search looks at.
    const FEW: usize = if K < FEW_SEGMENTS { K } else { FEW_SEGMENTS };

    /// Whether these are all that are in use. Where the array has no more it need not be asked.
    #[inline(always)]
    fn has_few(&self) -> bool {
        K <= FEW_SEGMENTS || self.len <= FEW_SEGMENTS
    }

    /// y at x.
    pub fn value(&self, x: T) -> T {
        let started = |segment: &Segment<T>| segment.x <= x;
        let segment = match self.segments.get(..Self::FEW) {
            Some(few) if self.has_few() => halve(few, started),
            _ => self.search_many(started),
        };
        segment.map_or(x, |segment| segment.value(x))
    }

    /// x at y.
    #[inline(always)]
    pub fn inverse(&self, y: T) -> T {
        if self.has_few() { self.inverse_of_16(0, Self::FEW, y) } else { self.inverse_of_many(y) }
    }

    /// The smallest slope.
    pub fn smallest_slope(&self) -> T {
        let segments = self.segments.iter().take(self.len);
        segments.fold(T::INFINITY, |least, segment| least.at_most(segment.slope))
    }

    halved!(inverse_of_16, inverse_of_8);
    halved!(inverse_of_8, inverse_of_4);
    halved!(inverse_of_4, inverse_of_2);
    halved!(inverse_of_2, inverse_of_1);

    /// x at y on the segment at this place.
    #[inline(always)]
    fn inverse_of_1(&self, place: usize, _: usize, y: T) -> T {
        self.segments.get(place).map_or(y, |segment| segment.inverse(y))
    }

    /// Not inlined, to avoid register spills in the path of few segments.
    #[inline(never)]
    fn inverse_of_many(&self, y: T) -> T {
        self.search_many(|segment| segment.y <= y).map_or(y, |segment| segment.inverse(y))
    }

    /// The last segment that has started; the first where none has.
    fn search_many(&self, started: impl Fn(&Segment<T>) -> bool) -> Option<&Segment<T>> {
        let started = self.segments.partition_point(started);
        self.segments.get(started.saturating_sub(1))
    }
}

/// The last of these that has started; the first where none has. Halved without a branch, the
/// halves overlapping where the number is odd.
#[inline(always)]
fn halve<S>(mut open: &[S], started: impl Fn(&S) -> bool) -> Option<&S> {
    while open.len() > 1 {
        let half = open.len() / 2;
        let (low, high) = (open.get(..open.len() - half)?, open.get(half..)?);
        open = if high.first().is_some_and(&started) { high } else { low };
    }
    open.first()
}

impl<T: Real> Segment<T> {
    /// From a start on, or through it: where so many start before this one.
    ///
    /// # Errors
    /// The slope, which `check` names, or its reciprocal is not above 0 and finite.
    pub(crate) fn try_new(
        (x, y): (T, T),
        slope: T,
        place: usize,
        check: Check,
    ) -> Result<Self, ParameterError> {
        let slope = check.above(slope, T::ZERO)?;
        let reciprocal_slope = check.named("reciprocal slope").finite(T::ONE / slope)?;
        Ok(Self { x, y, slope, reciprocal_slope, place })
    }

    /// One that starts nowhere.
    pub(crate) fn never() -> Self {
        Self { x: T::INFINITY, y: T::INFINITY, slope: T::ONE, reciprocal_slope: T::ONE, place: 0 }
    }

    /// That of the inverse curve.
    pub(crate) fn inverted(self) -> Self {
        Self { x: self.y, y: self.x, slope: self.reciprocal_slope, reciprocal_slope: self.slope, ..self }
    }

    /// Where it starts.
    pub(crate) fn start(&self) -> (T, T) {
        (self.x, self.y)
    }

    pub(crate) fn slope(&self) -> T {
        self.slope
    }

    /// One over the slope.
    pub(crate) fn reciprocal_slope(&self) -> T {
        self.reciprocal_slope
    }

    /// y at x, on the straight line through the segment.
    #[inline(always)]
    pub(crate) fn value(&self, x: T) -> T {
        self.y + self.slope * (x - self.x)
    }

    /// x at y, on the straight line through the segment.
    #[inline(always)]
    pub(crate) fn inverse(&self, y: T) -> T {
        self.x + self.reciprocal_slope * (y - self.y)
    }
}
