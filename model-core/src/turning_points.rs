//! What a bank of plays remembers: the turning points of its input that have not been wiped out.
//!
//! # Design
//! A play with threshold r follows the input once that has moved by more than 2 r from where it last turned. So of the
//! history only the turning points count, and of these only nested ones: a smaller swing inside a larger one, high and
//! low alternating. Moving beyond a turning point wipes it out with its partner. See [`crate::play`] for what follows
//! between them.
//!
//! # Bounded memory
//! Once a move has driven all plays that the move before it drove, none depends any more on where that one turned. What
//! is kept in its place is the point where a move back would begin to drive the next play: the memory is then the same
//! whatever swings led there, to the last bit. And where a third move drives just those plays too, the two before it are
//! forgotten altogether. So no more than two turning points are kept for each number of driven plays, one for all plays;
//! with one for none, that is at most N highs and N lows.

use heapless::Vec;

use crate::error::{Check, ParameterError, Requirement};
use crate::real::Real;

/// A point that the input has turned at, or where it stands.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Turn<T> {
    /// Input.
    pub(crate) v: T,
    /// Output there.
    pub(crate) u: T,
    /// How many plays, those of the smallest thresholds, were driven on the way here.
    pub(crate) driven: usize,
}

impl<T> Turn<T> {
    /// The same place, seen from the inverse bank.
    fn inverted(self) -> Self {
        Self { v: self.u, u: self.v, driven: self.driven }
    }
}

/// What a bank of at most `N` plays remembers.
#[derive(Clone, Debug, PartialEq)]
pub struct PlayState<T, const N: usize> {
    /// By falling input: each within the ones before.
    pub(crate) highs: Vec<Turn<T>, N>,
    /// By rising input.
    pub(crate) lows: Vec<Turn<T>, N>,
    /// Where the input stands.
    pub(crate) last: Turn<T>,
    /// Whether the input rose, or rested after it had risen: the innermost turning point is then a low.
    pub(crate) rising: bool,
}

impl<T: Real, const N: usize> PlayState<T, N> {
    /// The last input of the bank. Unit: that of its input.
    pub fn input(&self) -> T {
        self.last.v
    }

    /// Without turning points: all plays were driven.
    pub(crate) fn new(last: Turn<T>, rising: bool) -> Self {
        Self { highs: Vec::new(), lows: Vec::new(), last, rising }
    }

    /// The turning points that the present move comes from and goes towards, if it rises; else the other way round.
    #[inline(always)]
    pub(crate) fn sides<const RISING: bool>(&mut self) -> (&mut Vec<Turn<T>, N>, &mut Vec<Turn<T>, N>) {
        if RISING { (&mut self.lows, &mut self.highs) } else { (&mut self.highs, &mut self.lows) }
    }

    /// Whether `v` is above where the input stands; where it is neither above nor below, whether the input rose before.
    #[inline(always)]
    pub(crate) fn goes_up_to(&self, v: T) -> bool {
        if self.rising { v >= self.last.v } else { v > self.last.v }
    }

    /// Adds the innermost turning point: a low where the input rises from it.
    pub(crate) fn push(&mut self, turn: Turn<T>) -> Result<(), Turn<T>> {
        if self.rising { self.lows.push(turn) } else { self.highs.push(turn) }
    }

    /// How many turning points ahead a move passes: those from the innermost on that it `passes`. `FEW`: whether there are
    /// fewer than 16, so that four steps find it.
    #[inline(always)]
    pub(crate) fn passed<const RISING: bool, const FEW: bool>(
        &self,
        passes: impl Fn(&Turn<T>) -> bool,
    ) -> usize {
        let ahead = if RISING { self.highs.as_slice() } else { self.lows.as_slice() };
        if !FEW {
            return ahead.len() - ahead.partition_point(|turn| !passes(turn));
        }
        let mut passed = 0;
        for step in [8, 4, 2, 1] {
            if self.ahead::<RISING>(passed + step).is_some_and(&passes) {
                passed += step;
            }
        }
        passed
    }

    /// The turning point ahead with this place from within, the innermost being 1.
    #[inline(always)]
    pub(crate) fn ahead<const RISING: bool>(&self, place: usize) -> Option<&Turn<T>> {
        let ahead = if RISING { &self.highs } else { &self.lows };
        ahead.get(ahead.len().wrapping_sub(place))
    }

    /// Where a move comes from that passes so many turning points; none if it passes all, and so drives all plays.
    #[inline(always)]
    pub(crate) fn behind<const RISING: bool>(&self, passed: usize) -> Option<&Turn<T>> {
        let behind = if RISING { &self.lows } else { &self.highs };
        behind.get(behind.len().wrapping_sub(passed).wrapping_sub(1))
    }

    /// Forgets the turning points that a move passes, each with its partner; and puts another in the place of the one that
    /// the move comes from, where there is one.
    #[inline(always)]
    pub(crate) fn leave<const RISING: bool>(&mut self, passed: usize, origin: Option<Turn<T>>) {
        let (behind, ahead) = self.sides::<RISING>();
        ahead.truncate(ahead.len().saturating_sub(passed));
        behind.truncate(behind.len().wrapping_sub(passed));
        if let (Some(place), Some(origin)) = (behind.last_mut(), origin) {
            *place = origin;
        }
    }

    /// All turning points, the outermost first, with whether they are highs.
    pub(crate) fn outermost_first(&self) -> impl Iterator<Item = (Turn<T>, bool)> {
        let high_first =
            self.highs.len() > self.lows.len() || (self.rising && self.highs.len() == self.lows.len());
        let (first, second) = if high_first { (&self.highs, &self.lows) } else { (&self.lows, &self.highs) };
        (0..first.len()).flat_map(move |i| {
            let one = first.get(i).map(|turn| (*turn, high_first));
            let other = second.get(i).map(|turn| (*turn, !high_first));
            one.into_iter().chain(other)
        })
    }

    /// The same memory, seen from the inverse bank.
    pub(crate) fn inverted(&self) -> Self {
        let mut inverted = self.clone();
        inverted.highs.iter_mut().chain(&mut inverted.lows).for_each(|turn| *turn = turn.inverted());
        inverted.last = self.last.inverted();
        inverted
    }
}

/// Refuses outputs of plays that no history can reach at the input `v`: |v - z₁| ≤ r₁ and
/// |zᵢ - zᵢ₊₁| ≤ rᵢ₊₁ - rᵢ, with a tolerance of a few roundings. As many outputs as thresholds.
pub(crate) fn admissible<T: Real>(
    thresholds: impl Iterator<Item = T>,
    outputs: &[T],
    v: T,
) -> Result<(), ParameterError> {
    let mut before = (Check::new("v", "").finite(v)?, T::ZERO);
    for (i, (threshold, &output)) in thresholds.zip(outputs).enumerate() {
        let check = Check::at("play outputs", i, "");
        check.finite(output)?;
        let tolerance = T::from_f64(8.0) * T::EPSILON * (v.abs() + threshold);
        let reach = threshold - before.1 + tolerance;
        if output > before.0 + reach {
            return Err(check.error(output.to_f64(), Requirement::AtMost((before.0 + reach).to_f64())));
        }
        if output < before.0 - reach {
            return Err(check.error(output.to_f64(), Requirement::AtLeast((before.0 - reach).to_f64())));
        }
        before = (output, threshold);
    }
    Ok(())
}
