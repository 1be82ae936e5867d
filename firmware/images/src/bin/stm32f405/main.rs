//! The production image for the STM32F405, for the place A of the flash, with the starter before
//! it: what a debugger flashes.
#![no_std]
#![no_main]

mod program;

bsp::put_starter!();
