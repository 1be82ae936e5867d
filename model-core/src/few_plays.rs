//! A bank of up to ten plays, each kept by its output.
//!
//! # Design
//! A move in one direction drives some of the plays, those of the smallest thresholds, and leaves
//! the others: zᵢ = v - rᵢ for the first k of a rising move, v + rᵢ of a falling one. Which it
//! drives is found by halving, three or four comparisons. What the driven ones give is one straight
//! line, u = (q + p₁ + … + pₖ) v ∓ (p₁ r₁ + … + pₖ rₖ), to which the sum of those left is added. So
//! every play costs a store or a product, whichever k is, and no comparison of its own.
//!
//! There are always ten: those beyond the parameters' repeat the last one without weight.
//! For more plays the turning points are cheaper ([`crate::turning_points`]).
//!
//! # Ends of the range
//! A move may be told not to go farther than u stays within a range. Whether it would is known with
//! u, before anything has moved. How many plays are then driven is found by halving again, among
//! those that the whole move would drive: what u is where a play begins to be driven follows from
//! its output and from what those beyond it give. So an end costs about what a move inside and the
//! envelope behind it do, whatever the muscle has been through.
//!
//! # Leaves
//! Both searches are trees of branches whose leaves are compiled for their number of plays: all
//! that a leaf loads stands where the compiler knows. At the ends there is a tree for each number
//! of plays that the whole move would drive, which costs flash.

use core::array;

use crate::convert::counted_from;
use crate::direction::{go, passes};
use crate::loading_curve::LoadingCurve;
use crate::range::Range;
use crate::real::Real;

mod wider;

/// So many plays at most.
pub(crate) const FEW_PLAYS: usize = 10;

/// Finds by halving how many plays are driven, where `drives` says it of each, and goes on with the
/// number: a literal.
macro_rules! by_driven {
    ($drives:ident, $go_on:ident) => {
        if $drives(4) {
            if $drives(7) {
                if $drives(8) { if $drives(9) { $go_on!(10) } else { $go_on!(9) } } else { $go_on!(8) }
            } else if $drives(5) {
                if $drives(6) { $go_on!(7) } else { $go_on!(6) }
            } else {
                $go_on!(5)
            }
        } else if $drives(2) {
            if $drives(3) { $go_on!(4) } else { $go_on!(3) }
        } else if $drives(0) {
            if $drives(1) { $go_on!(2) } else { $go_on!(1) }
        } else {
            $go_on!(0)
        }
    };
}

/// As `by_driven`, where it takes a sum over the plays beyond to say it of a play: sums that are
/// not needed afterwards cost as much as a question, so that large thresholds are asked first.
macro_rules! by_driven_of_sums {
    ($drives:ident, $go_on:ident) => {
        if $drives(6) {
            if $drives(8) {
                if $drives(9) { $go_on!(10) } else { $go_on!(9) }
            } else if $drives(7) {
                $go_on!(8)
            } else {
                $go_on!(7)
            }
        } else if $drives(3) {
            if $drives(5) {
                $go_on!(6)
            } else if $drives(4) {
                $go_on!(5)
            } else {
                $go_on!(4)
            }
        } else if $drives(1) {
            if $drives(2) { $go_on!(3) } else { $go_on!(2) }
        } else if $drives(0) {
            $go_on!(1)
        } else {
            $go_on!(0)
        }
    };
}

/// What u follows while certain plays are driven, and the others add nothing: slope v ∓ moment.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Line<T> {
    slope: T,
    reciprocal_slope: T,
    /// The sum of weight times threshold.
    moment: T,
    /// That over the slope: v is as far from 0 where u is 0.
    lead: T,
}

/// The bank.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct FewPlays<T> {
    thresholds: [T; FEW_PLAYS],
    weights: [T; FEW_PLAYS],
    /// Where this play begins to be driven, u is its slope times its output ± this, if those beyond
    /// give nothing.
    begins: [T; FEW_PLAYS],
    /// Where no play is driven.
    direct: Line<T>,
    /// Where this play is driven, and with it those before.
    driven: [Line<T>; FEW_PLAYS],
}

/// What it remembers.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub(crate) struct Outputs<T> {
    outputs: [T; FEW_PLAYS],
    /// The last input.
    pub(crate) v: T,
}

impl<T: Real> FewPlays<T> {
    /// The first plays, or all of them, of a bank with this [loading curve](crate::play::PlayBank).
    pub(crate) fn new<const N: usize>(curve: &LoadingCurve<T, N>) -> Self {
        let half = T::from_f64(0.5);
        let line = |driven| {
            let segment = curve.segment(driven);
            let ((bend, u), slope, reciprocal_slope) =
                (segment.start(), segment.slope(), segment.reciprocal_slope());
            let moment = half * (slope * bend - u);
            Line { slope, reciprocal_slope, moment, lead: moment * reciprocal_slope }
        };
        let threshold = |play| half * curve.segment(play + 1).start().0;
        Self {
            thresholds: array::from_fn(threshold),
            weights: array::from_fn(|play| line(play + 1).slope - line(play).slope),
            begins: array::from_fn(|play| line(play + 1).slope * threshold(play) - line(play + 1).moment),
            direct: line(0),
            driven: array::from_fn(|play| line(play + 1)),
        }
    }

    /// The state with these outputs at the input `v`.
    pub(crate) fn state_with(output: impl Fn(usize) -> T, v: T) -> Outputs<T> {
        Outputs { outputs: array::from_fn(output), v }
    }

    /// The state that the inverse bank has where this bank has `state`.
    pub(crate) fn inverse_state(&self, state: &Outputs<T>) -> Outputs<T> {
        let mut inverse = state.clone();
        let mut still = T::ZERO;
        let plays = state.outputs.iter().zip(&self.weights).zip(&self.driven);
        for (((&z, &weight), line), inverse) in plays.zip(&mut inverse.outputs).rev() {
            *inverse = line.slope * z + still;
            still += weight * z;
        }
        inverse.v = self.direct.slope * state.v + still;
        inverse
    }

    /// More than roundings of its sums can move u, where that stays within `range`.
    ///
    /// Over all states of a bank at v, u lies beyond what it is where all plays are driven by at
    /// most 2 Σ max(pᵢ + … + pₙ, 0) (rᵢ - rᵢ₋₁).
    pub(crate) fn rounding(&self, range: &Range<T>) -> T {
        let [.., all] = self.driven;
        let (mut excess, mut scale, mut last) = (T::ZERO, self.direct.slope, (T::ZERO, self.direct.slope));
        for ((&threshold, &weight), line) in self.thresholds.iter().zip(&self.weights).zip(&self.driven) {
            let sum = (all.slope - last.1).at_least(T::ZERO);
            excess += (sum + sum) * (threshold - last.0);
            scale += weight.abs();
            last = (threshold, line.slope);
        }
        let farthest = range.min().abs() + range.max().abs() + excess;
        T::from_f64(32.0) * T::EPSILON * scale * (farthest * all.reciprocal_slope + last.0)
    }

    /// Moves to `v` in one direction, and answers u.
    #[inline(always)]
    pub(crate) fn drive<const RISING: bool>(&self, state: &mut Outputs<T>, v: T) -> T {
        let outputs = &state.outputs;
        let drives = |play| self.drives::<RISING>(outputs, play, v);
        macro_rules! drive_first {
            ($driven:literal) => {{
                let (u, _) = self.led_by_first::<$driven, RISING>(outputs, v);
                self.leave_first::<$driven, RISING>(state, v);
                u
            }};
        }
        by_driven!(drives, drive_first)
    }

    /// As [`drive`](Self::drive), but goes no farther than u stays within a range. Hands u to
    /// `inside`, or asks `at_end`.
    #[inline(always)]
    pub(crate) fn drive_within<const RISING: bool, A>(
        &self,
        state: &mut Outputs<T>,
        v: T,
        range: &Range<T>,
        inside: impl FnOnce(T) -> A,
        at_end: impl FnOnce() -> A,
    ) -> A {
        let outputs = &state.outputs;
        let drives = |play| self.drives::<RISING>(outputs, play, v);
        macro_rules! drive_first {
            ($driven:literal) => {{
                let (u, still) = self.led_by_first::<$driven, RISING>(outputs, v);
                let end = range.end::<RISING>();
                if passes::<T, RISING>(u, end) {
                    self.drive_until::<$driven, RISING>(state, end - still);
                    return at_end();
                }
                self.leave_first::<$driven, RISING>(state, v);
                u
            }};
        }
        inside(by_driven!(drives, drive_first))
    }

    /// Whether a move to `v` drives a play.
    #[inline(always)]
    fn drives<const RISING: bool>(&self, outputs: &[T; FEW_PLAYS], play: usize, v: T) -> bool {
        let play = outputs.get(play).zip(self.thresholds.get(play));
        play.is_some_and(|(&z, &threshold)| passes::<T, RISING>(go::<T, RISING>(v, -threshold), z))
    }

    /// u where the first `K` plays are driven to `v`, and what of it those give that are left.
    #[inline(always)]
    fn led_by_first<const K: usize, const RISING: bool>(&self, outputs: &[T; FEW_PLAYS], v: T) -> (T, T) {
        // From the first on, not from 0, which would cost an addition.
        let mut still = None;
        for (play, (&z, &weight)) in outputs.iter().zip(&self.weights).enumerate() {
            if play >= K {
                let given = weight * z;
                still = Some(still.map_or(given, |still: T| still + given));
            }
        }
        let line = self.line::<K>();
        let driven = go::<T, RISING>(line.slope * v, -line.moment);
        still.map_or((driven, T::ZERO), |still| (driven + still, still))
    }

    /// What u follows while the first `K` plays are driven.
    #[inline(always)]
    fn line<const K: usize>(&self) -> &Line<T> {
        self.driven.get(K.wrapping_sub(1)).unwrap_or(&self.direct)
    }

    /// Leaves the first `K` plays as a move to `v` that drives them.
    #[inline(always)]
    fn leave_first<const K: usize, const RISING: bool>(&self, state: &mut Outputs<T>, v: T) {
        state.v = v;
        for (play, (z, &threshold)) in state.outputs.iter_mut().zip(&self.thresholds).enumerate() {
            if play < K {
                *z = go::<T, RISING>(v, -threshold);
            }
        }
    }

    /// A move that ends where the first `K` plays, all that it could drive, give `u` together. Not
    /// inlined, to avoid register spills in the other moves registers.
    #[cold]
    #[inline(never)]
    fn drive_until<const K: usize, const RISING: bool>(&self, state: &mut Outputs<T>, u: T) {
        // What is left for the plays before each place, where those from it on are not driven.
        let mut left = [u; FEW_PLAYS + 1];
        let mut last = u;
        let plays = state.outputs.iter().zip(&self.weights).zip(&mut left).enumerate();
        for (play, ((&z, &weight), left)) in plays.rev() {
            if play < K {
                last += -(weight * z);
                *left = last;
            }
        }
        let outputs = &state.outputs;
        let drives = |play: usize| {
            let play = outputs
                .get(play)
                .zip(self.driven.get(play))
                .zip(self.begins.get(play))
                .zip(left.get(play + 1));
            play.is_some_and(|(((&z, line), &begin), &left)| {
                passes::<T, RISING>(left, go::<T, RISING>(line.slope * z, begin))
            })
        };
        let drives = |play: usize| play < K && drives(play);
        macro_rules! leave_first {
            ($driven:literal) => {{
                let v = self.line::<$driven>().input_at::<RISING>(left[$driven]);
                self.leave_first::<$driven, RISING>(state, v);
            }};
        }
        by_driven_of_sums!(drives, leave_first);
    }
}

impl<T: Real> Line<T> {
    /// The v at which it reaches `u` in one direction.
    fn input_at<const RISING: bool>(&self, u: T) -> T {
        go::<T, RISING>(u * self.reciprocal_slope, self.lead)
    }
}

impl<T: Real> Outputs<T> {
    /// In the place of what is kept otherwise.
    pub(crate) fn none() -> Self {
        Self { outputs: [T::ZERO; FEW_PLAYS], v: T::ZERO }
    }

    /// The same where inputs, and so outputs, count from `v` on.
    pub(crate) fn counted_from(&self, v: f64) -> Self {
        Self { outputs: self.outputs.map(|z| counted_from(z, v)), v: counted_from(self.v, v) }
    }

    /// The outputs by rising threshold.
    pub(crate) fn iter(&self) -> impl Iterator<Item = &T> {
        self.outputs.iter()
    }
}
