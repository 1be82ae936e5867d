//! The image that runs: its head, and its checksum, looked at in each start.
//!
//! `cargo xtask firmware` puts both into it: the CRC-32 (ISO-HDLC) over all that the image has in
//! the flash, vector table, code, constants, the variables' first values, and over the head. What
//! lies between them, which a loader may fill as it likes, is left out; the parameters have
//! checksums of their own.

use firmware::FIRMWARE_VERSION;
use firmware::identity::SOURCE;
use firmware::store::{JOINT_LAYOUT, LAYOUT};
use firmware::update::{Images, is_whole};
use wire::image::{BoardKind, HEAD_WORDS, Head, LINKED_WORDS, Linked};

use super::flash::Flash;
use super::image_flash::running;

/// What a board with one channel is, by how its valve is driven.
pub const ONE_CHANNEL: BoardKind =
    if cfg!(feature = "solenoid") { BoardKind::Coil } else { BoardKind::Regulator };

/// What this firmware is for. There is but one board of each kind yet, whatever revision its maker
/// has written.
const fn linked(kind: BoardKind) -> Linked {
    Linked {
        kind: kind.number(),
        revisions: [0, u16::MAX],
        release: FIRMWARE_VERSION,
        wire: wire::VERSION,
        layout: if matches!(kind, BoardKind::Joint) { JOINT_LAYOUT } else { LAYOUT },
        is_modified: SOURCE.is_modified,
        commit: SOURCE.commit,
    }
}

/// The words of a head that nobody has sealed yet, of an image for a kind of board.
pub const fn head(kind: BoardKind) -> [u32; HEAD_WORDS] {
    let (linked, mut words, mut index) = (linked(kind).words(), [!0; HEAD_WORDS], 0);
    while index < LINKED_WORDS {
        words[index] = linked[index];
        index += 1;
    }
    words
}

/// Puts the head into an image for a kind of board.
#[macro_export]
macro_rules! put_head {
    ($kind:expr) => {
        // SAFETY: the section is one of memory.x, and used for nothing else.
        #[used]
        #[unsafe(link_section = ".image_head")]
        static IMAGE_HEAD: [u32; wire::image::HEAD_WORDS] = $crate::stm32f405::image::head($kind);
    };
}

/// Puts what is flashed with an image for the place A into it.
#[macro_export]
macro_rules! put_starter {
    () => {
        /// Room for the starter, which `cargo xtask firmware` puts in.
        // SAFETY: the section is one of place.x, and used for nothing else.
        #[used]
        #[unsafe(link_section = ".starter")]
        static STARTER: [u8; 16 * 1024] = [0xFF; 16 * 1024];

        /// The first word of the starter's log: a board that is flashed runs what was flashed,
        /// whatever stood there.
        // SAFETY: as above.
        #[used]
        #[unsafe(link_section = ".start_log")]
        static START_LOG: u32 = firmware::update::log::Entry::ForGood(wire::image::Place::A).word();
    };
}

/// How the image is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Image {
    /// As it was built.
    Whole,
    /// A bit of it is another.
    Damaged,
    /// Nobody has put a checksum in.
    Unchecked,
}

/// Looks at it.
#[inline(never)]
pub fn check(flash: &Flash) -> Image {
    match Head::of(flash.read(running())) {
        None => Image::Damaged,
        Some(head) if !head.is_sealed() => Image::Unchecked,
        Some(head) if is_whole(flash, &head, running()) => Image::Whole,
        Some(_) => Image::Damaged,
    }
}
