//! `mgpi scan`: which boards are on a line.

use std::path::PathBuf;
use std::time::Duration;

use clap::Args;
use indicatif::{ProgressBar, ProgressStyle};
use serde_json::Value;
use wire::registers::BAUD;

use super::number::positive;
use crate::Error;
use board_client::bus::BoardError;
use board_client::bus::client::Address;
use board_client::bus::port::{Line, Parity};
use board_client::bus::scan::{Found, Who, scan, stop_all};

/// Lists the boards on a line: number, firmware, state, and the processor's number, of which there
/// are no two. Nothing is changed, but for --stop.
///
/// All of 247 numbers take half a minute a rate. Two boards of one number are told.
#[derive(Args, Debug)]
pub struct Arguments {
    /// Serial port, by its path or its name under /dev
    #[arg(long, value_name = "PORT")]
    port: PathBuf,
    /// Rates to ask by, in bit/s; a board that has heard nobody for 10 s listens by 115200 too
    #[arg(long, default_values_t = [BAUD], value_delimiter = ',', value_name = "BIT/S,…", value_parser = clap::value_parser!(u32).range(1200..=4_000_000))]
    baud: Vec<u32>,
    /// Parity
    #[arg(long, default_value = "none")]
    parity: Parity,
    /// The first number that is asked
    #[arg(long, default_value_t = 1, value_name = "N", value_parser = clap::value_parser!(u8).range(1..=247))]
    first: u8,
    /// The last one
    #[arg(long, default_value_t = 247, value_name = "N", value_parser = clap::value_parser!(u8).range(1..=247))]
    last: u8,
    /// Longest time for an answer in s, the board's turn-around within it; each number is asked
    /// twice
    #[arg(long, default_value_t = 0.06, value_name = "S", value_parser = positive)]
    timeout_s: f64,
    /// Vent all boards first, those that are not listed too
    #[arg(long)]
    stop: bool,
    /// For programs
    #[arg(long)]
    json: bool,
}

/// Lists.
///
/// # Errors
/// The port cannot be used, nobody answers, or several by one number.
pub fn run(arguments: &Arguments) -> Result<(), Error> {
    let &Arguments { ref port, ref baud, parity, first, last, timeout_s, stop, json } = arguments;
    if first > last {
        return Err(Error::Usage(format!("--first {first} is above --last {last}")));
    }
    let address = |baud| Address {
        port: port.clone(),
        line: Line { baud, parity },
        unit: first,
        limit: Duration::from_secs_f64(timeout_s),
    };
    if stop {
        for &baud in baud {
            stop_all(&address(baud)).map_err(BoardError::from)?;
        }
    }
    let count = u64::from(last - first) + 1;
    let style = ProgressStyle::with_template("scanning {wide_bar} {pos} of {len}, {eta} left");
    let bar = ProgressBar::new(count * baud.len() as u64)
        .with_style(style.unwrap_or_else(|_| ProgressStyle::default_bar()));
    let mut found = Vec::new();
    for &baud in baud {
        let here = scan(&address(baud), first..=last, || bar.inc(1)).map_err(BoardError::from)?;
        found.extend(here);
    }
    bar.finish_and_clear();
    if json {
        say!("{:#}", Value::Array(found.iter().map(Found::to_json).collect()));
    } else {
        found.iter().for_each(|found| say!("{}", found.in_words()));
    }
    let clashes = found.iter().filter(|found| found.who == Who::Several);
    let clashes: Vec<String> = clashes.map(|found| found.unit.to_string()).collect();
    match (&found[..], &clashes[..]) {
        ([], _) => Err(Error::Usage(format!(
            "{}: nobody answers by the numbers {first} to {last}: are the boards powered, A and B not swapped, and the \
             rate one of theirs?",
            port.display()
        ))),
        (_, []) => Ok(()),
        (_, clashes) => Err(Error::Usage(format!(
            "{}: damaged answers by number {}: two boards have it, or the line is disturbed",
            port.display(),
            clashes.join(", ")
        ))),
    }
}
