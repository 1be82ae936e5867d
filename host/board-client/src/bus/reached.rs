//! How a board is reached on its bus: what it keeps of that, read and written.

use std::fmt;

use wire::registers::{BusListens, Id, fields};
use wire::{BusParameters, Parity};

use super::board::Board;
use super::client::BusError;

/// What a board keeps, and by what it listens.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Reached {
    /// What it keeps.
    pub kept: BusParameters,
    /// By what it listens.
    pub listens: BusListens,
}

/// What is to change.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Change {
    /// The board's number.
    pub unit: Option<u8>,
    /// Unit: bit/s.
    pub baud: Option<u32>,
    /// Parity.
    pub parity: Option<Parity>,
    /// Least time to the answer. Unit: µs.
    pub turnaround_us: Option<u32>,
}

impl Change {
    /// The parameters after it.
    pub fn of(&self, before: BusParameters) -> BusParameters {
        BusParameters {
            unit: self.unit.unwrap_or(before.unit),
            baud: self.baud.unwrap_or(before.baud),
            parity: self.parity.unwrap_or(before.parity),
            turnaround_us: self.turnaround_us.unwrap_or(before.turnaround_us),
        }
    }
}

impl Reached {
    /// Asks the board; `None` of one whose firmware is older than these registers.
    ///
    /// # Errors
    /// No answer.
    pub fn read(board: &mut Board) -> Result<Option<Self>, BusError> {
        let block = match board.read(Id::BusNumber, Id::BusListens) {
            Err(error) if error.exception().is_some() => return Ok(None),
            block => block?,
        };
        let mut kept = BusParameters::STANDARD;
        for id in fields::BUS {
            if let (Some(field), Some(value)) = (fields::of_bus(&mut kept, id), block.value(id)) {
                field.set(value);
            }
        }
        let listens = BusListens::of_number(block.whole(Id::BusListens) as u16);
        Ok(Some(Self { kept, listens: listens.unwrap_or(BusListens::Stored) }))
    }
}

/// Lets a board keep parameters, by one write; it listens by what it did.
///
/// # Errors
/// A refusal, or no answer.
pub fn keep(board: &mut Board, parameters: &BusParameters) -> Result<(), BusError> {
    let mut parameters = *parameters;
    let words: Vec<u16> = fields::BUS
        .into_iter()
        .filter_map(|id| fields::of_bus(&mut parameters, id).map(|field| field.get()))
        .flat_map(|value| value.words().collect::<Vec<_>>())
        .collect();
    board.write(Id::BusNumber, &words)
}

/// Lets a board take what it keeps, behind its answer.
///
/// # Errors
/// A refusal, or no answer.
pub fn take(board: &mut Board) -> Result<(), BusError> {
    // One that has taken them already does not hear a second order.
    match board.write_once(Id::BusTake, &[1], 1) {
        Err(error) if error.is_lost() => Ok(()),
        done => done,
    }
}

/// The parameters in words.
pub struct InWords<'a>(pub &'a BusParameters);

impl fmt::Display for InWords<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let BusParameters { unit, baud, parity, turnaround_us } = self.0;
        let parity = match parity {
            Parity::None => "none",
            Parity::Even => "even",
            Parity::Odd => "odd",
        };
        write!(f, "number {unit}, {baud} bit/s, parity {parity}, turn-around {turnaround_us} us")
    }
}

/// By what it listens, in words.
pub const fn in_words(listens: BusListens) -> &'static str {
    match listens {
        BusListens::Stored => "what it keeps",
        BusListens::Former => "what it kept before; the new at its next start, or by --take",
        BusListens::Standard => "the rate and parity of a new board: nobody was heard by its own",
    }
}
