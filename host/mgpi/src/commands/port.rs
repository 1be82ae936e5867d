//! What the commands that speak with a board have in common: where it is.

use std::path::PathBuf;
use std::time::Duration;

use clap::Args;
use wire::BusParameters;
use wire::registers::{BAUD, UNIT};

use super::number::positive;
use board_client::bus::client::Address;
use board_client::bus::port::{Line, Parity};
use board_client::bus::{Board, BoardError};

/// Where the board is.
#[derive(Args, Clone, Debug)]
#[command(next_help_heading = "Bus")]
pub struct PortArguments {
    /// Serial port, by its path or its name under /dev
    #[arg(long, value_name = "PORT")]
    port: PathBuf,
    /// The board's number on the bus
    #[arg(long, default_value_t = UNIT, value_name = "N", value_parser = clap::value_parser!(u8).range(1..=247))]
    unit: u8,
    /// Bits a second
    #[arg(long, default_value_t = BAUD, value_name = "BIT/S", value_parser = clap::value_parser!(u32).range(1200..=4_000_000))]
    baud: u32,
    /// Parity
    #[arg(long, default_value = "none")]
    parity: Parity,
    /// Longest time for an answer in s; a lost one is asked for again
    #[arg(long, default_value_t = 0.15, value_name = "S", value_parser = positive)]
    timeout_s: f64,
}

impl PortArguments {
    /// The board's number on the bus.
    pub fn number(&self) -> u8 {
        self.unit
    }

    /// Opens the port and asks who is there.
    ///
    /// # Errors
    /// The port cannot be used, nobody answers, or not a board of this version.
    pub fn open(&self) -> Result<Board, BoardError> {
        self.open_as(self.unit, Line { baud: self.baud, parity: self.parity })
    }

    /// The same, by the parameters that the board has taken.
    ///
    /// # Errors
    /// As for [`PortArguments::open`].
    pub fn open_by(&self, parameters: &BusParameters) -> Result<Board, BoardError> {
        let BusParameters { unit, baud, parity, .. } = *parameters;
        self.open_as(unit, Line { baud, parity: parity.into() })
    }

    fn open_as(&self, unit: u8, line: Line) -> Result<Board, BoardError> {
        let limit = Duration::from_secs_f64(self.timeout_s);
        Board::open(Address { port: self.port.clone(), line, unit, limit })
    }
}
