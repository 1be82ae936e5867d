//! The command `mgpi`: identify, diagnose, simulate, run the firmware in the loop, drive a board,
//! draw reports.
//!
//! # Design
//! Each command is a file in [`commands`]; it reads (strictly), works, and writes all of its
//! outputs at the end and at once, or none. Any error goes to standard error, with exit status 2;
//! an interruption is status 130. Whatever goes wrong is an [`Error`] whose message names the
//! place.

/// Says a line for people ([`output::say`]).
macro_rules! say {
    ($($words:tt)*) => { crate::output::say(format_args!($($words)*)) };
}

mod commands;
mod error;
mod live;
mod output;
mod parquet;

use std::process::ExitCode;

use clap::Parser;

use commands::CommandLine;
use error::Error;

fn main() -> ExitCode {
    match CommandLine::parse().run() {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            eprintln!("error: {error}");
            ExitCode::from(error.exit_status())
        }
    }
}
