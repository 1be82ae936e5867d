//! The loading curve of a bank of plays, u = C(Δ): how far u moves when v moves by Δ from a turning
//! point.
//!
//! It bends where one more play is driven, so that a bank of `N` plays has `N` + 1 segments: those
//! before the last in an array, and the last, on which all plays are driven.

use crate::curve::Segment;
use crate::error::{Check, ParameterError, Requirement};
use crate::real::Real;

/// So many segments behind one are looked at before all are.
const NEAR: usize = 3;

/// A loading curve of at most `N` plays.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct LoadingCurve<T, const N: usize> {
    /// By rising start, one for each play.
    segments: [Segment<T>; N],
    /// The last one.
    all: Segment<T>,
    /// Number of plays.
    len: usize,
}

impl<T: Real, const N: usize> LoadingCurve<T, N> {
    /// Without plays.
    ///
    /// # Errors
    /// The slope, which `check` names, or its reciprocal is not above 0 and finite.
    pub(crate) fn line(slope: T, check: Check) -> Result<Self, ParameterError> {
        let all = Segment::try_new((T::ZERO, T::ZERO), slope, 0, check)?;
        Ok(Self { segments: [Segment::never(); N], all, len: 0 })
    }

    /// Goes on from `point`, a point of the last segment and beyond its start, with another slope.
    ///
    /// # Errors
    /// As for [`line`](Self::line); or there is no room for another play.
    pub(crate) fn bend(&mut self, point: (T, T), slope: T, check: Check) -> Result<(), ParameterError> {
        let next = Segment::try_new(point, slope, self.len + 1, check)?;
        let too_many = || check.length(N + 1, Requirement::AtMost(N as f64));
        *self.segments.get_mut(self.len).ok_or_else(too_many)? = self.all;
        self.all = next;
        self.len += 1;
        Ok(())
    }

    /// The curve of the inverse bank.
    pub(crate) fn inverted(&self) -> Self {
        Self { segments: self.segments.map(Segment::inverted), all: self.all.inverted(), len: self.len }
    }

    /// Number of plays.
    pub(crate) fn len(&self) -> usize {
        self.len
    }

    /// The segment on which all plays are driven.
    #[inline(always)]
    pub(crate) fn all(&self) -> &Segment<T> {
        &self.all
    }

    /// The segments by rising start, one more than plays.
    pub(crate) fn segments(&self) -> impl Iterator<Item = &Segment<T>> {
        self.segments.iter().take(self.len).chain([&self.all])
    }

    /// The segment on which so many plays are driven; the last one beyond.
    #[inline(always)]
    pub(crate) fn segment(&self, driven: usize) -> &Segment<T> {
        if driven < self.len { self.segments.get(driven).unwrap_or(&self.all) } else { &self.all }
    }

    /// The segment that Δ lies on.
    #[inline(always)]
    pub(crate) fn segment_at(&self, way: T) -> &Segment<T> {
        self.search(|segment| segment.start().0 <= way)
    }

    /// The same, looked for first where so many plays are driven, and on the few segments behind.
    #[inline(always)]
    pub(crate) fn segment_near(&self, driven: usize, way: T) -> &Segment<T> {
        let started = |segment: &Segment<T>| segment.start().0 <= way;
        if started(&self.all) {
            return &self.all;
        }
        if let Some([here, behind @ ..]) = self.segments.get(driven..)
            && started(here)
        {
            let mut last = here;
            for next in behind.iter().take(NEAR) {
                if !started(next) {
                    return last;
                }
                last = next;
            }
        }
        self.segment_at(way)
    }

    /// The segment that C(Δ) lies on.
    #[inline(always)]
    pub(crate) fn segment_of(&self, way: T) -> &Segment<T> {
        self.search(|segment| segment.start().1 <= way)
    }

    /// The last segment that has started; the first where none has.
    #[inline(always)]
    fn search(&self, started: impl Fn(&Segment<T>) -> bool) -> &Segment<T> {
        if started(&self.all) {
            return &self.all;
        }
        self.segment(self.segments.partition_point(started).saturating_sub(1))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const PLAYS: usize = 20;

    /// Bends at 1, 2, …, each half as steep again; with room for more.
    fn curve() -> LoadingCurve<f64, 30> {
        let check = Check::new("slope", "");
        let mut curve = LoadingCurve::line(1.0, check).expect("valid");
        let (mut point, mut slope) = ((0.0, 0.0), 1.0);
        for play in 1..=PLAYS {
            let bend = play as f64;
            point = (bend, point.1 + slope * (bend - point.0));
            slope *= 1.5;
            curve.bend(point, slope, check).expect("it fits");
        }
        curve
    }

    #[test]
    fn the_segment_is_the_same_wherever_it_is_looked_for_first() {
        let curve = curve();
        for way in (0..200).map(|k| f64::from(k) * 0.125) {
            let driven = (way as usize).min(PLAYS);
            assert_eq!(curve.segment_at(way).place, driven, "{way}");
            for first in 0..30 {
                assert_eq!(curve.segment_near(first, way).place, driven, "{way} from {first}");
            }
        }
    }

    #[test]
    fn a_curve_of_one_play_too_many_is_refused() {
        let check = Check::new("slope", "");
        let mut curve = LoadingCurve::<f64, 1>::line(1.0, check).expect("valid");
        assert!(curve.bend((1.0, 1.0), 2.0, check).is_ok());
        assert!(curve.bend((2.0, 3.0), 3.0, check).is_err());
    }
}
