//! A move of a bank of plays in one direction, rising or falling: how far it is to go, what it
//! passes and what it has reached.

use crate::real::Real;

/// How far a move is to go: to the input `v`, but no farther than to the output `end`.
pub(crate) struct Target<T> {
    pub(crate) v: T,
    pub(crate) end: Option<T>,
}

impl<T: Real> Target<T> {
    /// Whether a move that leads to this output has come to the end.
    #[inline(always)]
    pub(crate) fn is_reached<const RISING: bool>(&self, u: T) -> bool {
        self.end.is_some_and(|end| reaches::<T, RISING>(u, end))
    }
}

/// The output after a move.
pub(crate) enum Reached<T> {
    /// Where it was to go.
    Inside(T),
    /// The end of the range.
    End(T),
}

impl<T> Reached<T> {
    pub(crate) fn output(self) -> T {
        match self {
            Self::Inside(u) | Self::End(u) => u,
        }
    }
}

/// Whether a move in one direction passes `other` on its way to `to`.
#[inline(always)]
pub(crate) fn passes<T: Real, const RISING: bool>(to: T, other: T) -> bool {
    if RISING { to > other } else { to < other }
}

/// Whether a move in one direction to `to` reaches `other`.
#[inline(always)]
pub(crate) fn reaches<T: Real, const RISING: bool>(to: T, other: T) -> bool {
    if RISING { to >= other } else { to <= other }
}

/// How far it is from one coordinate to another, in the direction of a move.
#[inline(always)]
pub(crate) fn way<T: Real, const RISING: bool>(from: T, to: T) -> T {
    if RISING { to - from } else { from - to }
}

/// The coordinate that far from another, in the direction of a move.
#[inline(always)]
pub(crate) fn go<T: Real, const RISING: bool>(from: T, way: T) -> T {
    if RISING { from + way } else { from - way }
}
