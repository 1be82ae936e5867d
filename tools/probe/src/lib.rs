//! The unmodified production image in the emulator, tick by tick.
//!
//! # Design
//! | file | what it does |
//! |---|---|
//! | [`stub`] | speaks with the emulator's debug stub: breakpoint, registers, memory |
//! | [`valve_log`] | what the image has written to its DAC, from the emulator's log of accesses to what it does not model |
//! | [`production`] | the image, with samples put in and valve codes taken out |
//!
//! The emulator (QEMU's `netduinoplus2`) has no converter. So each tick is stopped at the one
//! function that reads it, which is never inlined and has a name of its own; the samples are put
//! into its result registers, and it returns at once. Nothing in the image knows of that.
//!
//! # Limits
//! Time is counted in instructions (`-icount`), so that a busy host changes nothing; it tells
//! nothing of cycles. Clock, converters, watchdog and voltage detector are not modelled: the image
//! falls back to its internal oscillator, a watchdog does not bite, and what these drivers do on a
//! processor is not shown here.

pub mod production;
pub mod stub;
pub mod valve_log;

pub use production::Production;
