//! `mgpi bring-up`: a new board, part by part.

use std::path::PathBuf;

use clap::Args;
use wire::bring_up::Wanted;

use crate::Error;
use crate::output::Outputs;
use board_client::bring_up::run as ask;
use board_client::stop::Stop;

/// Tests a new board part by part, and keeps what each part has shown. The board has to have the
/// bring-up image, and the port is its service link: docs/bring-up.md.
///
/// Without --drive-output the valve stays vented, and nothing is sent on the bus without --echo. No
/// air, whatever is asked for. Exit status 2 if a part is faulty; the record is written all the
/// same.
#[derive(Args, Debug)]
pub struct Arguments {
    /// The serial port of the board's service link, by its path or its name under /dev
    #[arg(value_name = "PORT")]
    port: PathBuf,
    /// Where the record goes
    #[arg(short = 'o', long, value_name = "RECORD.toml")]
    output: PathBuf,
    /// Overwrite an existing file
    #[arg(long)]
    force: bool,
    /// Also drive the valve's output for a second, up to 2.9 V, 8.8 bar at a regulator, and read it
    /// back
    #[arg(long)]
    drive_output: bool,
    /// Also send on the bus and expect to hear it: only where the transceiver's receiver stays on
    /// while it sends
    #[arg(long)]
    echo: bool,
}

/// Tests.
///
/// # Errors
/// The board does not answer, a part of it is faulty, or the record cannot be written.
pub fn run(arguments: &Arguments) -> Result<(), Error> {
    let &Arguments { ref port, ref output, force, drive_output, echo } = arguments;
    let mut outputs = Outputs::claim([output], &[], force)?;
    let stop = Stop::on_signals();
    let report = ask(port, Wanted { output: drive_output, echo }, &stop, |part| say!("{}", part.in_words()))?;
    outputs.stage(output, report.to_toml(concat!("mgpi ", env!("CARGO_PKG_VERSION"))).as_bytes())?;
    outputs.commit()?;
    report.verdict()?;
    say!("{}: all {} parts are good", output.display(), report.parts.len());
    Ok(())
}
