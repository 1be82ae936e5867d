//! `mgpi status`: a board on a screen.

use clap::Args;
use serde_json::Value;
use wire::joint::JointRequest;

use super::port::PortArguments;
use crate::Error;
use board_client::bus::BoardError;
use board_client::bus::status::Status;
use board_client::joint;
use board_client::joint::error::JointBoardError;
use board_client::joint::link::JointLink;

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
    /// Show a board of a joint, by its service link; --stop vents both muscles
    #[arg(long, help_heading = "Joint", conflicts_with_all = ["unit", "parity"])]
    joint: bool,
    #[command(flatten)]
    port: PortArguments,
}

/// Shows.
///
/// # Errors
/// The board does not answer, or the fault cannot be released.
pub fn run(arguments: &Arguments) -> Result<(), Error> {
    let (words, json) = if arguments.joint { of_joint(arguments)? } else { of_muscle(arguments)? };
    if arguments.json {
        say!("{json:#}");
    } else {
        say!("{words}");
    }
    Ok(())
}

/// What a board with one muscle says, for people and for programs.
fn of_muscle(arguments: &Arguments) -> Result<(String, Value), BoardError> {
    let mut board = arguments.port.open()?;
    if arguments.stop {
        board.stop().map_err(BoardError::from)?;
    }
    if arguments.acknowledge {
        board.acknowledge()?;
    }
    let status = Status::read(&mut board).map_err(BoardError::from)?;
    Ok((status.in_words(), status.to_json()))
}

/// The same of the board of a joint.
fn of_joint(arguments: &Arguments) -> Result<(String, Value), JointBoardError> {
    let mut link = JointLink::look(arguments.port.link())?;
    if arguments.stop {
        link.order(&JointRequest::Stop, &[])?;
    }
    if arguments.acknowledge {
        link.acknowledge()?;
    }
    let status = joint::status::Status::read(&mut link)?;
    Ok((status.in_words(), status.to_json()))
}
