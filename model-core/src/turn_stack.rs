//! The turning points on one side: a stack, searched from its innermost end without a test for its bottom.
//!
//! Where there are few turning points, the lower 16 places hold others that no move ever passes. So the innermost 16
//! places can always be halved as a curve's segments are, see [`crate::curve`], however few are in use.
//!
//! A height counts places, from the lowest on: below the outermost turning point it is not 0 but [`TurnStack::base`].

use core::array;

use crate::curve::{FEW_SEGMENTS, halve};
use crate::real::Real;
use crate::turning_points::Turn;

/// So many places suffice for fewer than 16 turning points.
pub(crate) const FEW_TURNS: usize = 2 * FEW_SEGMENTS;

/// A place of the stack.
#[derive(Clone, Copy, Debug)]
struct Place<T> {
    turn: Turn<T>,
    /// How many places there are up to this one, from the lowest on.
    height: usize,
}

/// Turning points in `N` places, the innermost highest.
#[derive(Clone, Debug)]
pub(crate) struct TurnStack<T, const N: usize> {
    places: [Place<T>; N],
    /// The height of the innermost turning point.
    height: usize,
    /// How many of the lowest places are never passed.
    base: usize,
}

impl<T, const N: usize> TurnStack<T, N> {
    /// The turning points, the outermost first.
    pub(crate) fn iter(&self) -> impl Iterator<Item = &Turn<T>> {
        self.places.iter().take(self.height).skip(self.base).map(|place| &place.turn)
    }
}

impl<T: Real, const N: usize> TurnStack<T, N> {
    /// Without turning points. `few`: whether there will never be 16, and `N` is at least [`FEW_TURNS`].
    pub(crate) fn new(few: bool) -> Self {
        // Not a number: neither above nor below any input.
        let never = T::INFINITY + -T::INFINITY;
        let turn = Turn { v: never, u: never, driven: 0 };
        let base = if few { FEW_SEGMENTS } else { 0 };
        Self { places: array::from_fn(|i| Place { turn, height: i + 1 }), height: base, base }
    }

    /// Makes it the same as another one with the same base; the places above are left as they are.
    pub(crate) fn copy_from(&mut self, other: &Self) {
        let used = self.places.iter_mut().zip(&other.places).take(other.height).skip(other.base);
        used.for_each(|(place, other)| place.turn = other.turn);
        self.height = other.height;
    }

    /// The height of the innermost turning point; the [`base`](Self::base) where there is none.
    #[inline(always)]
    pub(crate) fn height(&self) -> usize {
        self.height
    }

    /// The height below the outermost turning point. `FEW`: whether there are few.
    #[inline(always)]
    pub(crate) const fn base<const FEW: bool>() -> usize {
        if FEW { FEW_SEGMENTS } else { 0 }
    }

    /// As [`iter`](Self::iter), to be changed.
    pub(crate) fn iter_mut(&mut self) -> impl Iterator<Item = &mut Turn<T>> {
        self.places.iter_mut().take(self.height).skip(self.base).map(|place| &mut place.turn)
    }

    /// The turning point of a height, at most [`height`](Self::height); none for the base. `FEW`: whether there are few.
    #[inline(always)]
    pub(crate) fn at<const FEW: bool>(&self, height: usize) -> Option<&Turn<T>> {
        let (_, places) = self.places.split_at_checked(Self::base::<FEW>())?;
        places.get(height.wrapping_sub(Self::base::<FEW>() + 1)).map(|place| &place.turn)
    }

    /// Adds the innermost turning point; whether it found a place.
    #[inline(always)]
    pub(crate) fn push(&mut self, turn: Turn<T>) -> bool {
        let place = self.places.get_mut(self.height);
        let found = place.map(|place| place.turn = turn).is_some();
        self.height += usize::from(found);
        found
    }

    /// Forgets the turning points above a height, at most [`height`](Self::height).
    #[inline(always)]
    pub(crate) fn truncate(&mut self, height: usize) {
        self.height = height;
    }

    /// Forgets the turning points from a height on, at most [`height`](Self::height), and puts another there.
    #[inline(always)]
    pub(crate) fn replace(&mut self, height: usize, turn: Turn<T>) {
        self.height = height;
        if let Some(place) = self.places.get_mut(height.wrapping_sub(1)) {
            place.turn = turn;
        }
    }

    /// The height of the innermost turning point that a move does not pass: it passes those from there on. `FEW`: whether
    /// there are few.
    #[inline(always)]
    pub(crate) fn height_of_kept<const FEW: bool>(&self, passes: impl Fn(&Turn<T>) -> bool) -> usize {
        let kept = |place: &Place<T>| !passes(&place.turn);
        if FEW {
            let innermost = self.places.get(self.height.wrapping_sub(FEW_SEGMENTS)..);
            let innermost = innermost.and_then(|places| places.first_chunk::<FEW_SEGMENTS>());
            return innermost.map_or(FEW_SEGMENTS, |innermost| halve(innermost, kept).height);
        }
        self.places.get(..self.height).map_or(0, |places| places.partition_point(kept))
    }
}

impl<T: PartialEq, const N: usize> PartialEq for TurnStack<T, N> {
    fn eq(&self, other: &Self) -> bool {
        self.iter().eq(other.iter())
    }
}
