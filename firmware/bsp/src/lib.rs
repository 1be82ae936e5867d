//! The drivers of the valve board, by the registers of its STM32F405, and how a program of it ends.
//!
//! # Design
//! | module | what it does |
//! |---|---|
//! | `serial` | a serial port in two halves: an interrupt moves bytes, a task works on them |
//! | `link`, `bus_port` | the two protocols on such a port |
//! | `ports` | keeps both ports waiting until the start-up is over |
//! | `safe_end` | panics, hard faults and unexpected interrupts |
//! | `stm32f405` | converters, timers, clocks, watchdog, flash and pins: what the emulator has not |
//!
//! What a board does with them is the business of its image. For a host the crate is empty: there
//! are no registers.
#![no_std]
#![cfg(target_os = "none")]

pub mod bus_port;
pub mod link;
pub mod ports;
pub mod safe_end;
pub mod serial;
pub mod stm32f405;
