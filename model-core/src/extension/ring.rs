//! What was put in last, in fixed places: the oldest leaves first.

/// At most `N` elements, the oldest first.
#[derive(Clone, Debug)]
pub(super) struct Ring<T, const N: usize> {
    /// From the place of the oldest on, past the end to the first place; others are left over.
    places: [T; N],
    oldest: usize,
    length: usize,
}

impl<T: Copy + Default, const N: usize> Ring<T, N> {
    /// Without elements.
    pub(super) fn new() -> Self {
        Self { places: [T::default(); N], oldest: 0, length: 0 }
    }
}

impl<T, const N: usize> Ring<T, N> {
    pub(super) fn is_full(&self) -> bool {
        self.length >= N
    }

    /// The oldest element but so many; none where there are not as many.
    pub(super) fn get(&self, index: usize) -> Option<&T> {
        if index < self.length { self.places.get(self.place(index)) } else { None }
    }

    /// Adds the youngest; whether there was room.
    pub(super) fn push(&mut self, element: T) -> bool {
        let place = self.place(self.length);
        match self.places.get_mut(place) {
            Some(place) if self.length < N => *place = element,
            _ => return false,
        }
        self.length += 1;
        true
    }

    /// Forgets the oldest, where there is one.
    pub(super) fn forget_oldest(&mut self) {
        if self.length > 0 {
            self.oldest = self.place(1);
            self.length -= 1;
        }
    }

    /// From the oldest on.
    pub(super) fn iter(&self) -> impl Iterator<Item = &T> {
        self.places.iter().skip(self.oldest).chain(&self.places).take(self.length)
    }

    /// Where the element of an index, at most `N`, is.
    fn place(&self, index: usize) -> usize {
        let place = self.oldest + index;
        if place < N { place } else { place - N }
    }
}

impl<T: PartialEq, const N: usize> PartialEq for Ring<T, N> {
    fn eq(&self, other: &Self) -> bool {
        self.iter().eq(other.iter())
    }
}

#[cfg(feature = "serde")]
impl<T: serde::Serialize, const N: usize> serde::Serialize for Ring<T, N> {
    /// From the oldest on.
    fn serialize<S: serde::Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.collect_seq(self.iter())
    }
}

#[cfg(feature = "serde")]
impl<'a, T: Copy + Default + serde::Deserialize<'a>, const N: usize> serde::Deserialize<'a> for Ring<T, N> {
    fn deserialize<D: serde::Deserializer<'a>>(deserializer: D) -> Result<Self, D::Error> {
        let elements = crate::list::List::<T, N>::deserialize(deserializer)?;
        let mut ring = Self::new();
        // There are as many places.
        elements.iter().all(|element| ring.push(*element));
        Ok(ring)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_oldest_leaves_first_and_places_are_used_again() {
        let mut ring = Ring::<u8, 3>::new();
        for number in 0..10 {
            if ring.is_full() {
                assert!(!ring.push(number));
                ring.forget_oldest();
            }
            assert!(ring.push(number));
            let oldest = number.saturating_sub(2);
            assert!(ring.iter().copied().eq(oldest..=number));
            assert_eq!((ring.get(0), ring.get(3)), (Some(&oldest), None));
        }
        (0..4).for_each(|_| ring.forget_oldest());
        assert_eq!(ring.get(0), None);
        assert_eq!(ring, Ring::new());
    }
}
