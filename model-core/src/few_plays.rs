//! A bank of up to ten plays, each kept by its output.
//!
//! # Design
//! A move in one direction drives some of the plays, those of the smallest thresholds, and leaves the others: zᵢ = v - rᵢ for
//! the first k of a rising move, v + rᵢ of a falling one. Which it drives is found by halving, three or four comparisons.
//! What the driven ones give is one straight line, u = (q + p₁ + … + pₖ) v ∓ (p₁ r₁ + … + pₖ rₖ), to which the sum
//! of those left is added. So every play costs a store or a product, whichever k is, and no comparison of its own.
//!
//! There are always ten: those beyond the parameters' repeat the last one without weight.
//! For more plays the turning points are cheaper ([`crate::turning_points`]).
//!
//! # Ends of the range
//! A move may be told not to go farther than u stays within a range. How far that is depends on the plays that are left. Where
//! v is inside whatever is left ([`Ends`]), nothing is looked at. Beyond, the end is that where all plays are driven, if
//! they are then: so it is once a muscle has been through its range, for no move takes that back. A muscle that
//! has not costs a dozen instructions more for each play that is not driven.

use core::array;

use crate::curve::MonotoneCurve;
use crate::play_move::{Reached, go, passes};
use crate::range::Range;
use crate::real::Real;

mod wider;

/// So many plays at most.
pub(crate) const FEW_PLAYS: usize = 10;

/// What u follows while certain plays are driven, and the others add nothing: slope v ∓ moment.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Line<T> {
    slope: T,
    reciprocal_slope: T,
    /// The sum of weight times threshold.
    moment: T,
}

/// The bank.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct FewPlays<T> {
    thresholds: [T; FEW_PLAYS],
    weights: [T; FEW_PLAYS],
    /// Where no play is driven.
    direct: Line<T>,
    /// Where this play is driven, and with it those before.
    driven: [Line<T>; FEW_PLAYS],
}

/// What it remembers.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Outputs<T> {
    outputs: [T; FEW_PLAYS],
    /// The last input.
    pub(crate) v: T,
}

/// How far a bank may move.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Ends<T> {
    /// Of u.
    pub(crate) range: Range<T>,
    /// Strictly between these v no state leads out of the range; none where the first is not below the second.
    pub(crate) inside: (T, T),
}

impl<T: Real> FewPlays<T> {
    /// The first plays, or all of them, of a bank with this [loading curve](crate::play::PlayBank).
    pub(crate) fn new<const N: usize>(curve: &MonotoneCurve<T, N>) -> Self {
        let half = T::from_f64(0.5);
        let segment = |place: usize| curve.segment(place.min(curve.len() - 1));
        let line = |place| {
            let (bend, u) = segment(place).start();
            let slope = segment(place).slope();
            Line {
                slope,
                reciprocal_slope: segment(place).reciprocal_slope(),
                moment: half * (slope * bend - u),
            }
        };
        Self {
            thresholds: array::from_fn(|play| half * segment(play + 1).start().0),
            weights: array::from_fn(|play| segment(play + 1).slope() - segment(play).slope()),
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

    /// How far this bank may move for u to stay within `range`. Where its roundings could lead out of the wider `domain`, no
    /// move is surely inside.
    ///
    /// Over all states of a bank at v, u lies beyond what it is where all plays are driven by at most
    /// 2 Σ max(pᵢ + … + pₙ, 0) (rᵢ - rᵢ₋₁).
    pub(crate) fn ends(&self, range: Range<T>, domain: (T, T)) -> Ends<T> {
        let [.., all] = self.driven;
        let (mut excess, mut scale, mut last) = (T::ZERO, self.direct.slope, (T::ZERO, self.direct.slope));
        for ((&threshold, &weight), line) in self.thresholds.iter().zip(&self.weights).zip(&self.driven) {
            let sum = (all.slope - last.1).at_least(T::ZERO);
            excess += (sum + sum) * (threshold - last.0);
            scale += weight.abs();
            last = (threshold, line.slope);
        }
        let farthest = range.min().abs() + range.max().abs() + excess;
        // More than the sums can lose by roundings.
        let margin = T::from_f64(32.0) * T::EPSILON * scale * (farthest * all.reciprocal_slope + last.0);
        let is_apart = range.min() - margin > domain.0 && range.max() + margin < domain.1;
        let inside = if is_apart {
            (all.input_at::<false>(range.min() + excess), all.input_at::<true>(range.max() - excess))
        } else {
            (T::INFINITY, -T::INFINITY)
        };
        Ends { range, inside }
    }

    /// Moves to `v` in one direction, and answers u.
    #[inline(always)]
    pub(crate) fn drive<const RISING: bool>(&self, state: &mut Outputs<T>, v: T) -> T {
        state.v = v;
        let outputs = &mut state.outputs;
        let drives = |outputs: &[T; FEW_PLAYS], play: usize| {
            let play = outputs.get(play).zip(self.thresholds.get(play));
            play.is_some_and(|(&z, &threshold)| passes::<T, RISING>(go::<T, RISING>(v, -threshold), z))
        };
        if drives(outputs, 4) {
            if drives(outputs, 7) {
                if drives(outputs, 8) {
                    if drives(outputs, 9) {
                        self.drive_first::<10, RISING>(outputs, v)
                    } else {
                        self.drive_first::<9, RISING>(outputs, v)
                    }
                } else {
                    self.drive_first::<8, RISING>(outputs, v)
                }
            } else if drives(outputs, 5) {
                if drives(outputs, 6) {
                    self.drive_first::<7, RISING>(outputs, v)
                } else {
                    self.drive_first::<6, RISING>(outputs, v)
                }
            } else {
                self.drive_first::<5, RISING>(outputs, v)
            }
        } else if drives(outputs, 2) {
            if drives(outputs, 3) {
                self.drive_first::<4, RISING>(outputs, v)
            } else {
                self.drive_first::<3, RISING>(outputs, v)
            }
        } else if drives(outputs, 0) {
            if drives(outputs, 1) {
                self.drive_first::<2, RISING>(outputs, v)
            } else {
                self.drive_first::<1, RISING>(outputs, v)
            }
        } else {
            self.drive_first::<0, RISING>(outputs, v)
        }
    }

    /// Drives the first `K` plays and leaves the others.
    #[inline(always)]
    fn drive_first<const K: usize, const RISING: bool>(&self, outputs: &mut [T; FEW_PLAYS], v: T) -> T {
        let line = self.driven.get(K.wrapping_sub(1)).unwrap_or(&self.direct);
        let mut u = go::<T, RISING>(line.slope * v, -line.moment);
        let plays = outputs.iter_mut().zip(&self.thresholds).zip(&self.weights).enumerate();
        for (play, ((z, &threshold), &weight)) in plays {
            if play < K {
                *z = go::<T, RISING>(v, -threshold);
            } else {
                u += weight * *z;
            }
        }
        u
    }

    /// As [`drive`](Self::drive), but goes no farther than u stays within a range, wherever `v` is.
    #[inline(never)]
    pub(crate) fn drive_to_end<const RISING: bool>(
        &self,
        state: &mut Outputs<T>,
        v: T,
        range: &Range<T>,
    ) -> Reached<T> {
        let u_end = if RISING { range.max() } else { range.min() };
        let ([.., all], [.., last], [.., threshold]) = (&self.driven, &state.outputs, &self.thresholds);
        let end_of_all = all.input_at::<RISING>(u_end);
        // A muscle that has been through its range takes this way.
        if !passes::<T, RISING>(end_of_all, v)
            && !passes::<T, RISING>(*last, go::<T, RISING>(end_of_all, -*threshold))
        {
            state.v = end_of_all;
            self.drive_first::<FEW_PLAYS, RISING>(&mut state.outputs, end_of_all);
            return Reached::End(u_end);
        }
        let end = self.input_at::<RISING>(&state.outputs, u_end);
        // Roundings may lead a move to just before the end beyond it.
        let is_beyond = passes::<T, RISING>(v, end);
        let u = self.drive::<RISING>(state, if is_beyond { end } else { v });
        if is_beyond || !passes::<T, RISING>(u_end, u) { Reached::End(u_end) } else { Reached::Inside(u) }
    }

    /// The v at which a move in one direction reaches `u`.
    fn input_at<const RISING: bool>(&self, outputs: &[T; FEW_PLAYS], u: T) -> T {
        // How far u is to be led by the driven plays, with what those left give taken off.
        let mut driven_u = u;
        let plays = outputs.iter().zip(&self.thresholds).zip(&self.weights).zip(&self.driven);
        for (((&z, &threshold), &weight), line) in plays.rev() {
            let v = line.input_at::<RISING>(driven_u);
            if !passes::<T, RISING>(z, go::<T, RISING>(v, -threshold)) {
                return v;
            }
            driven_u += -(weight * z);
        }
        self.direct.input_at::<RISING>(driven_u)
    }
}

impl<T: Real> Line<T> {
    /// The v at which it reaches `u` in one direction.
    fn input_at<const RISING: bool>(&self, u: T) -> T {
        go::<T, RISING>(u, self.moment) * self.reciprocal_slope
    }
}

impl<T: Real> Outputs<T> {
    /// The outputs by rising threshold.
    pub(crate) fn iter(&self) -> impl Iterator<Item = &T> {
        self.outputs.iter()
    }
}
