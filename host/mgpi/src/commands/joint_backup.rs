//! `mgpi backup --joint` and `mgpi restore --joint`: what the board of a joint has been told, in a
//! file, and back.

use std::path::Path;

use board_client::backup::joint::{JointBackup, JointBackupFile, JointOrigin};
use board_client::joint::link::{Address, JointLink};
use board_client::joint::restore::{self, read};
use wire::joint::JointSettings;

use super::board_file::{is_to_be_done, keep};
use super::joint_board::FaultArguments;
use crate::Error;
use crate::output::Outputs;

/// Keeps.
///
/// # Errors
/// The board does not answer, or cannot read its joint back; the file cannot be written.
pub fn backup(output: &Path, address: Address, outputs: Outputs) -> Result<(), Error> {
    let mut link = JointLink::look(address)?;
    let origin = JointOrigin::of(link.hello());
    let file = JointBackupFile { origin, backup: read(&mut link)? };
    let text = file.to_toml();
    // What would not come back is no backup.
    let again = JointBackupFile::parse(output, &text, false)?;
    keep((output, &text), again.backup.is(&file.backup), outputs)?;
    if let Some(fault) = link.hello().fault {
        eprintln!(
            "note: the board is at {fault}; kept is what it has now, which may not be what it had before"
        );
    }
    let joint = if file.backup.control.is_some() { "joint, gains" } else { "no joint" };
    say!("{}: {joint}, limits and calibration of the board of a joint", output.display());
    Ok(())
}

/// What is restored, where and how.
pub struct Arguments<'a> {
    pub file: &'a Path,
    pub address: Address,
    pub fault: &'a FaultArguments,
    pub keeps_calibration: bool,
    pub is_forced: bool,
    pub dry_run: bool,
}

/// Restores.
///
/// # Errors
/// The file is not what it should be, or the board does not take or keep it.
pub fn restore(arguments: Arguments<'_>) -> Result<(), Error> {
    let Arguments { file, address, fault, keeps_calibration, is_forced, dry_run } = arguments;
    let JointBackupFile { origin, backup } = JointBackupFile::read(file, is_forced)?;
    let mut link = fault.open(&address)?;
    let here = JointOrigin::of(link.hello());
    if origin != here {
        let differences = origin.differences(&here).join(", ");
        say!("{} is of a board with other versions or sensors: {differences}", file.display());
    }
    let current = read(&mut link)?;
    let settings = JointSettings {
        calibration: if keeps_calibration {
            current.settings.calibration
        } else {
            backup.settings.calibration
        },
        ..backup.settings
    };
    let backup = JointBackup { settings, ..backup };
    if !is_to_be_done(file, &backup.differences(&current), dry_run) {
        return Ok(());
    }
    restore::restore(&mut link, &backup, &current)?;
    say!(
        "{} is restored, read back, verified, and kept without power; both muscles are vented until a start",
        file.display()
    );
    Ok(())
}
