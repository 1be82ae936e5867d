//! A backup from a board, and to it.
//!
//! # To a board
//! The configuration is staged first: it stands in the board's buffer, read back, and does nothing.
//! Then calibration, limits of the plant and how the board is reached are written, at once each,
//! and the configuration is committed. A board that does not take one of them gets back what it had
//! before. How it is reached is taken at its next start: until then it answers as it did.

use wire::Protection;
use wire::registers::{Access, Id, Register, fields};

use super::Backup;
use super::section::{protection_registers, protection_value};
use crate::bus::reached::{self, Reached};
use crate::bus::{Board, BoardError, calibration, upload};

/// What a board has.
///
/// # Errors
/// No answer, or a configuration that this program cannot read.
pub fn read(board: &mut Board) -> Result<Backup, BoardError> {
    let configuration = match upload::fetch(board) {
        Err(BoardError::NoConfiguration) => None,
        fetched => Some(fetched?),
    };
    let block = board.read(Id::SelfTestTicks, Id::OnModelFault)?;
    let mut protection = Protection::STANDARD;
    for register in protection_registers() {
        if let (Some(field), Some(value)) =
            (fields::of_protection(&mut protection, register.id), block.value(register.id))
        {
            field.set(value);
        }
    }
    let bus = Reached::read(board)?.map(|reached| reached.kept);
    Ok(Backup { configuration, protection, bus, calibration: calibration::read_if_kept(board)? })
}

/// Brings a backup to a board that has `current`, and compares. `moved` is told how many bytes of
/// how many are done.
///
/// # Errors
/// The board does not take it, and has what it had before; or it does not answer any more, and the
/// error says what it has.
pub fn restore(
    board: &mut Board,
    backup: &Backup,
    current: &Backup,
    moved: &dyn Fn(usize, usize),
) -> Result<(), BoardError> {
    demand_writable(&current.protection, &backup.protection)?;
    if backup.configuration.is_none() && current.configuration.is_some() {
        return Err(BoardError::NoModelToRestore);
    }
    let staged = match &backup.configuration {
        Some(configuration) => Some(upload::stage(board, configuration, moved)?),
        None => None,
    };
    let wanted = backup.over(current);
    let done = set(board, current, &wanted)
        .and_then(|()| staged.map_or(Ok(()), |bytes| upload::commit(board, &bytes)));
    if let Err(problem) = done {
        return Err(match set(board, &wanted, current) {
            Ok(()) => problem,
            Err(_) => BoardError::HalfRestored(Box::new(problem)),
        });
    }
    if read(board)? == wanted { Ok(()) } else { Err(BoardError::NotInstalled) }
}

/// Writes what differs of calibration, limits and how the board is reached.
fn set(board: &mut Board, from: &Backup, to: &Backup) -> Result<(), BoardError> {
    if let Some(lines) = to.calibration.filter(|_| to.calibration != from.calibration) {
        calibration::write(board, &lines)?;
    }
    protect(board, &from.protection, &to.protection)?;
    if let Some(bus) = to.bus.filter(|_| to.bus != from.bus) {
        reached::keep(board, &bus)?;
    }
    Ok(())
}

/// Whether limits differ at a register.
fn differs(id: Id, from: &Protection, to: &Protection) -> bool {
    protection_value(from, id) != protection_value(to, id)
}

fn is_taken(register: &Register, protection: &Protection) -> bool {
    protection_value(protection, register.id).is_some_and(|value| register.takes(value))
}

/// All limits that change are such as the board takes.
fn demand_writable(from: &Protection, to: &Protection) -> Result<(), BoardError> {
    let refused =
        protection_registers().find(|register| differs(register.id, from, to) && !is_taken(register, to));
    match (refused, refused.and_then(|register| protection_value(to, register.id))) {
        (Some(&Register { name, access: Access::Write(min, max), .. }), Some(value)) => {
            Err(BoardError::Setting { name, value: value.number() as f32, min, max })
        }
        _ => Ok(()),
    }
}

/// Writes the limits that differ; those between them too, in one write, which the board takes as a
/// whole.
fn protect(board: &mut Board, from: &Protection, to: &Protection) -> Result<(), BoardError> {
    let registers: Vec<&Register> = protection_registers().collect();
    // A limit that is off, which a board in the emulator may have, cannot be written, and is no
    // part of a write.
    for run in registers.chunk_by(|one, next| is_taken(one, to) == is_taken(next, to)) {
        if run.iter().any(|register| differs(register.id, from, to)) {
            let values = run.iter().filter_map(|register| protection_value(to, register.id));
            let words: Vec<u16> = values.flat_map(|value| value.words().collect::<Vec<_>>()).collect();
            board.write(run[0].id, &words)?;
        }
    }
    Ok(())
}
