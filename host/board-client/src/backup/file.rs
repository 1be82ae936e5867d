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

use std::io;
use std::path::{Path, PathBuf};

use model_core::pid::PidParameters;
use model_core::{ObserverParameters, TrackingParameters};
use sha2::{Digest, Sha256};
use thiserror::Error;
use toml::{Table, Value};
use wire::registers::fields::excess;
use wire::{BoardTracking, Configuration, Refusal, Scaling, VERSION};

use super::section::{self, shortest};
use super::{Backup, Origin};
use crate::bus::board::Identity;
use recording::input;
use recording::model_file::listed;
use recording::model_file::section::{KeyError, Section};

/// The format that this version writes.
const FORMAT: usize = 2;
/// The oldest that it reads.
const OLDEST_FORMAT: usize = 1;
/// The oldest messages whose configurations and limits are those of today.
const OLDEST: u16 = 6;
const SHA256: &str = "sha256";

/// A backup with the board that it is of.
#[derive(Clone, Debug, PartialEq)]
pub struct BackupFile {
    /// Where it comes from.
    pub origin: Origin,
    /// What is restored.
    pub backup: Backup,
}

/// What is wrong with the file of a backup.
#[derive(Debug, Error)]
#[allow(missing_docs, reason = "the messages say what the variants and their fields are")]
pub enum BackupFileError {
    #[error("{}: cannot be read: {source}", file.display())]
    Unreadable { file: PathBuf, source: io::Error },
    #[error("{}, line {line}: not a TOML file, or cut off: {message}", file.display())]
    Syntax { file: PathBuf, line: usize, message: String },
    #[error("{}, line {line}: {message}", file.display())]
    Key { file: PathBuf, line: usize, message: String },
    #[error(
        "{}, line {line}: sha256: the lines below have another one, {found}: the file is damaged, or was changed by \
         hand; --force takes it as it is", file.display()
    )]
    Checksum { file: PathBuf, line: usize, found: String },
    #[error("{}: no configuration that a board takes: {message}", file.display())]
    Invalid { file: PathBuf, message: String },
}

/// What is wrong within the text.
enum Problem {
    Key(KeyError),
    Invalid(String),
}

impl From<KeyError> for Problem {
    fn from(error: KeyError) -> Self {
        Self::Key(error)
    }
}

impl BackupFile {
    /// The file's text.
    pub fn to_toml(&self) -> String {
        let body = self.body();
        format!(
            "# The configuration of a valve board, by mgpi {}: `mgpi restore` brings it to a board.\nformat = {FORMAT}\n\
             # SHA-256 of all lines below the next one, each ended by a line feed\n{SHA256} = \"{}\"\n{body}",
            env!("CARGO_PKG_VERSION"),
            sha256(&body)
        )
    }

    fn body(&self) -> String {
        let board = Table::from_iter([("board".to_owned(), Value::Table(of_origin(&self.origin)))]);
        format!("\n{board}\n{}", of_backup(&self.backup))
    }

    /// Reads a backup; `as_it_is`: also one whose checksum is that of another content.
    ///
    /// # Errors
    /// See [`super`]'s contract.
    pub fn read(file: &Path, as_it_is: bool) -> Result<Self, BackupFileError> {
        let text = input::text(file)
            .map_err(|source| BackupFileError::Unreadable { file: file.to_owned(), source })?;
        Self::parse(file, &text.replace("\r\n", "\n"), as_it_is)
    }

    /// Reads the text of a backup; `file` is its name in messages.
    ///
    /// # Errors
    /// See [`super`]'s contract.
    pub fn parse(file: &Path, text: &str, as_it_is: bool) -> Result<Self, BackupFileError> {
        let at = |error: &KeyError| BackupFileError::Key {
            file: file.to_owned(),
            line: error.line(text),
            message: error.to_string(),
        };
        let table = text.parse::<Table>().map_err(|error| {
            let end = error.span().map_or(text.len(), |span| span.start.min(text.len()));
            let line = 1 + text.as_bytes()[..end].iter().filter(|byte| **byte == b'\n').count();
            BackupFileError::Syntax {
                file: file.to_owned(),
                line,
                message: error.message().replace('\n', ", "),
            }
        })?;
        let mut top = Section::top(table);
        let format = top.count("format").map_err(|error| at(&error))?;
        if !(OLDEST_FORMAT..=FORMAT).contains(&format) {
            let trouble = format!(
                "{format} is of another version; this program reads formats {OLDEST_FORMAT} to {FORMAT}"
            );
            return Err(at(&top.error("format", &trouble)));
        }
        let said = top.text(SHA256).map_err(|error| at(&error))?;
        let line = top.error(SHA256, "").line(text);
        let body: String = text.split_inclusive('\n').skip(line).collect();
        let found = sha256(&body);
        if said != found && !as_it_is {
            return Err(BackupFileError::Checksum { file: file.to_owned(), line, found });
        }
        content(top).map_err(|problem| match problem {
            Problem::Key(error) => at(&error),
            Problem::Invalid(message) => BackupFileError::Invalid { file: file.to_owned(), message },
        })
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
    let invalid = |refusal| Problem::Invalid(in_words(refusal));
    if let Some(configuration) = &configuration {
        BoardTracking::try_new(&configuration.tracking).map_err(|error| invalid(error.into()))?;
    }
    let protection = protection.checked().map_err(invalid)?;
    Ok(BackupFile { origin, backup: Backup { configuration, protection, bus, calibration } })
}

fn configuration(controller: Section, model: Section) -> Result<Configuration, Problem> {
    let (model, extensions) = listed::of_section(model).map_err(|problem| match problem {
        recording::model_file::Problem::Key(error) => Problem::Key(error),
        other => Problem::Invalid(other.to_string()),
    })?;
    let invalid = |error: model_core::ParameterError| Problem::Invalid(error.to_string());
    let mut tracking = TrackingParameters {
        model: model.convert().map_err(invalid)?,
        extensions: extensions.convert().map_err(invalid)?,
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

fn in_words(refusal: Refusal) -> String {
    match refusal {
        Refusal::Parameter(message) => message.as_str().to_owned(),
        other => format!("{other:?}"),
    }
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
            shorten(&mut model);
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
    let messages = board.count("messages")?;
    if !(usize::from(OLDEST)..=usize::from(VERSION)).contains(&messages) {
        let trouble =
            format!("{messages} is of another version; this program reads versions {OLDEST} to {VERSION}");
        return Err(board.error("messages", &trouble));
    }
    let firmware = board.text("firmware")?;
    let release: Option<Vec<u16>> = firmware.split('.').map(|part| part.parse().ok()).collect();
    let Some(release) = release.and_then(|release| <[u16; 3]>::try_from(release).ok()) else {
        return Err(board.error("firmware", &format!("\"{firmware}\" is no version such as \"0.1.0\"")));
    };
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

/// Every number, which a board has in single precision, in its shortest form.
fn shorten(value: &mut Value) {
    match value {
        Value::Float(number) => *number = shortest(*number as f32),
        Value::Array(values) => values.iter_mut().for_each(shorten),
        Value::Table(table) => table.iter_mut().for_each(|(_, value)| shorten(value)),
        _ => {}
    }
}

fn sha256(text: &str) -> String {
    Sha256::digest(text.as_bytes()).iter().map(|byte| format!("{byte:02x}")).collect()
}

/// What changes from one table to another, a line each; `path` is that of both, with a dot behind
/// it.
fn between(path: &str, before: &Table, after: &Table) -> Vec<String> {
    let gone = before.keys().filter(|key| !after.contains_key(*key));
    let of_key = |key: &String| {
        let path = format!("{path}{key}");
        let (before, after) = (before.get(key), after.get(key));
        let table = |value: Option<&Value>| value.and_then(Value::as_table).cloned();
        match (table(before), table(after)) {
            _ if before == after => Vec::new(),
            (None, None) => {
                vec![format!("{path:<36} {} -> {}", value_in_words(before), value_in_words(after))]
            }
            (before, after) => {
                between(&format!("{path}."), &before.unwrap_or_default(), &after.unwrap_or_default())
            }
        }
    };
    after.keys().chain(gone).flat_map(of_key).collect()
}

fn value_in_words(value: Option<&Value>) -> String {
    value.map_or_else(|| "none".to_owned(), Value::to_string)
}
