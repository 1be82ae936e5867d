//! `mgpi backup`: a board's whole configuration in a file.

use std::path::PathBuf;

use clap::Args;

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
    #[command(flatten)]
    port: PortArguments,
}

/// Keeps.
///
/// # Errors
/// The board does not answer, or the file cannot be written.
pub fn run(arguments: &Arguments) -> Result<(), Error> {
    let Arguments { port, output, force } = arguments;
    let mut outputs = Outputs::claim([output], &[], *force)?;
    let mut board = port.open()?;
    let origin = Origin { number: port.number(), identity: board.identity().clone() };
    let file = BackupFile { origin, backup: read(&mut board)? };
    let text = file.to_toml();
    // What would not come back is no backup.
    let again = BackupFile::parse(output, &text, false)?;
    if again.backup != file.backup {
        return Err(Error::Usage(format!(
            "{}: the board has a configuration that no file of this version can hold",
            output.display()
        )));
    }
    outputs.stage(output, text.as_bytes())?;
    outputs.commit()?;
    let model = if file.backup.configuration.is_some() { "model, controller" } else { "no model" };
    let kept = match (&file.backup.bus, &file.backup.calibration) {
        (Some(_), Some(_)) => "protection, bus and calibration",
        (Some(_), None) => "protection and bus",
        (None, _) => "protection",
    };
    say!("{}: {model}, {kept} of board number {}", output.display(), port.number());
    Ok(())
}
