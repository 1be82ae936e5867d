//! The log by which the starter knows what to start: a word for each step, behind the others.
//!
//! # Contract
//! A word is a code and its complement, so that a word that a loss of power cuts short is not
//! valid: programming clears bits only, and of each bit one of the two halves has to be cleared.
//! Such a word is skipped: the step was not taken. The log of a board that was flashed is blank,
//! and says
//! [`Place::A`].
//!
//! # Limits
//! It is never erased over the bus: 4,096 words are some 700 updates. Then the board takes no more,
//! until it is flashed.

use wire::image::Place;

/// What nobody has written.
const BLANK: u32 = !0;
/// How often an image is tried: a loss of power during a trial takes none from it for good.
pub const TRIES: u8 = 3;

/// A step.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Entry {
    /// From now on the image in this place runs, and no other.
    ForGood(Place),
    /// The image in this place is whole, and is to be tried.
    Try(Place),
    /// It is tried: by the starter, before it begins.
    Tried,
}

impl Entry {
    const ALL: [Self; 5] = [
        Self::ForGood(Place::A),
        Self::ForGood(Place::B),
        Self::Try(Place::A),
        Self::Try(Place::B),
        Self::Tried,
    ];

    /// As it stands in the log.
    pub const fn word(self) -> u32 {
        let code = match self {
            Self::ForGood(place) => 0x10 | place.number(),
            Self::Try(place) => 0x20 | place.number(),
            Self::Tried => 0x30,
        };
        code as u32 | (!code as u32) << 16
    }

    fn of_word(word: u32) -> Option<Self> {
        Self::ALL.into_iter().find(|entry| entry.word() == word)
    }
}

/// An image that is, or was, tried.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Trial {
    /// Where it stands.
    pub place: Place,
    /// How often it was started.
    pub tries: u8,
}

/// What the log says.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Log {
    /// Whose image runs if no other is tried.
    pub for_good: Place,
    /// The one that is tried.
    pub trial: Option<Trial>,
    /// Words up to the last that is not blank.
    pub used: usize,
}

impl Log {
    /// Reads it.
    pub fn of(words: &[u32]) -> Self {
        let used = words.iter().rposition(|word| *word != BLANK).map_or(0, |last| last + 1);
        let mut log = Self { for_good: Place::A, trial: None, used };
        for entry in words.iter().take(used).filter_map(|word| Entry::of_word(*word)) {
            match entry {
                Entry::ForGood(place) => (log.for_good, log.trial) = (place, None),
                Entry::Try(place) => log.trial = Some(Trial { place, tries: 0 }),
                Entry::Tried => {
                    log.trial.iter_mut().for_each(|trial| trial.tries = trial.tries.saturating_add(1));
                }
            }
        }
        log
    }

    /// The place whose image is to be tried at this start.
    pub fn to_try(&self) -> Option<Place> {
        self.trial.filter(|trial| trial.tries < TRIES).map(|trial| trial.place)
    }
}

#[cfg(test)]
mod tests {
    extern crate std;
    use super::*;
    use std::vec::Vec;

    fn of(entries: &[Entry]) -> Log {
        let mut words: Vec<u32> = entries.iter().map(|entry| entry.word()).collect();
        words.resize(16, BLANK);
        Log::of(&words)
    }

    #[test]
    fn an_image_is_tried_three_times_unless_it_stays() {
        use Entry::{ForGood, Tried, Try};
        assert_eq!((of(&[]).for_good, of(&[]).to_try()), (Place::A, None));
        let mut entries = std::vec![ForGood(Place::A), Try(Place::B)];
        for _ in 0..TRIES {
            assert_eq!(of(&entries).to_try(), Some(Place::B));
            entries.push(Tried);
        }
        assert_eq!((of(&entries).for_good, of(&entries).to_try()), (Place::A, None));
        entries.push(ForGood(Place::B));
        assert_eq!((of(&entries).for_good, of(&entries).trial), (Place::B, None));
    }

    #[test]
    fn what_power_leaves_of_a_word_is_no_step() {
        for entry in Entry::ALL {
            let word = entry.word();
            let zeros: Vec<u32> = (0..32).filter(|bit| word >> bit & 1 == 0).collect();
            assert_eq!(zeros.len(), 16);
            // All but all of the bits that have to be programmed are.
            for chosen in 0..(1u32 << zeros.len()) - 1 {
                let programmed = zeros.iter().enumerate().filter(|(index, _)| chosen >> index & 1 == 1);
                let left = programmed.fold(BLANK, |left, (_, bit)| left & !(1 << bit));
                assert_eq!(Entry::of_word(left), None, "{left:#010x} of {word:#010x}");
            }
        }
    }
}
