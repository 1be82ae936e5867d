//! A strictly increasing piecewise-linear curve, evaluated in both directions by a search for the segment.
//!
//! The common form of the plays' loading curve, the dead-zone stage and the piecewise-linear envelope.
//!
//! # The search
//! Unused places of the array hold segments that never start, so that its length is a constant. Up to 16 segments, which
//! is more than ten operators need, it is halved without a branch, in four steps, or in fewer where the array is
//! shorter; more segments cost a loop.

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

/// A curve of at most `K` + 1 segments; the first and the last go on without end.
#[derive(Clone, Debug, PartialEq)]
pub struct MonotoneCurve<T, const K: usize> {
    /// By rising start. At least the first one is in use, where there is room for it.
    segments: [Segment<T>; K],
    /// The segment for which the array has no place.
    last: Segment<T>,
    /// How many segments are in use.
    len: usize,
}

impl<T: Real, const K: usize> MonotoneCurve<T, K> {
    /// A straight line through a point.
    ///
    /// # Errors
    /// The slope, which `check` names, or its reciprocal is not above 0 and finite.
    pub(crate) fn line(point: (T, T), slope: T, check: Check) -> Result<Self, ParameterError> {
        let never = Segment { x: T::INFINITY, y: T::INFINITY, slope, reciprocal_slope: slope, place: K };
        let mut curve = Self { segments: [never; K], last: never, len: 0 };
        curve.push(Segment::try_new(point, slope, check)?, check)?;
        Ok(curve)
    }

    /// Goes on from `point`, a point of the last segment and beyond its start, with another slope.
    ///
    /// # Errors
    /// As for [`line`](Self::line); or there is no room for another segment.
    pub(crate) fn bend(&mut self, point: (T, T), slope: T, check: Check) -> Result<(), ParameterError> {
        self.push(Segment::try_new(point, slope, check)?, check)
    }

    fn push(&mut self, segment: Segment<T>, check: Check) -> Result<(), ParameterError> {
        let free = match self.segments.get_mut(self.len) {
            Some(free) => free,
            None if self.len == K => &mut self.last,
            None => return Err(check.length(K + 2, Requirement::AtMost((K + 1) as f64))),
        };
        *free = Segment { place: self.len, ..segment };
        self.len += 1;
        Ok(())
    }

    /// The curve of the inverse function.
    pub(crate) fn inverted(&self) -> Self {
        Self { segments: self.segments.map(Segment::inverted), last: self.last.inverted(), len: self.len }
    }

    /// So many places the unrolled search looks at.
    const FEW: usize = if K < FEW_SEGMENTS { K } else { FEW_SEGMENTS };

    /// y at x.
    pub fn value(&self, x: T) -> T {
        self.search(|segment| segment.x <= x).value(x)
    }

    /// x at y.
    #[inline(always)]
    pub fn inverse(&self, y: T) -> T {
        self.search(|segment| segment.y <= y).inverse(y)
    }

    /// The smallest slope.
    pub fn smallest_slope(&self) -> T {
        self.segments().fold(T::INFINITY, |least, s| if s.slope < least { s.slope } else { least })
    }

    /// Number of segments.
    pub(crate) fn len(&self) -> usize {
        self.len
    }

    /// The segments by rising start.
    pub(crate) fn segments(&self) -> impl Iterator<Item = &Segment<T>> {
        self.segments.iter().chain([&self.last]).take(self.len)
    }

    /// The segment at a place; the last one beyond.
    #[inline(always)]
    pub(crate) fn segment(&self, place: usize) -> &Segment<T> {
        self.segments.get(place).unwrap_or(&self.last)
    }

    /// The segment that x lies on, of a curve of many segments.
    #[inline(always)]
    pub(crate) fn segment_at(&self, x: T) -> &Segment<T> {
        self.search_many(|segment| segment.x <= x)
    }

    /// The segment that y lies on, of a curve of many segments.
    #[inline(always)]
    pub(crate) fn segment_of(&self, y: T) -> &Segment<T> {
        self.search_many(|segment| segment.y <= y)
    }

    /// The last segment that has started; the first where none has.
    #[inline(always)]
    fn search(&self, started: impl Fn(&Segment<T>) -> bool) -> &Segment<T> {
        if self.len <= Self::FEW
            && let Some(few @ [first, ..]) = self.segments.get(..Self::FEW)
        {
            return halve(few, started).unwrap_or(first);
        }
        self.search_many_apart(started)
    }

    /// Apart, lest it costs few segments registers.
    #[inline(never)]
    fn search_many_apart(&self, started: impl Fn(&Segment<T>) -> bool) -> &Segment<T> {
        self.search_many(started)
    }

    /// [`search`](Self::search), whatever the number of segments.
    #[inline(always)]
    fn search_many(&self, started: impl Fn(&Segment<T>) -> bool) -> &Segment<T> {
        if started(&self.last) {
            return &self.last;
        }
        let started = self.segments.partition_point(started);
        self.segment(started.saturating_sub(1))
    }
}

/// The last of these that has started; the first where none has. Halved without a branch, the halves overlapping where
/// the number is odd.
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
    fn try_new((x, y): (T, T), slope: T, check: Check) -> Result<Self, ParameterError> {
        let slope = check.above(slope, T::ZERO)?;
        let reciprocal_slope = check.named("reciprocal slope").finite(T::ONE / slope)?;
        Ok(Self { x, y, slope, reciprocal_slope, place: 0 })
    }

    fn inverted(self) -> Self {
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
