//! The checksum of the firmware, looked at in each start.
//!
//! `cargo xtask firmware` puts it into the image: the CRC-32 (ISO-HDLC) over all that the image has
//! in the flash but itself: vector table, code, constants, the variables' first values. What lies
//! between them, which a loader may fill as it likes, is left out; the parameters have checksums
//! of their own.

use core::slice::from_raw_parts;

use crc::{CRC_32_ISO_HDLC, Crc, Table};

/// By sixteen bytes at a time: a third of a megabyte in some 25 ms, 0.3 s on the
/// internal oscillator.
const CRC: Crc<u32, Table<16>> = Crc::<u32, Table<16>>::new(&CRC_32_ISO_HDLC);
/// What nobody has put in.
const NOTHING: u32 = !0;

/// Ranges of the flash, at the most.
const RANGES: usize = 4;

/// Begin and bytes of each range, and the checksum over all of them.
// SAFETY: the section is one of memory.x, and used for nothing else.
#[used]
#[unsafe(link_section = ".image_check")]
static CHECK: [u32; 2 * RANGES + 1] = [NOTHING; 2 * RANGES + 1];

unsafe extern "C" {
    /// Where the flash begins, by cortex-m-rt's linker script.
    static __vector_table: u8;
    /// Where it ends, by memory.x.
    static _flash_end: u8;
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
pub fn check() -> Image {
    // SAFETY: the place is the static's; volatile, since it was written behind the compiler's back.
    let check = unsafe { (&raw const CHECK).read_volatile() };
    if check == [NOTHING; 2 * RANGES + 1] {
        return Image::Unchecked;
    }
    let (first, end) = ((&raw const __vector_table) as u32, (&raw const _flash_end) as u32);
    let (ranges, sum) = check.as_chunks();
    let mut digest = CRC.digest();
    for &[begin, length] in ranges {
        // One that is itself damaged would lead beyond the flash.
        if !(first..end).contains(&begin) || length > end - begin {
            return Image::Damaged;
        }
        // SAFETY: it is within the flash, and nothing changes that while the program runs.
        digest.update(unsafe { from_raw_parts(begin as *const u8, length as usize) });
    }
    if [digest.finalize()] == sum { Image::Whole } else { Image::Damaged }
}
