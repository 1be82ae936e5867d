//! The production image for the STM32F405, for the place A of the flash, with the starter before
//! it: what a debugger flashes.
#![no_std]
#![no_main]

mod program;

/// Room for the starter, which `cargo xtask firmware` puts in.
// SAFETY: the section is one of place.x, and used for nothing else.
#[used]
#[unsafe(link_section = ".starter")]
static STARTER: [u8; 16 * 1024] = [0xFF; 16 * 1024];

/// The first word of the starter's log: a board that is flashed runs what was flashed, whatever
/// stood there.
// SAFETY: as above.
#[used]
#[unsafe(link_section = ".start_log")]
static START_LOG: u32 = firmware::update::log::Entry::ForGood(wire::image::Place::A).word();
