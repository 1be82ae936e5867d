//! `mgpi status`: a board on a screen.

use clap::Args;

use super::port::PortArguments;
use crate::Error;
use board_client::bus::BoardError;
use board_client::bus::status::Status;

/// Shows a board: state, faults with cause and cure, measurements, statistics of its ticks.
#[derive(Args, Debug)]
pub struct Arguments {
    /// For programs
    #[arg(long)]
    json: bool,
    /// Stop and vent first
    #[arg(long)]
    stop: bool,
    /// Release the latched fault first, which has been seen to
    #[arg(long)]
    acknowledge: bool,
    #[command(flatten)]
    port: PortArguments,
}

/// Shows.
///
/// # Errors
/// The board does not answer, or the fault cannot be released.
pub fn run(arguments: &Arguments) -> Result<(), Error> {
    let mut board = arguments.port.open()?;
    if arguments.stop {
        board.stop().map_err(BoardError::from)?;
    }
    if arguments.acknowledge {
        board.acknowledge()?;
    }
    let status = Status::read(&mut board).map_err(BoardError::from)?;
    if arguments.json {
        say!("{:#}", status.to_json());
    } else {
        say!("{}", status.in_words());
    }
    Ok(())
}
