//! The control code of the valve board, without the hardware.
//!
//! The same code runs in the production image (`stm32f405`), in the emulated image (`emulated`) and
//! on the host, generic over its [`board::Board`].
//!
//! # A tick
//! ```text
//! ADC codes ─▶ monitors ─▶ inverse model + PID, slew, limits ─▶ judgement ─▶ soft start, slew ─▶ DAC code
//! ```
//! [`control::Control`] owns the tick. [`order::prepare`] turns a request into an order for it and
//! does the long work (validation, the inverse of a model, its survey) outside the tick's lock;
//! applying an order is a check of the state and a move. Two muscles at a joint have a tick of
//! their own, [`joint`].
//!
//! # Safety
//! The valve is driven in the states `Tracking`, `Holding` and `Service` only ([`state_machine`]).
//! Every other state writes [`scaling::VENT`] each tick. A fault that vents does so in the tick
//! that sees it, and is latched until it is acknowledged ([`faults`]).
#![no_std]
#![forbid(unsafe_code)]
#![deny(clippy::unwrap_used, clippy::expect_used, clippy::indexing_slicing, clippy::panic)]

pub mod adaptation;
pub mod board;
pub mod bring_up;
pub mod bus;
pub mod capture;
pub mod ceilings;
pub mod control;
pub mod faults;
pub mod identity;
pub mod joint;
pub mod law;
pub mod led;
pub mod lock_step;
pub mod monitors;
pub mod node;
pub mod noise;
pub mod order;
pub mod output;
mod report;
pub mod scaling;
pub mod state_machine;
pub mod store;
pub mod timing;
pub mod update;
pub mod watchdog;

pub use board::{AcquisitionError, AdcCode, Board, DacCode, Samples};
pub use capture::Capture;
pub use control::{Control, TickClock};
pub use faults::black_box::BlackBox;
pub use lock_step::LockStepBoard;
pub use order::{Order, prepare};
pub use report::FIRMWARE_VERSION;
