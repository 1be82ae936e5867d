//! What the bring-up image needs beyond the drivers of service.
//!
//! | file | what it does |
//! |---|---|
//! | [`oscillators`] | measures the oscillators against each other |
//! | [`resistors`] | looks for the resistors that keep outputs low in a reset |
//! | [`flash_cycle`] | erases, programs and reads a sector that holds nothing |

pub mod flash_cycle;
pub mod oscillators;
pub mod resistors;

/// Where the processor tells how much flash it has, in KB (RM0090, 39.2).
const FLASH_SIZE: *const u16 = 0x1FFF_7A22 as *const u16;

/// Flash of the processor. Unit: KB.
pub fn flash_size_kb() -> u16 {
    // SAFETY: the address is in the system's memory of every chip of the line, aligned, and never
    // written.
    unsafe { FLASH_SIZE.read_volatile() }
}
