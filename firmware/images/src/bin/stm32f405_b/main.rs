//! The production image for the STM32F405, for the place B of the flash: it comes by an update
//! only.
#![no_std]
#![no_main]

#[path = "../stm32f405/program.rs"]
mod program;
