//! The command `mgpi`. Any error goes to standard error, with exit status 2; an interruption is status 130.

use std::process::ExitCode;

use clap::Parser;
use workbench::commands::CommandLine;

fn main() -> ExitCode {
    match CommandLine::parse().run() {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            eprintln!("error: {error}");
            ExitCode::from(error.exit_status())
        }
    }
}
