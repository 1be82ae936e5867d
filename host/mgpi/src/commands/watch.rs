//! `mgpi watch`: a board on a page of this machine's browser.

use std::net::SocketAddr;
use std::thread;
use std::time::Duration;

use clap::Args;
use wire::State;
use wire::registers::Id;

use super::port::PortArguments;
use super::show::{ROW, Show};
use crate::Error;
use crate::live::{Order, Row};
use board_client::bus::{Board, BoardError};
use board_client::stop::Stop;

/// How long a board that does not answer is left alone.
const RETRY: Duration = Duration::from_millis(500);

/// Serves a page that shows a board as it runs: loop, traces, faults, a stop. Loopback only unless
/// --http says otherwise.
#[derive(Args, Debug)]
pub struct Arguments {
    /// Where the page is served
    #[arg(long, default_value = "127.0.0.1:8080", value_name = "ADDRESS")]
    http: SocketAddr,
    #[command(flatten)]
    port: PortArguments,
}

/// Watches, until the user ends it.
///
/// # Errors
/// The port cannot be used, or the page cannot be served.
pub fn run(arguments: &Arguments) -> Result<(), Error> {
    let mut board = arguments.port.open()?;
    let mut show = Show::start(arguments.http)?;
    let stop = Stop::on_signals();
    while !stop.is_requested() {
        // A board that does not answer, or refuses, may do better later.
        if let Err(error) = look(&mut board, &mut show) {
            show.problem(&error.to_string());
            thread::sleep(RETRY);
        }
        thread::sleep(ROW);
    }
    Ok(())
}

/// Looks at the board and carries orders out.
fn look(board: &mut Board, show: &mut Show) -> Result<(), BoardError> {
    let row = row(board)?;
    for order in show.rows(board, std::iter::once(row))? {
        match order {
            Order::Stop => board.stop()?,
            Order::Acknowledge => board.acknowledge()?,
        }
        show.look_soon();
    }
    Ok(())
}

fn row(board: &mut Board) -> Result<Row, BoardError> {
    let now = board.read(Id::State, Id::CommandBar)?;
    let is_tracking = now.state() == State::Tracking;
    Ok(Row {
        time_s: f64::from(now.whole(Id::Ticks)) * board.identity().period_s,
        reference_mm: is_tracking.then(|| now.number(Id::ReferenceMm)),
        contraction_mm: now.number(Id::ContractionMm),
        pressure_bar: now.number(Id::PressureBar),
        command_bar: now.number(Id::CommandBar),
    })
}
