//! `mgpi backup`: a board's whole configuration in a file.

use std::path::PathBuf;

use clap::Args;

use super::board_file::keep;
use super::joint_backup;
use super::port::PortArguments;
use crate::Error;
use crate::output::Outputs;
use board_client::backup::{BackupFile, Origin, read};

/// Keeps a board's whole configuration in a file: model, gains, limits, protection, number and rate
/// on the bus, calibration. `mgpi restore` brings it back.
#[derive(Args, Debug)]
pub struct Arguments {
    /// Where the configuration goes
    #[arg(short = 'o', value_name = "BOARD.toml")]
    output: PathBuf,
    /// Overwrite an existing file
    #[arg(long)]
    force: bool,
    /// Keep that of a board of a joint, by its service link: joint with gains, limits, calibration
    #[arg(long, help_heading = "Joint", conflicts_with_all = ["unit", "parity"])]
    joint: bool,
    #[command(flatten)]
    port: PortArguments,
}

/// Keeps.
///
/// # Errors
/// The board does not answer, or the file cannot be written.
pub fn run(arguments: &Arguments) -> Result<(), Error> {
    let Arguments { port, output, force, joint } = arguments;
    let outputs = Outputs::claim([output], &[], *force)?;
    if *joint {
        return joint_backup::backup(output, port.link(), outputs);
    }
    let mut board = port.open()?;
    let origin = Origin { number: port.number(), identity: board.identity().clone() };
    let file = BackupFile { origin, backup: read(&mut board)? };
    let text = file.to_toml();
    // What would not come back is no backup.
    let again = BackupFile::parse(output, &text, false)?;
    keep((output, &text), again.backup == file.backup, outputs)?;
    let model = if file.backup.configuration.is_some() { "model, controller" } else { "no model" };
    let kept = match (&file.backup.bus, &file.backup.calibration) {
        (Some(_), Some(_)) => "protection, bus and calibration",
        (Some(_), None) => "protection and bus",
        (None, _) => "protection",
    };
    say!("{}: {model}, {kept} of board number {}", output.display(), port.number());
    Ok(())
}
