//! What a bank of many plays remembers: the turning points of its input that have not been wiped
//! out.
//!
//! # Design
//! A play with threshold r follows the input once that has moved by more than 2 r from where it
//! last turned. So of the history only the turning points count, and of these only nested ones: a
//! smaller swing inside a larger one, high and low alternating. Moving beyond a turning point wipes
//! it out with its partner. See [`crate::play`] for what follows between them.
//!
//! # Bounded memory
//! Once a move has driven all plays that the move before it drove, none depends any more on where
//! that one turned. What is kept in its place is the point where a move back would begin to drive
//! the next play: the memory is then the same whatever swings led there, to the last bit. And where
//! a third move drives just those plays too, the two before it are forgotten altogether. So no more
//! than two turning points are kept for each number of driven plays, one for all plays; with one
//! for none, that is at most N highs and N lows.

use crate::convert::counted_from;
use crate::error::{Check, ParameterError, Requirement};
use crate::real::Real;
use crate::turn_stack::{Turn, TurnStack};

/// The turning points of a bank of at most `N` plays.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(
    feature = "serde",
    derive(serde::Serialize, serde::Deserialize),
    serde(bound = "T: Real + serde::Serialize + serde::de::DeserializeOwned")
)]
pub(crate) struct TurningPoints<T, const N: usize> {
    /// By falling input: each within the ones before.
    pub(crate) highs: TurnStack<T, N>,
    /// By rising input.
    pub(crate) lows: TurnStack<T, N>,
    /// Where the input stands.
    pub(crate) last: Turn<T>,
    /// Whether the input rose, or rested after it had risen: the innermost turning point is then a
    /// low.
    pub(crate) rising: bool,
}

impl<T: Real, const N: usize> TurningPoints<T, N> {
    /// Without turning points: all plays were driven.
    pub(crate) fn new(last: Turn<T>, rising: bool) -> Self {
        Self { highs: TurnStack::new(), lows: TurnStack::new(), last, rising }
    }

    /// Makes it the same as another one of the same bank.
    pub(crate) fn copy_from(&mut self, other: &Self) {
        self.highs.copy_from(&other.highs);
        self.lows.copy_from(&other.lows);
        (self.last, self.rising) = (other.last, other.rising);
    }

    /// The turning points that a rising move comes from and those that it goes towards; for a
    /// falling one the other way round.
    #[inline(always)]
    pub(crate) fn sides<const RISING: bool>(&self) -> (&TurnStack<T, N>, &TurnStack<T, N>) {
        if RISING { (&self.lows, &self.highs) } else { (&self.highs, &self.lows) }
    }

    /// As [`sides`](Self::sides), to be changed.
    #[inline(always)]
    pub(crate) fn sides_mut<const RISING: bool>(&mut self) -> (&mut TurnStack<T, N>, &mut TurnStack<T, N>) {
        if RISING { (&mut self.lows, &mut self.highs) } else { (&mut self.highs, &mut self.lows) }
    }

    /// Whether `v` is above where the input stands; where it is neither above nor below, whether
    /// the input rose before.
    pub(crate) fn goes_up_to(&self, v: T) -> bool {
        if self.rising { v >= self.last.v } else { v > self.last.v }
    }

    /// Adds the innermost turning point: a low where the input rises from it. Whether it found a
    /// place.
    pub(crate) fn push(&mut self, turn: Turn<T>) -> bool {
        if self.rising { self.lows.push(turn) } else { self.highs.push(turn) }
    }

    /// All turning points, the outermost first, with whether they are highs.
    pub(crate) fn outermost_first(&self) -> impl Iterator<Item = (Turn<T>, bool)> {
        let (highs, lows) = (self.highs.height(), self.lows.height());
        let high_first = highs > lows || (self.rising && highs == lows);
        let (first, second) = if high_first { (&self.highs, &self.lows) } else { (&self.lows, &self.highs) };
        let mut second = second.iter();
        first.iter().flat_map(move |one| {
            let other = second.next().map(|turn| (*turn, !high_first));
            [(*one, high_first)].into_iter().chain(other)
        })
    }

    /// The same memory, seen from the inverse bank.
    pub(crate) fn inverted(&self) -> Self {
        self.with(Turn::inverted)
    }

    /// The same where inputs count from `v` on, and outputs from `u`.
    pub(crate) fn counted_from(&self, v: f64, u: f64) -> Self {
        self.with(|turn| Turn { v: counted_from(turn.v, v), u: counted_from(turn.u, u), ..turn })
    }

    /// The same with other points.
    fn with(&self, other: impl Fn(Turn<T>) -> Turn<T>) -> Self {
        let mut all = self.clone();
        all.highs.iter_mut().chain(all.lows.iter_mut()).for_each(|turn| *turn = other(*turn));
        all.last = other(self.last);
        all
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
