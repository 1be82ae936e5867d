//! The turning points on one side: a stack that is searched by halving.

use crate::real::Real;

/// A point that the input has turned at, or where it stands.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
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
    pub(crate) fn inverted(self) -> Self {
        Self { v: self.u, u: self.v, driven: self.driven }
    }
}

/// Turning points in `N` places, the innermost last.
#[derive(Clone, Debug)]
pub(crate) struct TurnStack<T, const N: usize> {
    places: [Turn<T>; N],
    /// How many of them are in use.
    height: usize,
}

impl<T, const N: usize> TurnStack<T, N> {
    /// The turning points, the outermost first.
    pub(crate) fn iter(&self) -> impl Iterator<Item = &Turn<T>> {
        self.places.iter().take(self.height)
    }
}

impl<T: Real, const N: usize> TurnStack<T, N> {
    /// Without turning points.
    pub(crate) fn new() -> Self {
        let free = Turn { v: T::ZERO, u: T::ZERO, driven: 0 };
        Self { places: [free; N], height: 0 }
    }

    /// Makes it the same as another one; the places that are not in use are left as they are.
    pub(crate) fn copy_from(&mut self, other: &Self) {
        self.places.iter_mut().zip(other.iter()).for_each(|(place, other)| *place = *other);
        self.height = other.height;
    }

    /// The number of turning points, and the height of the innermost.
    #[inline(always)]
    pub(crate) fn height(&self) -> usize {
        self.height
    }

    /// As [`iter`](Self::iter), to be changed.
    pub(crate) fn iter_mut(&mut self) -> impl Iterator<Item = &mut Turn<T>> {
        self.places.iter_mut().take(self.height)
    }

    /// The turning point of a height, at most [`height`](Self::height); none for 0.
    #[inline(always)]
    pub(crate) fn at(&self, height: usize) -> Option<&Turn<T>> {
        self.places.get(height.wrapping_sub(1))
    }

    /// Adds the innermost turning point; whether it found a place.
    #[inline(always)]
    pub(crate) fn push(&mut self, turn: Turn<T>) -> bool {
        let found = self.places.get_mut(self.height).map(|place| *place = turn).is_some();
        self.height += usize::from(found);
        found
    }

    /// Forgets the turning points above a height, at most [`height`](Self::height).
    #[inline(always)]
    pub(crate) fn truncate(&mut self, height: usize) {
        self.height = height;
    }

    /// Forgets the turning points from a height on, at most [`height`](Self::height), and puts
    /// another there.
    #[inline(always)]
    pub(crate) fn replace(&mut self, height: usize, turn: Turn<T>) {
        self.height = height;
        if let Some(place) = self.places.get_mut(height.wrapping_sub(1)) {
            *place = turn;
        }
    }

    /// The height of the innermost turning point that a move does not pass: it passes those from
    /// there on.
    #[inline(always)]
    pub(crate) fn height_of_kept(&self, passes: impl Fn(&Turn<T>) -> bool) -> usize {
        self.places.get(..self.height).map_or(0, |places| places.partition_point(|turn| !passes(turn)))
    }
}

impl<T: PartialEq, const N: usize> PartialEq for TurnStack<T, N> {
    fn eq(&self, other: &Self) -> bool {
        self.iter().eq(other.iter())
    }
}

#[cfg(feature = "serde")]
impl<T: serde::Serialize, const N: usize> serde::Serialize for TurnStack<T, N> {
    /// Those in use.
    fn serialize<S: serde::Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.collect_seq(self.iter())
    }
}

#[cfg(feature = "serde")]
impl<'a, T: Real + serde::Deserialize<'a>, const N: usize> serde::Deserialize<'a> for TurnStack<T, N> {
    fn deserialize<D: serde::Deserializer<'a>>(deserializer: D) -> Result<Self, D::Error> {
        let turns = crate::list::List::<Turn<T>, N>::deserialize(deserializer)?;
        let mut stack = Self::new();
        // There are as many places.
        turns.iter().all(|turn| stack.push(*turn));
        Ok(stack)
    }
}
