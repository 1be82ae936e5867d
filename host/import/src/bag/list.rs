//! Lists in one file, of each of which a few items are in memory.

use std::fs::File;
use std::io::{self, Read, Seek, SeekFrom, Write};
use std::marker::PhantomData;
use std::path::Path;
use std::sync::Arc;

use recording::input::FromPlace;

use crate::scratch;

/// Items of a list that are written together.
const PART: usize = 1 << 10;
/// Unit: bytes.
const ITEM: usize = 16;

/// What stands beside a whole number in an item.
pub trait Word: Copy {
    fn bits(self) -> u64;
    fn of(bits: u64) -> Self;
}

impl Word for f64 {
    fn bits(self) -> u64 {
        self.to_bits()
    }

    fn of(bits: u64) -> Self {
        Self::from_bits(bits)
    }
}

impl Word for i64 {
    fn bits(self) -> u64 {
        self as u64
    }

    fn of(bits: u64) -> Self {
        bits as i64
    }
}

/// The file of the lists.
#[derive(Debug)]
pub struct Store {
    file: Arc<File>,
    /// Unit: bytes.
    length: u64,
}

/// A list of whole numbers, each with a word.
#[derive(Debug)]
pub struct List<W> {
    /// Where its parts begin in the file.
    parts: Vec<u64>,
    /// What is in no part yet, as bytes.
    last: Vec<u8>,
    words: PhantomData<W>,
}

impl<W> Default for List<W> {
    fn default() -> Self {
        Self { parts: Vec::new(), last: Vec::new(), words: PhantomData }
    }
}

impl<W> List<W> {
    /// How many items there are.
    pub fn len(&self) -> usize {
        self.parts.len() * PART + self.last.len() / ITEM
    }
}

impl Store {
    /// A store whose file is in a folder, else where the system keeps such files.
    ///
    /// # Errors
    /// It cannot be made.
    pub fn new(folder: Option<&Path>) -> io::Result<Self> {
        Ok(Self { file: scratch::file(folder, |_| Ok(()))?.into(), length: 0 })
    }

    /// Adds an item to a list, which is to be of this store.
    ///
    /// # Errors
    /// The file takes no more.
    pub fn push<W: Word>(&mut self, list: &mut List<W>, (number, word): (i64, W)) -> io::Result<()> {
        list.last.extend(number.to_le_bytes());
        list.last.extend(word.bits().to_le_bytes());
        if list.last.len() == PART * ITEM {
            let mut file = &*self.file;
            file.seek(SeekFrom::Start(self.length))?;
            file.write_all(&list.last)?;
            list.parts.push(self.length);
            self.length += list.last.len() as u64;
            list.last.clear();
        }
        Ok(())
    }

    /// The items of a list of this store.
    pub fn items<'a, W: Word>(&self, list: &'a List<W>) -> Items<'a, W> {
        Items { file: Arc::clone(&self.file), list, part: 0, bytes: Vec::new(), place: 0 }
    }

    /// A list of items in the order of their whole numbers, those of one number in the order in
    /// which they come. They are held only if they do not come so.
    ///
    /// # Errors
    /// The items cannot be read, or the file takes no more.
    pub fn sorted<W: Word>(
        &mut self,
        items: impl Iterator<Item = io::Result<(i64, W)>>,
        are_sorted: bool,
    ) -> io::Result<List<W>> {
        let mut list = List::default();
        if are_sorted {
            for item in items {
                self.push(&mut list, item?)?;
            }
        } else {
            let mut held: Vec<(i64, W)> = items.collect::<io::Result<_>>()?;
            held.sort_by_key(|(number, _)| *number);
            held.into_iter().try_for_each(|item| self.push(&mut list, item))?;
        }
        Ok(list)
    }
}

/// The items of a list.
#[derive(Debug)]
pub struct Items<'a, W> {
    file: Arc<File>,
    list: &'a List<W>,
    /// The next part.
    part: usize,
    /// The part before, and where its next item stands.
    bytes: Vec<u8>,
    place: usize,
}

impl<W: Word> Iterator for Items<'_, W> {
    type Item = io::Result<(i64, W)>;

    fn next(&mut self) -> Option<Self::Item> {
        if self.place == self.bytes.len() {
            match self.list.parts.get(self.part) {
                Some(&begins) => {
                    self.bytes.resize(PART * ITEM, 0);
                    if let Err(error) = FromPlace::new(&self.file, begins).read_exact(&mut self.bytes) {
                        return Some(Err(error));
                    }
                }
                None if self.part == self.list.parts.len() => self.bytes.clone_from(&self.list.last),
                None => return None,
            }
            (self.part, self.place) = (self.part + 1, 0);
        }
        let item = self.bytes.get(self.place..self.place + ITEM)?;
        self.place += ITEM;
        let (number, word) = item.split_at(ITEM / 2);
        let of = |bytes: &[u8]| bytes.iter().rev().fold(0, |number, byte| (number << 8) | u64::from(*byte));
        Some(Ok((of(number) as i64, W::of(of(word)))))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lists_in_one_file_give_what_was_put_into_each() {
        let mut store = Store::new(None).expect("a file");
        let (mut values, mut times) = (List::default(), List::default());
        let count = 3 * PART + 5;
        for number in 0..count as i64 {
            store.push(&mut values, (-number, 0.1 * number as f64)).expect("it is written");
            store.push(&mut times, (number, -number)).expect("it is written");
        }
        assert_eq!((values.len(), times.len()), (count, count));
        let found: Vec<(i64, f64)> = store.items(&values).collect::<io::Result<_>>().expect("it is read");
        assert!(found.iter().copied().eq((0..count as i64).map(|number| (-number, 0.1 * number as f64))));
        let found: Vec<(i64, i64)> = store.items(&times).collect::<io::Result<_>>().expect("it is read");
        assert!(found.iter().copied().eq((0..count as i64).map(|number| (number, -number))));
    }

    #[test]
    fn what_comes_in_another_order_is_sorted_and_equals_stay_as_they_come() {
        let mut store = Store::new(None).expect("a file");
        let items = [(3, 1.0), (1, 2.0), (3, 3.0), (1, 4.0)].map(Ok);
        let list = store.sorted(items.into_iter(), false).expect("it is written");
        let found: Vec<(i64, f64)> = store.items(&list).collect::<io::Result<_>>().expect("it is read");
        assert_eq!(found, [(1, 2.0), (1, 4.0), (3, 1.0), (3, 3.0)]);
    }
}
