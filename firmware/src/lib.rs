//! The control code of the valve board, without the hardware.
//!
//! The same code runs in the production image (`stm32f405`), in the emulated image (`emulated`) and on the
//! host, generic over its [`board::Board`].
//!
//! # A tick
//! ```text
//! ADC codes ─▶ plausibility ─▶ scaling ─▶ inverse model + PID, slew, limits ─▶ scaling ─▶ DAC code
//! ```
//! [`control::Control`] owns the tick. [`order::prepare`] turns a request into an order for it and does the
//! long work (validation, the inverse of a model) outside the tick's lock; applying an order is a check of
//! the state and a move.
//!
//! # Safety
//! The valve is driven in the state `Tracking` only. Every other state, and every fault, writes
//! [`scaling::VENT`] each tick. A fault is latched until the next configuration.
#![no_std]
#![forbid(unsafe_code)]

pub mod board;
pub mod control;
pub mod law;
pub mod lock_step;
pub mod order;
pub mod scaling;
pub mod store;

pub use board::{AcquisitionError, AdcCode, Board, DacCode, Samples};
pub use control::Control;
pub use lock_step::LockStepBoard;
pub use order::{Order, prepare};
