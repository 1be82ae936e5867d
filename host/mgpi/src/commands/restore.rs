//! `mgpi restore`: the configuration of a file to a board.

use std::path::PathBuf;

use clap::Args;

use super::board_file::is_to_be_done;
use super::deploy::{demand_rest, ready, with_progress};
use super::joint_backup;
use super::joint_board::FaultArguments;
use super::port::PortArguments;
use crate::Error;
use board_client::backup::{Backup, BackupFile, Origin, read, restore};

/// Brings the configuration that `mgpi backup` has kept to a board, and verifies it. The board
/// takes all of it, or keeps what it has; what differs is listed first.
///
/// Number, rate and parity are taken at the board's next start, or by `mgpi bus --take`. A board
/// that takes the place of another gets all of it; one that stays beside the other needs its own
/// number, and one with other sensors its own calibration.
#[derive(Args, Debug)]
pub struct Arguments {
    /// What `mgpi backup` has written
    #[arg(value_name = "BOARD.toml")]
    file: PathBuf,
    /// List what differs, and change nothing
    #[arg(long)]
    dry_run: bool,
    /// Leave number, rate and parity as the board has them
    #[arg(long, conflicts_with = "joint")]
    keep_bus: bool,
    /// Leave the calibration as the board has it
    #[arg(long)]
    keep_calibration: bool,
    /// Also take a file that was changed by hand, whose checksum does not fit
    #[arg(long)]
    force: bool,
    /// To a board of a joint, by its service link; it has to be vented
    #[arg(long, help_heading = "Joint", conflicts_with_all = ["unit", "parity"])]
    joint: bool,
    #[command(flatten)]
    fault: FaultArguments,
    #[command(flatten)]
    port: PortArguments,
}

/// Restores.
///
/// # Errors
/// The file is not what it should be, or the board does not take it.
pub fn run(arguments: &Arguments) -> Result<(), Error> {
    let Arguments { file, port, dry_run, keep_bus, keep_calibration, force, joint, fault } = arguments;
    if *joint {
        return joint_backup::restore(joint_backup::Arguments {
            file,
            address: port.link(),
            fault,
            keeps_calibration: *keep_calibration,
            is_forced: *force,
            dry_run: *dry_run,
        });
    }
    let BackupFile { origin, backup } = BackupFile::read(file, *force)?;
    let backup = Backup {
        bus: backup.bus.filter(|_| !keep_bus),
        calibration: backup.calibration.filter(|_| !keep_calibration),
        ..backup
    };
    let mut board = port.open()?;
    demand_rest(&mut board)?;
    let here = Origin { number: port.number(), identity: board.identity().clone() };
    if origin != here {
        let whose = if origin.is_but_for_calibration(&here) {
            "from before this board was calibrated, or of another one of the same number and firmware"
        } else {
            "of another board, or of this one with another number or firmware"
        };
        say!("{} is {whose}: {}", file.display(), origin.differences(&here).join(", "));
    }
    let current = read(&mut board)?;
    if !is_to_be_done(file, &backup.differences(&current), *dry_run) {
        return Ok(());
    }
    with_progress("restoring", |moved| restore(&mut board, &backup, &current, moved))?;
    if backup.configuration.is_some() {
        ready(&mut board)?;
    }
    say!("{} is restored, read back and verified", file.display());
    if backup.bus.is_some() && backup.bus != current.bus {
        say!("number, rate and parity are taken at the board's next start, or by mgpi bus --take");
    }
    Ok(())
}
