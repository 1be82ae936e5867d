//! A cycle of a sector that holds nothing of a board's: sector 3, the starter's log. A board with
//! this image has no starter, and whatever flashes the production image writes a new log.

use super::oscillators::Stopwatch;
use crate::stm32f405::flash::{Flash, FlashError, WORD};
use crate::stm32f405::image_flash::{LOG_SECTOR, log};

/// Programmed at a time. Unit: word.
const BLOCK: usize = 16;

/// What a cycle has shown.
#[derive(Clone, Copy, Debug)]
pub struct Cycle {
    /// The longer of two erasures. Unit: ms.
    pub erase_ms: f32,
    /// The mean of a word. Unit: µs.
    pub program_us: f32,
    /// Words that are not what they were programmed to.
    pub wrong_words: u32,
}

/// Different in each word, in every bit of some, so that lines of the address that meet are seen.
fn pattern(index: usize) -> u32 {
    (index as u32).wrapping_mul(0x9E37_79B9)
}

/// Erases the sector, programs all of it, reads it, and leaves it erased. The processor stands
/// still meanwhile, at most 1.5 s.
///
/// # Errors
/// The flash refuses, or is not blank behind an erasure.
pub fn cycle(flash: &mut Flash, clock: &Stopwatch) -> Result<Cycle, FlashError> {
    let begin = log().as_ptr() as usize;
    let words = log().len();
    let erase = |flash: &mut Flash| {
        let started = clock.now();
        flash.erase_sectors(LOG_SECTOR..LOG_SECTOR + 1, begin..begin + words * WORD)?;
        Ok(clock.seconds_since(started))
    };
    let first_s: f32 = erase(flash)?;
    let started = clock.now();
    for block in (0..words).step_by(BLOCK) {
        let content: [[u8; WORD]; BLOCK] = core::array::from_fn(|place| pattern(block + place).to_le_bytes());
        flash.program(begin + block * WORD, content.as_flattened())?;
    }
    let program_s = clock.seconds_since(started);
    let is_wrong = |&index: &usize| read(begin + index * WORD) != pattern(index);
    let wrong_words = (0..words).filter(is_wrong).count() as u32;
    let erase_ms = 1e3 * first_s.max(erase(flash)?);
    Ok(Cycle { erase_ms, program_us: 1e6 * program_s / words as f32, wrong_words })
}

/// A word of the sector.
fn read(address: usize) -> u32 {
    // SAFETY: within the sector, by the callers, aligned, and nobody's variable; volatile, since it
    // changes behind the compiler's back.
    unsafe { (address as *const u32).read_volatile() }
}
