//! The whole configuration of a board: model with extensions, gains, limits, protection, how it is
//! reached on its bus, what its sensors have shown; read, kept in a file, restored.
//!
//! | file | what it does |
//! |---|---|
//! | `framed` | what every such file begins with, its checksum, and whether it is of the boards that are meant |
//! | `file` | the file of a board with one muscle, in both directions |
//! | [`joint`] | that of a joint's board |
//! | `section` | the registers of a group as a table of the file, in both directions |
//! | `transfer` | from a board, and to it |
//!
//! # Contract
//! A file that is damaged, of another version, or with a key that is unknown or missing is refused
//! before a board is asked for anything. A backup reads back as the same numbers. A board that has
//! been restored was compared with the file; one that refuses has what it had before.

mod file;
mod framed;
pub mod joint;
mod section;
mod transfer;

use wire::{BusParameters, Calibration, Configuration, Protection};

use crate::bus::board::Identity;

pub use file::BackupFile;
pub use framed::BackupFileError;
pub(crate) use section::{shortest, value_within};
pub use transfer::{read, restore};

/// The format of a backup of a board with one muscle that this version writes.
pub const FORMAT: usize = 2;
/// The same of a joint's board.
pub const JOINT_FORMAT: usize = 1;

/// What a board has been told.
#[derive(Clone, Debug, PartialEq)]
pub struct Backup {
    /// Model, gains and limits of the controller; none on a board without a model.
    pub configuration: Option<Configuration>,
    /// Limits of the plant.
    pub protection: Protection,
    /// Number, rate, parity and turn-around; none of a board whose firmware keeps none, or in a
    /// file that is older than they.
    pub bus: Option<BusParameters>,
    /// Lines of the sensors and the regulator; none as above.
    pub calibration: Option<Calibration>,
}

/// The board that a backup is of; nothing of it is restored.
#[derive(Clone, Debug, PartialEq)]
pub struct Origin {
    /// Its number on the bus.
    pub number: u8,
    /// Versions, tick and scaling.
    pub identity: Identity,
}
