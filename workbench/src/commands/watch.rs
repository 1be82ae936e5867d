//! `mgpi watch`: a board on a page of this machine's browser.

use std::net::SocketAddr;
use std::thread;
use std::time::{Duration, Instant};

use clap::Args;
use serde_json::json;
use wire::State;
use wire::registers::{Command, Id};

use super::port::PortArguments;
use crate::Error;
use crate::bus::status::Status;
use crate::bus::{Board, BoardError};
use crate::child::Stop;
use crate::live::{Feed, Order, Row, serve};

/// Time between two looks at the loop.
const LOOK: Duration = Duration::from_millis(40);
/// Time between two looks at all the rest.
const STATUS: Duration = Duration::from_millis(500);

/// Serves a page that shows a board as it runs: loop, traces, faults, a stop. Loopback only unless --http says otherwise.
#[derive(Args, Debug)]
pub struct Arguments {
    #[command(flatten)]
    port: PortArguments,
    /// Where the page is served
    #[arg(long, default_value = "127.0.0.1:8080", value_name = "ADDRESS")]
    http: SocketAddr,
}

/// Watches, until the user ends it.
///
/// # Errors
/// The port cannot be used, or the page cannot be served.
pub fn run(arguments: &Arguments) -> Result<(), Error> {
    let mut board = arguments.port.open()?;
    let feed = Feed::default();
    announce(serve(arguments.http, &feed)?);
    let stop = Stop::on_signals();
    while !stop.is_requested() {
        // A board that does not answer may come back.
        if let Err(error) = look(&mut board, &feed, &stop) {
            feed.status(json!({"problem": error.to_string()}));
            thread::sleep(STATUS);
        }
    }
    Ok(())
}

/// Says where the page is, and who may see it.
pub(super) fn announce(address: SocketAddr) {
    say!("http://{address}/ shows the board; Ctrl-C ends");
    if !address.ip().is_loopback() {
        eprintln!("warning: whoever reaches {address} sees the board, and may stop it");
    }
}

/// Looks at the board and carries orders out, until the user ends it.
fn look(board: &mut Board, feed: &Feed, stop: &Stop) -> Result<(), BoardError> {
    let mut due = Instant::now();
    while !stop.is_requested() {
        for order in feed.orders() {
            match order {
                Order::Stop => board.stop()?,
                Order::Acknowledge => {
                    board.order(Command::Acknowledge, &[State::SelfTest, State::Off, State::Ready])?;
                }
            }
            due = Instant::now();
        }
        if Instant::now() >= due {
            feed.status(Status::read(board)?.to_json());
            due = Instant::now() + STATUS;
        }
        feed.rows([row(board)?]);
        thread::sleep(LOOK);
    }
    Ok(())
}

fn row(board: &mut Board) -> Result<Row, BoardError> {
    let now = board.read(Id::State, Id::CommandBar)?;
    let is_tracking = crate::bus::board::state(now.whole(Id::State)) == State::Tracking;
    Ok(Row {
        time_s: f64::from(now.whole(Id::Ticks)) * board.identity().period_s,
        reference_mm: is_tracking.then(|| now.number(Id::ReferenceMm)),
        contraction_mm: now.number(Id::ContractionMm),
        pressure_bar: now.number(Id::PressureBar),
        command_bar: now.number(Id::CommandBar),
    })
}
