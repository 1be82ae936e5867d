//! The command `rig`. Every error is one message on standard error and exit status 2.

use std::process::ExitCode;

use clap::Parser;
use rig::command::Command;

/// A pneumatic muscle on its valve, as a balance of forces.
#[derive(Parser)]
#[command(version)]
struct Cli {
    #[command(subcommand)]
    command: Command,
}

fn main() -> ExitCode {
    match Cli::parse().command.run() {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            eprintln!("error: {error:#}");
            ExitCode::from(2)
        }
    }
}
