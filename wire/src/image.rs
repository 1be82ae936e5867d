//! What is known of an image of the board without running it: where it belongs in the flash, and
//! its head.
//!
//! # Design
//! An image runs where it was linked, in one of two [`Place`]s. [`HEAD_OFFSET`] behind its begin
//! stands its head, [`HEAD_WORDS`] words; whoever builds it puts in the last of them: begin,
//! length, checked ranges, checksum ([`Head::sealed`]). Behind its length stand the
//! [`SIGNATURE_BYTES`] of its signature, over [`signed`].
//!
//! # Limits
//! The checksum is over the ranges and the head, not over the gaps between them, which a debugger
//! may fill as it likes; the signature is over all of it.

/// One of the two places for an image.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Place {
    /// Sectors 4 to 7: of 64 KB, and three of 128 KB.
    A,
    /// Sectors 8 to 11, of 128 KB each.
    B,
}

impl Place {
    /// Both.
    pub const BOTH: [Self; 2] = [Self::A, Self::B];

    /// The one that this is not.
    pub const fn other(self) -> Self {
        match self {
            Self::A => Self::B,
            Self::B => Self::A,
        }
    }

    /// Its first address.
    pub const fn begin(self) -> u32 {
        match self {
            Self::A => 0x0801_0000,
            Self::B => 0x0808_0000,
        }
    }

    /// Ends of its sectors, from its begin on. Unit: byte.
    pub const fn sectors(self) -> [u32; 4] {
        match self {
            Self::A => [0x1_0000, 0x3_0000, 0x5_0000, 0x7_0000],
            Self::B => [0x2_0000, 0x4_0000, 0x6_0000, 0x8_0000],
        }
    }

    /// Unit: byte.
    pub const fn bytes(self) -> u32 {
        let [.., end] = self.sectors();
        end
    }

    /// The number by which registers tell it.
    pub const fn number(self) -> u16 {
        match self {
            Self::A => 1,
            Self::B => 2,
        }
    }
}

/// Where the head stands, from the begin of the image on. Unit: byte.
pub const HEAD_OFFSET: usize = 0x200;
/// Words of the head.
pub const HEAD_WORDS: usize = 22;
/// Words of the head that the image is linked with; the others are put in behind that.
pub const LINKED_WORDS: usize = 11;
/// Ranges of the flash that the checksum is over, at the most.
pub const RANGES: usize = 4;
/// Of an Ed25519 signature.
pub const SIGNATURE_BYTES: usize = 64;
/// `MGPI` in the flash.
const MAGIC: u32 = 0x4950_474D;
/// What nobody has put in.
const NOTHING: u32 = !0;

/// For which board an image is, by what it does to a valve.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum BoardKind {
    /// A regulator, by a voltage at PA4.
    Regulator,
    /// A coil, by pulses at PA6.
    Coil,
    /// Two regulators at a joint, by voltages at PA4 and PA5.
    Joint,
}

impl BoardKind {
    /// The number by which head and registers tell it.
    pub const fn number(self) -> u16 {
        match self {
            Self::Regulator => 1,
            Self::Coil => 2,
            Self::Joint => 3,
        }
    }
}

/// What the image is linked with.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Linked {
    /// Number of its [`BoardKind`].
    pub kind: u16,
    /// First and last revision of the board that it is for.
    pub revisions: [u16; 2],
    /// Major, minor, patch.
    pub release: [u16; 3],
    /// Of the messages.
    pub wire: u16,
    /// Of the parameters that it stores.
    pub layout: u16,
    /// Whether the sources differed from the commit.
    pub is_modified: bool,
    /// The git commit, two bytes a word, the first in the high half.
    pub commit: [u16; 10],
}

impl Linked {
    /// Its words.
    pub const fn words(&self) -> [u32; LINKED_WORDS] {
        let Self { kind, revisions: [first, last], release: [major, minor, patch], wire, layout, .. } = *self;
        let [a, b, c, d, e, f, g, h, i, j] = self.commit;
        [
            MAGIC,
            join(kind, 1),
            join(first, last),
            join(major, minor),
            join(patch, wire),
            join(layout, self.is_modified as u16),
            join(a, b),
            join(c, d),
            join(e, f),
            join(g, h),
            join(i, j),
        ]
    }

    /// From the words; `None` where they are no head of this format.
    fn of_words(words: [u32; LINKED_WORDS]) -> Option<Self> {
        let [magic, kind, revisions, release, patch, layout, commit @ ..] = words;
        let [kind, format] = halves(kind);
        let ([major, minor], [patch, wire], [layout, modified]) =
            (halves(release), halves(patch), halves(layout));
        let [[a, b], [c, d], [e, f], [g, h], [i, j]] = commit.map(halves);
        (magic == MAGIC && format == 1).then_some(Self {
            kind,
            revisions: halves(revisions),
            release: [major, minor, patch],
            wire,
            layout,
            is_modified: modified != 0,
            commit: [a, b, c, d, e, f, g, h, i, j],
        })
    }
}

const fn join(low: u16, high: u16) -> u32 {
    low as u32 | (high as u32) << 16
}

const fn halves(word: u32) -> [u16; 2] {
    [word as u16, (word >> 16) as u16]
}

/// The head of an image.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Head {
    /// What it was linked with.
    pub linked: Linked,
    /// First address, and bytes without the signature.
    pub place: [u32; 2],
    /// First address and bytes of each range that the checksum is over.
    pub ranges: [[u32; 2]; RANGES],
    /// CRC-32 (ISO-HDLC) over the ranges, then over the words of the head before it.
    pub checksum: u32,
}

impl Head {
    /// The head of an image that stands in this memory; `None` where there is none.
    pub fn of(memory: &[u8]) -> Option<Self> {
        let bytes = memory.get(HEAD_OFFSET..HEAD_OFFSET + 4 * HEAD_WORDS)?;
        let (words, _) = bytes.as_chunks();
        let mut head = [0; HEAD_WORDS];
        head.iter_mut().zip(words).for_each(|(word, bytes)| *word = u32::from_le_bytes(*bytes));
        let (linked, put_in) = head.split_first_chunk::<LINKED_WORDS>()?;
        let [begin, length, ranges @ .., checksum] =
            *<&[u32; HEAD_WORDS - LINKED_WORDS]>::try_from(put_in).ok()?;
        let [a, b, c, d, e, f, g, h] = ranges;
        Some(Self {
            linked: Linked::of_words(*linked)?,
            place: [begin, length],
            ranges: [[a, b], [c, d], [e, f], [g, h]],
            checksum,
        })
    }

    /// Whether anybody has put checksum and length in.
    pub const fn is_sealed(&self) -> bool {
        self.place[1] != NOTHING
    }

    /// Shows what the checksum is over; `None` where a range is not within the memory, which begins
    /// at this address.
    pub fn for_each(&self, memory: &[u8], begin: u32, mut show: impl FnMut(&[u8])) -> Option<()> {
        for [first, bytes] in self.ranges {
            let from = first.checked_sub(begin)? as usize;
            show(memory.get(from..from.checked_add(bytes as usize)?)?);
        }
        show(memory.get(HEAD_OFFSET..HEAD_OFFSET + 4 * (HEAD_WORDS - 1))?);
        Some(())
    }

    /// The words that are put in behind linking, but for the checksum.
    pub fn sealed(place: [u32; 2], ranges: [[u32; 2]; RANGES]) -> [u32; HEAD_WORDS - LINKED_WORDS - 1] {
        let [[a, b], [c, d], [e, f], [g, h]] = ranges;
        [place[0], place[1], a, b, c, d, e, f, g, h]
    }
}

/// What a signature is made of: this, with the SHA-256 of the whole image in its end.
pub fn signed(digest: [u8; 32]) -> [u8; 48] {
    let mut message = *b"mgpi image 1    ................................";
    if let Some(end) = message.last_chunk_mut() {
        *end = digest;
    }
    message
}

#[cfg(test)]
mod tests {
    extern crate std;
    use super::*;
    use std::vec;

    #[test]
    fn a_head_is_read_as_it_was_written_and_its_ranges_are_within_the_memory() {
        let linked = Linked {
            kind: 1,
            revisions: [0, 7],
            release: [1, 2, 3],
            wire: 9,
            layout: 5,
            is_modified: true,
            commit: core::array::from_fn(|index| index as u16),
        };
        let begin = Place::B.begin();
        let ranges = [[begin, 16], [begin + 0x300, 4], [begin, 0], [begin, 0]];
        let mut memory = vec![0xFF; 0x400];
        let words = [&linked.words()[..], &Head::sealed([begin, 0x400], ranges), &[77]].concat();
        let bytes: vec::Vec<u8> = words.iter().flat_map(|word| word.to_le_bytes()).collect();
        memory[HEAD_OFFSET..HEAD_OFFSET + bytes.len()].copy_from_slice(&bytes);
        let head = Head::of(&memory).unwrap();
        assert_eq!(head, Head { linked, place: [begin, 0x400], ranges, checksum: 77 });
        let mut lengths = vec![];
        assert!(head.for_each(&memory, begin, |bytes| lengths.push(bytes.len())).is_some());
        assert_eq!(lengths, [16, 4, 0, 0, 84]);
        let beyond = Head { ranges: [[begin + 0x3FF, 2]; RANGES], ..head };
        assert!(beyond.for_each(&memory, begin, |_| ()).is_none());
        memory[HEAD_OFFSET] ^= 1;
        assert_eq!(Head::of(&memory), None);
    }

    #[test]
    fn places_are_apart_and_end_with_their_sectors() {
        assert_eq!(Place::A.begin() + Place::A.bytes(), Place::B.begin());
        assert_eq!(Place::B.begin() + Place::B.bytes(), 0x0810_0000);
    }
}
