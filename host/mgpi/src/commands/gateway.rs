//! `mgpi gateway`: all boards of all lines on one page.

use std::net::SocketAddr;
use std::path::PathBuf;
use std::sync::Arc;
use std::thread;

use ::gateway::Gateway;
use ::gateway::lines;
use board_client::child::WAIT_SLICE;
use board_client::stop::Stop;
use clap::Args;

use crate::Error;
use crate::live::fleet::FleetSite;
use crate::live::serve;

/// Watches all boards of all lines until Ctrl-C, and shows them on a page: state, fault with cause
/// and cure, contraction, pressure, bus and clock of each, a stop for all; the same figures for
/// Prometheus under /metrics and for programs under /fleet.json. It drives nothing. The page is
/// served to this machine alone unless --http says otherwise.
#[derive(Args, Debug)]
pub struct Arguments {
    /// Which boards there are: a [[line]] with port, boards = [1, 2] or [{number = 1, name =
    /// "biceps"}], and, where they are not the usual ones, name, rate_bit_per_s, parity, answer_s
    #[arg(value_name = "LINES.toml")]
    lines: PathBuf,
    /// Where the page is served
    #[arg(long, default_value = "127.0.0.1:8080", value_name = "ADDRESS")]
    http: SocketAddr,
}

/// Watches, until the user ends it.
///
/// # Errors
/// The file is of no use, or the page cannot be served. A port or a board that is not there is
/// shown, and looked for again.
pub fn run(arguments: &Arguments) -> Result<(), Error> {
    let lines = lines::read(&arguments.lines)?;
    let stop = Stop::on_signals();
    let gateway = Arc::new(Gateway::start(lines));
    let address = serve(arguments.http, &FleetSite::new(gateway.clone()))?;
    say!("http://{address}/ shows the boards; Ctrl-C ends");
    if !address.ip().is_loopback() {
        eprintln!("warning: whoever reaches {address} sees the boards, and may stop them");
    }
    while !stop.is_requested() {
        thread::sleep(WAIT_SLICE);
    }
    Ok(())
}
