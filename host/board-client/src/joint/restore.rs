//! What a board at its link has been told, read back, and restored.
//!
//! # Order
//! Limits and lines of the sensors are given first, the joint behind them, each of which a board
//! takes as a whole, vented, or refuses. Where it refuses the joint it gets back the settings that
//! it had. Nothing is driven.

use wire::joint::JointRequest;

use super::deploy::deploy;
use super::error::JointBoardError;
use super::link::JointLink;
use super::settings;
use crate::backup::joint::JointBackup;

/// What a board has, in whatever state it is; nothing is changed.
///
/// # Errors
/// It does not answer, or cannot read its joint back.
pub fn read(link: &mut JointLink) -> Result<JointBackup, JointBoardError> {
    let control = link.control()?;
    let settings = link.settings(&JointRequest::Settings(None))?;
    Ok(JointBackup { control, settings })
}

/// Brings a backup to a board that has `current`, and compares.
///
/// # Errors
/// The board does not take it, and has what it had before; it does not answer any more, and the
/// error says so; or its flash has not kept it.
pub fn restore(
    link: &mut JointLink,
    backup: &JointBackup,
    current: &JointBackup,
) -> Result<(), JointBoardError> {
    let settings = &backup.settings;
    let given = match &backup.control {
        None if current.control.is_some() => return Err(JointBoardError::NoJointToRestore),
        None => settings::give(link, settings),
        Some(control) => deploy(link, control, Some(settings)),
    };
    if let Err(problem) = given {
        return Err(undone(link, current, problem));
    }
    let told = read(link)?;
    if told.settings != backup.settings {
        return Err(JointBoardError::OtherSettings);
    }
    if !told.is(backup) {
        return Err(JointBoardError::NotInstalled);
    }
    if link.has_kept() { Ok(()) } else { Err(JointBoardError::NotStored) }
}

/// What is said of a problem, once the board has its settings of before again where it has refused
/// something.
fn undone(link: &mut JointLink, current: &JointBackup, problem: JointBoardError) -> JointBoardError {
    let is_undone = match problem {
        // It has all of the backup until power is lost.
        JointBoardError::NotStored => return problem,
        JointBoardError::Refused(_) | JointBoardError::State(_) | JointBoardError::AtFault(_) => {
            settings::give(link, &current.settings).is_ok()
        }
        // Nobody knows what it has heard.
        _ => false,
    };
    if is_undone { problem } else { JointBoardError::HalfRestored(Box::new(problem)) }
}
