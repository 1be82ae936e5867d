//! What takes long to make, and is asked for again.

use std::sync::{Mutex, PoisonError};

/// What was made so far.
pub struct Known<K, V>(Mutex<Vec<(K, V)>>);

impl<K, V> Default for Known<K, V> {
    fn default() -> Self {
        Self(Mutex::default())
    }
}

impl<K: PartialEq, V: Clone> Known<K, V> {
    /// What is known by a key, or else is made now. Two threads that ask for the same at once both make it: what is
    /// made hangs on the key alone.
    pub fn get(&self, key: K, make: impl FnOnce() -> V) -> V {
        let known = || self.0.lock().unwrap_or_else(PoisonError::into_inner);
        let found = known().iter().find(|(of, _)| *of == key).map(|(_, value)| value.clone());
        found.unwrap_or_else(|| {
            let value = make();
            known().push((key, value.clone()));
            value
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_known_is_not_made_again() {
        let known = Known::default();
        assert_eq!(known.get("one", || 1), 1);
        assert_eq!(known.get("two", || 2), 2);
        assert_eq!(known.get("one", || unreachable!("it is known")), 1);
    }
}
