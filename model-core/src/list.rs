//! A list of at most so many elements in fixed places: no heap, and nothing that can panic.

use core::fmt;
use core::ops::{Deref, DerefMut};

/// At most `N` elements, in order; used as the slice of those that it has.
///
/// ```
/// use model_core::List;
///
/// let mut thresholds = List::<f64, 2>::new();
/// assert_eq!(thresholds.push(0.1), Ok(()));
/// assert_eq!(thresholds.push(0.2), Ok(()));
/// assert_eq!(thresholds.push(0.3), Err(0.3)); // no room for a third
/// assert_eq!(thresholds.iter().sum::<f64>(), 0.1 + 0.2);
/// assert_eq!(List::try_from_iter([0.1, 0.2]), Some(thresholds));
/// ```
#[derive(Clone)]
pub struct List<T, const N: usize> {
    /// Those beyond the length are left over.
    places: [T; N],
    length: usize,
}

impl<T: Copy + Default, const N: usize> List<T, N> {
    /// Without elements.
    pub fn new() -> Self {
        Self { places: [T::default(); N], length: 0 }
    }

    /// The elements of an iterator; `None` where they are more than `N`.
    pub fn try_from_iter(elements: impl IntoIterator<Item = T>) -> Option<Self> {
        let mut list = Self::new();
        for element in elements {
            list.push(element).ok()?;
        }
        Some(list)
    }
}

impl<T, const N: usize> List<T, N> {
    /// Adds an element at the end.
    ///
    /// # Errors
    /// There is no room; the element comes back.
    pub fn push(&mut self, element: T) -> Result<(), T> {
        let Some(place) = self.places.get_mut(self.length) else { return Err(element) };
        *place = element;
        self.length += 1;
        Ok(())
    }

    /// Forgets the elements from an index on.
    pub fn truncate(&mut self, length: usize) {
        self.length = self.length.min(length);
    }

    /// Its elements.
    #[inline(always)]
    pub fn as_slice(&self) -> &[T] {
        // The length is never above the places.
        self.places.get(..self.length).unwrap_or_default()
    }
}

impl<T: Copy + Default, const N: usize> From<[T; N]> for List<T, N> {
    /// A full list.
    fn from(places: [T; N]) -> Self {
        Self { places, length: N }
    }
}

impl<T: Copy + Default, const N: usize> FromIterator<T> for List<T, N> {
    /// For iterators of at most `N` elements: of a longer one the first `N`, which a build with
    /// debug assertions does not let pass. [`List::try_from_iter`] tells.
    fn from_iter<I: IntoIterator<Item = T>>(elements: I) -> Self {
        let mut list = Self::new();
        let fits = elements.into_iter().all(|element| list.push(element).is_ok());
        debug_assert!(fits, "more than {N} elements");
        list
    }
}

impl<T: Copy + Default, const N: usize> Default for List<T, N> {
    fn default() -> Self {
        Self::new()
    }
}

impl<T, const N: usize> Deref for List<T, N> {
    type Target = [T];

    #[inline(always)]
    fn deref(&self) -> &[T] {
        self.as_slice()
    }
}

impl<T, const N: usize> DerefMut for List<T, N> {
    #[inline(always)]
    fn deref_mut(&mut self) -> &mut [T] {
        self.places.get_mut(..self.length).unwrap_or_default()
    }
}

impl<T, const N: usize> AsRef<[T]> for List<T, N> {
    fn as_ref(&self) -> &[T] {
        self
    }
}

impl<T, const N: usize> AsMut<[T]> for List<T, N> {
    fn as_mut(&mut self) -> &mut [T] {
        self
    }
}

impl<'a, T, const N: usize> IntoIterator for &'a List<T, N> {
    type Item = &'a T;
    type IntoIter = core::slice::Iter<'a, T>;

    #[inline(always)]
    fn into_iter(self) -> Self::IntoIter {
        self.iter()
    }
}

impl<'a, T, const N: usize> IntoIterator for &'a mut List<T, N> {
    type Item = &'a mut T;
    type IntoIter = core::slice::IterMut<'a, T>;

    fn into_iter(self) -> Self::IntoIter {
        self.iter_mut()
    }
}

impl<T: PartialEq, const N: usize> PartialEq for List<T, N> {
    fn eq(&self, other: &Self) -> bool {
        **self == **other
    }
}

impl<T: fmt::Debug, const N: usize> fmt::Debug for List<T, N> {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        (**self).fmt(formatter)
    }
}

#[cfg(feature = "serde")]
mod serialized {
    use core::fmt;
    use core::marker::PhantomData;

    use serde::de::{Error, SeqAccess, Visitor};
    use serde::{Deserialize, Deserializer, Serialize, Serializer};

    use super::List;

    impl<T: Serialize, const N: usize> Serialize for List<T, N> {
        fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
            serializer.collect_seq(self)
        }
    }

    impl<'a, T: Copy + Default + Deserialize<'a>, const N: usize> Deserialize<'a> for List<T, N> {
        fn deserialize<D: Deserializer<'a>>(deserializer: D) -> Result<Self, D::Error> {
            deserializer.deserialize_seq(Elements(PhantomData))
        }
    }

    struct Elements<T, const N: usize>(PhantomData<T>);

    impl<'a, T: Copy + Default + Deserialize<'a>, const N: usize> Visitor<'a> for Elements<T, N> {
        type Value = List<T, N>;

        fn expecting(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
            write!(formatter, "a list of at most {N}")
        }

        fn visit_seq<A: SeqAccess<'a>>(self, mut elements: A) -> Result<List<T, N>, A::Error> {
            let mut list = List::new();
            while let Some(element) = elements.next_element()? {
                list.push(element).map_err(|_| A::Error::invalid_length(N + 1, &self))?;
            }
            Ok(list)
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_has_no_room_comes_back_and_the_list_stays() {
        let mut list = List::<u8, 2>::try_from_iter([1, 2]).expect("two fit");
        assert_eq!(list.push(3), Err(3));
        assert_eq!(*list, [1, 2]);
        assert_eq!(List::<u8, 2>::try_from_iter([1, 2, 3]), None);
    }

    #[test]
    fn what_was_forgotten_does_not_tell_lists_apart() {
        let mut list = List::<u8, 2>::from([1, 2]);
        list.truncate(1);
        list.truncate(2);
        assert_eq!(list, List::try_from_iter([1]).expect("one fits"));
    }
}
