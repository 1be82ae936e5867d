//! Why a board on the bus does not do what it is asked for.

use std::path::PathBuf;

use thiserror::Error;
use wire::fault::table::{Row, TABLE};
use wire::registers::{UploadResult, VERSION};
use wire::{Fault, State};

use super::client::BusError;
use super::port::PortError;
use crate::part::PartError;

/// Why a board does not do what it is asked for.
#[derive(Debug, Error)]
#[allow(missing_docs, reason = "the messages say what the variants and their fields are")]
pub enum BoardError {
    #[error(transparent)]
    Bus(#[from] BusError),
    #[error("{}: no valve board answers, but something else on the bus", .0.display())]
    NotTheBoard(PathBuf),
    #[error(
        "the board's register map is version {board}, this program speaks version {VERSION}: {}",
        other(*.board, VERSION)
    )]
    MapVersion { board: u16 },
    #[error(
        "the board takes configurations of version {board}, this program writes version {}: {}",
        wire::VERSION, other(*.board, wire::VERSION)
    )]
    WireVersion { board: u16 },
    #[error("the board is in the state {state:?}, {needed}")]
    State { state: State, needed: &'static str },
    #[error("{}", in_words(*.0))]
    Fault(Option<Fault>),
    #[error("the board has vented by itself, in the state {0:?}: see mgpi status")]
    Vented(State),
    #[error("at {time_s} s {value} {unit} is asked for; the board takes {min} to {max} {unit}")]
    Point { time_s: f64, value: f32, unit: &'static str, min: f64, max: f64 },
    #[error("the board has run out of set points, this program or its bus was too slow; the valve is vented")]
    Underrun,
    #[error("{name} is to be {value}; the board takes {min} to {max}")]
    Setting { name: &'static str, value: f32, min: f64, max: f64 },
    #[error("the lowest command, {lowest_bar} bar, must be below the highest, {highest_bar} bar")]
    Limits { lowest_bar: f32, highest_bar: f32 },
    #[error("the configuration of {bytes} bytes does not fit into the board's {capacity}")]
    TooLarge { bytes: usize, capacity: usize },
    #[error(
        "what the board has of the configuration differs from what was sent; the old one is still installed"
    )]
    ReadBack,
    #[error("the board refuses the configuration ({result:?}): {message}; the old one is still installed")]
    Refused { result: UploadResult, message: String },
    #[error(
        "the configuration is in use, but the board's flash has not kept it: it is lost when power is. The old one may \
         be what the board starts with; after a second failure replace the board"
    )]
    NotStored,
    #[error("the board has another configuration installed than the one that was sent: deploy it again")]
    NotInstalled,
    #[error(
        "the backup is of a board without a model; one that has a model keeps it: nothing has been changed"
    )]
    NoModelToRestore,
    #[error(
        "{0}; calibration and limits of the plant (protection) may already be those of the backup: restore it again"
    )]
    HalfRestored(Box<Self>),
    #[error("the board holds no configuration that this program can read: deploy a model first")]
    NoConfiguration,
    #[error("{error}: {message}; it has the calibration that it had")]
    Calibration { error: BusError, message: String },
    #[error("the board has another calibration than the one that was written: calibrate again")]
    CalibrationReadBack,
    #[error(
        "the reading does not settle: it moves by {spread_codes:.1} codes, must be at most {limit_codes}: is there a leak, or \
         does somebody touch the muscle?"
    )]
    Unsettled { spread_codes: f64, limit_codes: f64 },
    #[error(transparent)]
    Growing(#[from] PartError),
    #[error("interrupted; the valve is vented")]
    Stopped,
}

impl From<PortError> for BoardError {
    fn from(error: PortError) -> Self {
        Self::Bus(error.into())
    }
}

pub(crate) fn other(board: u16, own: u16) -> &'static str {
    if board > own { "use a newer mgpi" } else { "flash the firmware of this release" }
}

/// What is known of a fault.
pub fn row(fault: Fault) -> Option<&'static Row> {
    TABLE.iter().find(|row| row.fault == fault)
}

/// A fault with its number, cause and cure.
pub fn in_full(row: &Row) -> String {
    let Row { fault, title, cause, cure, .. } = row;
    format!("{title} ({}, {fault:?})\n  cause: {cause}\n  cure: {cure}", fault.code())
}

fn in_words(fault: Option<Fault>) -> String {
    fault.and_then(row).map_or_else(
        || "the board is at fault: see mgpi status".to_owned(),
        |row| {
            format!("the board is at fault, and vented: {}\n  then: mgpi status --acknowledge", in_full(row))
        },
    )
}
