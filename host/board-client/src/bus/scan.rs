//! Which boards are on a line, and all of them vented.
//!
//! Each number is asked for a register. Who answers is then asked for the rest. Two boards of one
//! number answer at once: their bytes damage each other, or come one answer behind the other. A
//! line that is disturbed looks the same, so that the answer says both.

use std::ops::RangeInclusive;
use std::thread;
use std::time::Duration;

use serde_json::{Value, json};
use wire::registers::{Command, Id, VERSION};
use wire::{Fault, State};

use super::about::About;
use super::board::Board;
use super::client::{Address, BusError, Client};
use super::error::BoardError;
use super::port::PortError;

/// How often a number is asked: one question may be lost.
const TRIES: usize = 2;
/// How often all boards are told to vent, which none of them answers.
const STOPS: usize = 3;
/// Until a board has carried out what all were told (Modbus over serial line 1.02, 2.4.1: 100 to
/// 200 ms).
const TURNAROUND: Duration = Duration::from_millis(100);

/// Who answers by a number.
#[derive(Clone, Debug, PartialEq)]
pub struct Found {
    /// The number.
    pub unit: u8,
    /// The rate by which it answers. Unit: bit/s.
    pub baud: u32,
    /// Who it is.
    pub who: Who,
}

/// Who answers.
#[derive(Clone, Debug, PartialEq)]
pub enum Who {
    /// A board.
    Board {
        /// Version of its firmware.
        release: [u16; 3],
        /// What it says of itself for good; none of one whose firmware is older.
        about: Option<About>,
        /// Its state.
        state: State,
        /// The fault that is latched.
        fault: Option<Fault>,
    },
    /// A board whose registers are of another version.
    OtherMap(u16),
    /// Something that has no such register.
    Other,
    /// More than one, or one on a line that is disturbed.
    Several,
}

/// Vents every board that hears it.
///
/// # Errors
/// The port cannot be used.
pub fn stop_all(address: &Address) -> Result<(), PortError> {
    let mut client = Client::open(address.clone())?;
    for _ in 0..STOPS {
        client.write_all(Id::Command.register().address, &[Command::Stop.number()])?;
    }
    thread::sleep(TURNAROUND);
    Ok(())
}

/// Asks for the boards with these numbers; the address says the rest. `tell` hears of each number
/// that has been asked.
///
/// # Errors
/// The port cannot be used.
pub fn scan(
    address: &Address,
    units: RangeInclusive<u8>,
    mut tell: impl FnMut(),
) -> Result<Vec<Found>, PortError> {
    let mut client = Client::open(address.clone())?;
    let mut present = Vec::new();
    for unit in units {
        client.turn_to(unit);
        if let Some(who) = who(&mut client)? {
            present.push((unit, who));
        }
        tell();
    }
    drop(client);
    let baud = address.line.baud;
    let found = present.into_iter().map(|(unit, who)| {
        let who = match who {
            Present::Board => in_full(&Address { unit, ..address.clone() })?,
            Present::Known(who) => who,
        };
        Ok(Found { unit, baud, who })
    });
    found.collect()
}

/// What one question shows.
enum Present {
    /// A board of this version.
    Board,
    Known(Who),
}

fn who(client: &mut Client) -> Result<Option<Present>, PortError> {
    let version = match client.read_in(Id::RegistersVersion.register().address, 1, TRIES) {
        Ok(words) => words.first().copied().unwrap_or_default(),
        Err(BusError::Port(error)) => return Err(error),
        Err(BusError::Silent { .. }) => return Ok(None),
        Err(BusError::Damaged { .. }) => {
            client.forget()?;
            return Ok(Some(Present::Known(Who::Several)));
        }
        Err(BusError::Refused { .. }) => return Ok(Some(Present::Known(Who::Other))),
    };
    Ok(Some(match version {
        _ if client.forget()? > 0 => Present::Known(Who::Several),
        VERSION => Present::Board,
        other => Present::Known(Who::OtherMap(other)),
    }))
}

/// All of a board that answers.
fn in_full(address: &Address) -> Result<Who, PortError> {
    let asked = || -> Result<Who, BoardError> {
        let mut board = Board::open(address.clone())?;
        let about = About::read(&mut board)?;
        let (state, fault) = board.state()?;
        Ok(Who::Board { release: board.identity().release, about, state, fault })
    };
    match asked() {
        Ok(who) => Ok(who),
        Err(BoardError::Bus(BusError::Port(error))) => Err(error),
        Err(BoardError::NotTheBoard(_)) => Ok(Who::Other),
        // It has answered before.
        Err(_) => Ok(Who::Several),
    }
}

impl Found {
    /// For people: a line.
    pub fn in_words(&self) -> String {
        let Self { unit, baud, who } = self;
        let who = match who {
            Who::Board { release: [major, minor, patch], about, state, fault } => {
                let state = match fault {
                    Some(fault) => format!("Fault {} ({fault:?})", fault.code()),
                    None => format!("{state:?}"),
                };
                let number = about.as_ref().map_or("", |about| &about.unique_id);
                let number = if number.is_empty() { "not known" } else { number };
                format!("firmware {major}.{minor}.{patch}, {state}, processor number {number}")
            }
            Who::OtherMap(version) => {
                format!("registers of version {version}, this program speaks version {VERSION}")
            }
            Who::Other => "no valve board, but something else".to_owned(),
            Who::Several => {
                "damaged answers: two boards have this number, or the line is disturbed; connect one alone, and \
                 mgpi bus --set-number"
                    .to_owned()
            }
        };
        format!("{unit:<7}{baud:>9} bit/s  {who}")
    }

    /// For programs.
    pub fn to_json(&self) -> Value {
        let Self { unit, baud, who } = self;
        let mut found = json!({ "number": unit, "baud": baud });
        let of_kind = match who {
            Who::Board { release, about, state, fault } => {
                let [major, minor, patch] = release;
                json!({
                    "kind": "board", "firmware": format!("{major}.{minor}.{patch}"), "state": format!("{state:?}"),
                    "fault": fault.map(Fault::code), "about": about.as_ref().map(About::to_json),
                })
            }
            Who::OtherMap(version) => json!({ "kind": "other_version", "registers": version }),
            Who::Other => json!({ "kind": "other" }),
            Who::Several => json!({ "kind": "several" }),
        };
        if let (Value::Object(found), Value::Object(of_kind)) = (&mut found, of_kind) {
            found.extend(of_kind);
        }
        found
    }
}
