//! The file of a backup, format 2; what differs between two, key by key.
//!
//! ```toml
//! # what it is
//! format = 2
//! # what the next line is
//! sha256 = "…"
//!
//! [board]          # where it comes from
//! [protection]     # registers of the group "Protection"
//! [bus]            # registers of the group "Bus" that are kept
//! [calibration]    # registers of the group "Calibration"; both only of a board that keeps them
//! [controller]     # registers of the group "Controller"; this and the model only of a board with one
//! [model]          # as in a model file, in bar and mm
//! ```
//!
//! The checksum is over all lines below its own, each ended by a line feed, so that any program can
//! check it. Numbers are in their shortest form that reads back as the same bits.
//!
//! Format 1 had no bus and no calibration: what a board has of both stays.

use std::path::Path;

use model_core::pid::PidParameters;
use model_core::{ObserverParameters, TrackingParameters};
use toml::{Table, Value};
use wire::registers::fields::excess;
use wire::{BoardTracking, Configuration, Refusal, Scaling, VERSION};

use super::framed::{BackupFileError, ONE_MUSCLE, Problem, between, shorten};
use super::section::{self, shortest};
use super::{Backup, Origin};
use crate::bus::board::Identity;
use recording::model_file::listed;
use recording::model_file::section::{KeyError, Section};

/// The oldest messages whose configurations and limits are those of today.
const OLDEST: u16 = 6;

/// A backup with the board that it is of.
#[derive(Clone, Debug, PartialEq)]
pub struct BackupFile {
    /// Where it comes from.
    pub origin: Origin,
    /// What is restored.
    pub backup: Backup,
}

impl BackupFile {
    /// The file's text.
    pub fn to_toml(&self) -> String {
        let board = Table::from_iter([("board".to_owned(), Value::Table(of_origin(&self.origin)))]);
        ONE_MUSCLE.to_toml(&[board, of_backup(&self.backup)])
    }

    /// Reads a backup; `as_it_is`: also one whose checksum is that of another content.
    ///
    /// # Errors
    /// See [`super`]'s contract.
    pub fn read(file: &Path, as_it_is: bool) -> Result<Self, BackupFileError> {
        ONE_MUSCLE.read(file, as_it_is, content)
    }

    /// Reads the text of a backup; `file` is its name in messages.
    ///
    /// # Errors
    /// See [`super`]'s contract.
    pub fn parse(file: &Path, text: &str, as_it_is: bool) -> Result<Self, BackupFileError> {
        ONE_MUSCLE.parse((file, text), as_it_is, content)
    }
}

impl Backup {
    /// What changes where `before` becomes this, a line each; none where both are the same. What
    /// this does not have stays.
    pub fn differences(&self, before: &Self) -> Vec<String> {
        between("", &of_backup(before), &of_backup(&self.over(before)))
    }

    /// What a board has that had `before`, once this is restored.
    #[must_use]
    pub fn over(&self, before: &Self) -> Self {
        Self {
            bus: self.bus.or(before.bus),
            calibration: self.calibration.or(before.calibration),
            ..self.clone()
        }
    }
}

impl Origin {
    /// In what this board differs from another, a line each.
    pub fn differences(&self, other: &Self) -> Vec<String> {
        between("", &of_origin(other), &of_origin(self))
    }

    /// Whether it differs from another in nothing but its scalings, as a board does from itself
    /// before it was calibrated.
    pub fn is_but_for_calibration(&self, other: &Self) -> bool {
        let Identity { pressure, contraction, command, .. } = other.identity;
        let identity = Identity { pressure, contraction, command, ..self.identity.clone() };
        Self { number: self.number, identity } == *other
    }
}

fn content(mut top: Section) -> Result<BackupFile, Problem> {
    let origin = origin(top.section("board")?)?;
    let protection = section::to_protection(top.section("protection")?)?;
    let configuration = match top.optional_section("controller")? {
        None => None,
        Some(controller) => Some(configuration(controller, top.section("model")?)?),
    };
    let bus = top.optional_section("bus")?.map(section::to_bus).transpose()?;
    let calibration = top.optional_section("calibration")?.map(section::to_calibration).transpose()?;
    top.finish()?;
    if let Some(configuration) = &configuration {
        BoardTracking::try_new(&configuration.tracking).map_err(Refusal::from)?;
    }
    let protection = protection.checked()?;
    Ok(BackupFile { origin, backup: Backup { configuration, protection, bus, calibration } })
}

fn configuration(controller: Section, model: Section) -> Result<Configuration, Problem> {
    let (model, extensions) = listed::of_section(model)?;
    let mut tracking = TrackingParameters {
        model: model.convert()?,
        extensions: extensions.convert()?,
        pid: PidParameters::paper(),
        observer: ObserverParameters::default(),
        command_min: 0.0,
        command_max: 0.0,
        slew_bar_per_s: 0.0,
        period_s: 0.0,
    };
    section::to_controller(controller, &mut tracking)?;
    if let Some((id, value)) = excess(&mut tracking) {
        let name = id.register().name;
        return Err(Problem::Invalid(format!("{name} is {}, which no board takes", value.number())));
    }
    Ok(Configuration { version: VERSION, tracking })
}

/// What is restored, as it stands in the file.
fn of_backup(backup: &Backup) -> Table {
    let mut top = Table::new();
    top.insert("protection".into(), Value::Table(section::of_protection(&backup.protection)));
    if let Some(bus) = &backup.bus {
        top.insert("bus".into(), Value::Table(section::of_bus(bus)));
    }
    if let Some(calibration) = &backup.calibration {
        top.insert("calibration".into(), Value::Table(section::of_calibration(calibration)));
    }
    if let Some(Configuration { tracking, .. }) = &backup.configuration {
        top.insert("controller".into(), Value::Table(section::of_controller(tracking)));
        // The host has room for more operators than a board.
        if let (Ok(model), Ok(extensions)) = (tracking.model.convert(), tracking.extensions.convert()) {
            let mut model = Value::Table(listed::to_table(&model, &extensions));
            shorten(&mut model, |_| false);
            top.insert("model".into(), model);
        }
    }
    top
}

/// What is said of the board, with the versions that have to fit.
fn of_origin(Origin { number, identity }: &Origin) -> Table {
    let Identity { wire_version, storage_version, release: [major, minor, patch], period_s, .. } = *identity;
    let mut table = Table::new();
    let mut put = |key: &str, value: Value| table.insert(key.to_owned(), value);
    put("number", i64::from(*number).into());
    put("firmware", format!("{major}.{minor}.{patch}").into());
    put("messages", i64::from(wire_version).into());
    put("storage", i64::from(storage_version).into());
    put("tick_period_us", ((1e6 * period_s).round() as i64).into());
    for (name, scaling) in scalings(identity) {
        put(&format!("{name}_zero_code"), shortest(scaling.zero_code).into());
        put(&format!("{name}_codes_per_unit"), shortest(scaling.codes_per_unit).into());
    }
    table
}

/// The scalings by their quantities: pressure and command in bar, contraction in mm.
fn scalings(identity: &Identity) -> [(&'static str, Scaling); 3] {
    let Identity { pressure, contraction, command, .. } = *identity;
    [("pressure", pressure), ("contraction", contraction), ("command", command)]
}

fn origin(mut board: Section) -> Result<Origin, KeyError> {
    section::messages(&mut board, OLDEST..=VERSION)?;
    let release = section::release(&mut board)?;
    let mut whole = |key: &str, most: u32| {
        let count = board.count(key)?;
        u32::try_from(count)
            .ok()
            .filter(|count| *count <= most)
            .ok_or_else(|| board.error(key, &format!("{count} is too much, must be at most {most}")))
    };
    let number = whole("number", 247)? as u8;
    let storage_version = whole("storage", u16::MAX.into())? as u16;
    let period_s = f64::from(whole("tick_period_us", u32::MAX)?) * 1e-6;
    let mut scaling = |name: &str| -> Result<Scaling, KeyError> {
        Ok(Scaling {
            zero_code: board.number(&format!("{name}_zero_code"))? as f32,
            codes_per_unit: board.number(&format!("{name}_codes_per_unit"))? as f32,
            code_min: 0,
            code_max: u16::MAX,
        })
    };
    let identity = Identity {
        wire_version: VERSION,
        storage_version,
        release,
        period_s,
        pressure: scaling("pressure")?,
        contraction: scaling("contraction")?,
        command: scaling("command")?,
    };
    board.finish()?;
    Ok(Origin { number, identity })
}
