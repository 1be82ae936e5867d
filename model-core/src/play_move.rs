//! How a bank of many plays moves: which turning points it wipes out, which curve it follows, and
//! where it ends.
//!
//! The theory stands in [`crate::play`].

use crate::curve::Segment;
use crate::direction::{Reached, Target, go, passes, reaches, way};
use crate::play::PlayBank;
use crate::real::Real;
use crate::turn_stack::Turn;
use crate::turning_points::TurningPoints;

/// The heights of the turning points that a move leaves, see [`TurnStack`].
#[derive(Clone, Copy)]
struct Kept {
    /// Of where it comes from; where that is 0, it drives all plays.
    behind: usize,
    /// Of the innermost that it goes towards.
    ahead: usize,
}

/// What a move follows: the curve from the point that it comes from, and there a segment.
struct Branch<'a, T> {
    from: Turn<T>,
    segment: &'a Segment<T>,
    /// The turning points that the move leaves.
    kept: Kept,
    /// Whether that point takes the place of the turning point that the move came from.
    is_new: bool,
}

impl<T: Real> Branch<'_, T> {
    /// Ends the move at `v` and `u`: forgets what it wipes out.
    #[inline(always)]
    fn leave<const RISING: bool, const N: usize>(&self, state: &mut TurningPoints<T, N>, v: T, u: T) {
        let (behind, ahead) = state.sides_mut::<RISING>();
        ahead.truncate(self.kept.ahead);
        if self.is_new {
            behind.replace(self.kept.behind, self.from);
        } else {
            behind.truncate(self.kept.behind);
        }
        state.last = Turn { v, u, driven: self.segment.place };
    }
}

impl<T: Real, const N: usize> PlayBank<T, N> {
    /// Moves in one direction, as far as the target.
    #[inline(always)]
    pub(crate) fn drive<const RISING: bool>(
        &self,
        state: &mut TurningPoints<T, N>,
        to: Target<T>,
    ) -> Reached<T> {
        match self.gone_on::<RISING>(state, to.v) {
            Some((u, driven)) if !to.is_reached::<RISING>(u) => {
                state.last = Turn { v: to.v, u, driven };
                Reached::Inside(u)
            }
            _ => self.turn_and_drive::<RISING>(state, to),
        }
    }

    /// As [`drive`](Self::drive), whatever the move passes. Apart, for it is long.
    #[inline(never)]
    fn turn_and_drive<const RISING: bool>(
        &self,
        state: &mut TurningPoints<T, N>,
        to: Target<T>,
    ) -> Reached<T> {
        if state.rising != RISING {
            self.turn::<RISING>(state);
        }
        let v = to.v;
        let kept = Self::kept::<RISING>(state, |turn| reaches::<T, RISING>(v, turn.v));
        let branch =
            self.branch::<RISING>(state, kept, |from| self.curve.segment_at(way::<T, RISING>(from.v, v)));
        let u = go::<T, RISING>(branch.from.u, branch.segment.value(way::<T, RISING>(branch.from.v, v)));
        match to.end {
            Some(end) if to.is_reached::<RISING>(u) => {
                self.stop_at::<RISING>(state, kept, end);
                Reached::End(end)
            }
            _ => {
                branch.leave::<RISING, N>(state, v, u);
                Reached::Inside(u)
            }
        }
    }

    /// u at `v`, and how many plays are driven there, if a move only goes on: does not turn, passes
    /// no turning point, and drives more plays than the move before it, or fewer. Of a smooth input
    /// most samples do, and drive the same plays as the last one or a few more.
    #[inline(always)]
    fn gone_on<const RISING: bool>(&self, state: &TurningPoints<T, N>, v: T) -> Option<(T, usize)> {
        if state.rising != RISING {
            return None;
        }
        let (behind, ahead) = state.sides::<RISING>();
        let from = behind.at(behind.height())?;
        if ahead.at(ahead.height()).is_some_and(|turn| reaches::<T, RISING>(v, turn.v)) {
            return None;
        }
        let way = way::<T, RISING>(from.v, v);
        let segment = self.curve.segment_near(state.last.driven, way);
        (segment.place != from.driven).then(|| (go::<T, RISING>(from.u, segment.value(way)), segment.place))
    }

    /// Ends a move, which leaves at least so many turning points, where u reaches `end`. Not
    /// inlined, to avoid register spills in the other moves registers.
    #[inline(never)]
    fn stop_at<const RISING: bool>(&self, state: &mut TurningPoints<T, N>, mut kept: Kept, end: T) {
        let (_, ahead) = state.sides::<RISING>();
        // A state may know turning points beyond the end, which the move then does not reach.
        if kept.ahead < ahead.height()
            && ahead.at(kept.ahead + 1).is_some_and(|turn| passes::<T, RISING>(turn.u, end))
        {
            kept = Self::kept::<RISING>(state, |turn| reaches::<T, RISING>(end, turn.u));
        }
        let branch =
            self.branch::<RISING>(state, kept, |from| self.curve.segment_of(way::<T, RISING>(from.u, end)));
        let v = go::<T, RISING>(branch.from.v, branch.segment.inverse(way::<T, RISING>(branch.from.u, end)));
        branch.leave::<RISING, N>(state, v, end);
    }

    /// The turning points that a move leaves: it passes those ahead, from the innermost on, that it
    /// `passes`, each with its partner.
    #[inline(always)]
    fn kept<const RISING: bool>(state: &TurningPoints<T, N>, passes: impl Fn(&Turn<T>) -> bool) -> Kept {
        let (behind, all_ahead) = state.sides::<RISING>();
        let ahead = all_ahead.height_of_kept(passes);
        // The innermost is behind: there are as many on that side, or one more.
        Kept { behind: behind.height().wrapping_sub(all_ahead.height()).wrapping_add(ahead), ahead }
    }

    /// What a move follows that leaves so many turning points, and on which segment of the curve it
    /// ends.
    #[inline(always)]
    fn branch<'a, const RISING: bool>(
        &'a self,
        state: &TurningPoints<T, N>,
        kept: Kept,
        segment: impl Fn(&Turn<T>) -> &'a Segment<T>,
    ) -> Branch<'a, T> {
        let (behind, ahead) = state.sides::<RISING>();
        let Some(from) = behind.at(kept.behind) else {
            return self.branch_of_all::<RISING>();
        };
        let segment = segment(from);
        if segment.place != from.driven {
            return Branch { from: *from, segment, kept, is_new: false };
        }
        // The move has driven all that the one before it drove: no play depends any more on where
        // that turned.
        match (ahead.at(kept.ahead), behind.at(kept.behind.wrapping_sub(1))) {
            (Some(ahead), _) if ahead.driven != from.driven => {
                let (v, u) = self.curve.segment(segment.place + 1).start();
                let (v, u) = (go::<T, RISING>(ahead.v, -v), go::<T, RISING>(ahead.u, -u));
                Branch { from: Turn { v, u, driven: segment.place }, segment, kept, is_new: true }
            }
            (Some(_), Some(from)) => {
                let kept = Kept { behind: kept.behind.wrapping_sub(1), ahead: kept.ahead.wrapping_sub(1) };
                Branch { from: *from, segment, kept, is_new: false }
            }
            _ => self.branch_of_all::<RISING>(),
        }
    }

    /// What a move follows that drives all plays.
    #[inline(always)]
    fn branch_of_all<const RISING: bool>(&self) -> Branch<'_, T> {
        let Turn { v, u, driven } = self.origin_of_all;
        let from = if RISING { Turn { v: -v, u: -u, driven } } else { self.origin_of_all };
        Branch { from, segment: self.curve.all(), kept: Kept { behind: 0, ahead: 0 }, is_new: false }
    }

    /// The move ends in a turning point, and one in the direction `RISING` begins.
    #[inline(always)]
    fn turn<const RISING: bool>(&self, state: &mut TurningPoints<T, N>) {
        state.rising = RISING;
        let last = state.last;
        let (behind, ahead) = state.sides_mut::<RISING>();
        if !behind.push(last) {
            // Only a second turning point that drove no play finds no place, and then neither is
            // needed.
            ahead.truncate(ahead.height().saturating_sub(1));
        }
    }
}
