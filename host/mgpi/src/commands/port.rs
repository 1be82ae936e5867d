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
use board_client::joint;

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
    /// Bits a second [default: 115200; at the service link, where a joint's board is, 460800]
    #[arg(long, value_name = "BIT/S", value_parser = clap::value_parser!(u32).range(1200..=4_000_000))]
    baud: Option<u32>,
    /// Parity
    #[arg(long, default_value = "none")]
    parity: Parity,
    /// Longest time for an answer in s; a lost one is asked for again [default: 0.15; at the
    /// service link 0.12]
    #[arg(long, value_name = "S", value_parser = positive)]
    timeout_s: Option<f64>,
}

/// How long an answer on the bus may take, unless the user has it otherwise.
const ANSWER: Duration = Duration::from_millis(150);

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
        self.open_as(self.unit, Line { baud: self.baud.unwrap_or(BAUD), parity: self.parity })
    }

    /// The service link of a board with two channels.
    pub fn link(&self) -> joint::link::Address {
        joint::link::Address {
            port: self.port.clone(),
            baud: self.baud.unwrap_or(joint::link::BAUD),
            limit: self.limit().unwrap_or(joint::link::ANSWER),
        }
    }

    fn limit(&self) -> Option<Duration> {
        self.timeout_s.map(Duration::from_secs_f64)
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
        let limit = self.limit().unwrap_or(ANSWER);
        Board::open(Address { port: self.port.clone(), line, unit, limit })
    }
}
