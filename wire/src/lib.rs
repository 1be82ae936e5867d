//! What a host and the valve board say to each other, and how it is framed.
//!
//! # Frames
//! A message is serialised with postcard, followed by a CRC-16 (little-endian), stuffed by COBS and
//! ended by a zero byte. A receiver that joins in the middle, or sees a damaged frame, is in step
//! again at the next zero.
//!
//! # Versions
//! [`VERSION`] is that of the messages below. It is part of [`Response::Hello`] and of every
//! [`Configuration`]; a board refuses a configuration of another version.
//!
//! # Registers
//! [`registers`] is the other language that the board speaks, Modbus, for everybody else; [`slots`]
//! the frame by which a host tells many boards of a line at once.
//!
//! # Limits
//! A frame takes at most [`FRAME_BYTES`] bytes, stuffing and the zero included: the largest
//! message, a configuration of [`PLAYS`] plays and [`DEAD_ZONES`] dead zones with every extension,
//! fits (a test says so).
#![no_std]
#![forbid(unsafe_code)]
#![cfg_attr(
    not(test),
    deny(clippy::unwrap_used, clippy::expect_used, clippy::indexing_slicing, clippy::panic)
)]

pub mod bring_up;
mod bus_parameters;
mod calibration;
pub mod fault;
mod fingerprint;
mod frame;
pub mod image;
mod input;
pub mod joint;
mod message;
mod protection;
pub mod registers;
pub mod slots;
mod status;

pub use bus_parameters::{BusParameters, Parity};
pub use calibration::{Calibration, Line};
pub use fault::{FAULTS, Fault};
pub use fingerprint::fingerprint;
pub use frame::{FRAME_BYTES, FrameError, Receiver, encode};
pub use input::{Input, Inputs, Signal};
pub use message::{
    BoardParameters, BoardTracking, Configuration, DEAD_ZONES, Flags, Hello, PLAYS, Refusal, Request,
    Response, Scaling, State, TickReply, TickRequest, VERSION, text,
};
pub use protection::{NEVER, OnModelFault, Protection};
pub use status::{
    CAPTURE_CHUNK, CaptureOrder, CaptureSample, Captured, FaultRecord, Signals, TRACE, Telemetry, TraceEntry,
};
