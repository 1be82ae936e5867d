//! The host's side of a board: its bus, its settings, its firmware in an emulator, and a loop of
//! both with a plant.
//!
//! # Design
//! | module | what it does |
//! |---|---|
//! | [`bus`] | a board at a serial port: settings, models, runs, logs |
//! | [`backup`] | all that a board keeps, as one readable file |
//! | [`bring_up`] | a new board, tested part by part |
//! | `emulator` | the firmware in QEMU |
//! | [`pil`] | that firmware in a loop with a plant, tick by tick |
//! | [`joint`] | the same with two muscles at a joint |
//! | `child` | programs that are started, and end with us |
//! | [`stop`] | the request to stop |
//! | [`update`] | a new image to a board |
//! | [`part`] | logs that grow, and are kept if the run breaks off |
//!
//! # Systems
//! A board at a serial port is used on Linux, macOS and Windows. Emulator and plants are programs
//! that end with us, in groups as only Unix has them.

pub mod backup;
pub mod bring_up;
pub mod bus;
#[cfg(unix)]
pub mod child;
#[cfg(unix)]
pub mod emulator;
pub mod growing;
pub mod joint;
pub mod part;
pub mod pil;
pub mod stop;
pub mod update;
