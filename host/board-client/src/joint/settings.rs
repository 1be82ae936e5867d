//! The settings of a joint's board as a file: limits of the plant, and what the sensors have shown.
//!
//! ```toml
//! [limits]                            # each may be missing: the standard one then
//! overpressure_soft_bar = 5.5
//! [calibration]                       # each sensor may be missing: the standard one then
//! pressure_a_zero_code = 411.0
//! pressure_a_codes_per_bar = 325.9
//! angle_zero_code = 2100.0
//! angle_codes_per_degree = 20.4
//! ```
//!
//! Names and ranges of the limits are those of the registers of a board with one muscle.

use std::path::{Path, PathBuf};

use recording::input;
use recording::model_file::section::{KeyError, Section};
use thiserror::Error;
use toml::Table;
use wire::joint::settings::LIMITS;
use wire::joint::{JointCalibration, JointRequest, JointSettings};
use wire::registers::Id;
use wire::registers::fields::of_protection;
use wire::{Line, Protection};

use super::error::JointBoardError;
use super::link::JointLink;
use crate::backup::joint::to_line;
use crate::backup::value_within;

/// What is wrong with the file of a joint's settings.
#[derive(Debug, Error)]
#[allow(missing_docs, reason = "the messages say what the variants and their fields are")]
pub enum SettingsFileError {
    #[error("{}: cannot be read: {source}", file.display())]
    Unreadable { file: PathBuf, source: std::io::Error },
    #[error("{}: not a TOML file, or cut off: {message}", file.display())]
    Syntax { file: PathBuf, message: String },
    #[error("{}, line {line}: {message}", file.display())]
    Key { file: PathBuf, line: usize, message: String },
}

/// Reads the settings of a joint's board.
///
/// # Errors
/// It is not such a file, or has a limit that no board takes.
pub fn read(file: &Path) -> Result<JointSettings, SettingsFileError> {
    let at = || file.to_owned();
    let text = input::text(file).map_err(|source| SettingsFileError::Unreadable { file: at(), source })?;
    let table = text.parse::<Table>().map_err(|error| SettingsFileError::Syntax {
        file: at(),
        message: error.message().replace('\n', ", "),
    })?;
    parsed(Section::top(table)).map_err(|error| SettingsFileError::Key {
        file: at(),
        line: error.line(&text),
        message: error.to_string(),
    })
}

fn parsed(mut top: Section) -> Result<JointSettings, KeyError> {
    let mut protection = Protection::STANDARD;
    if let Some(mut section) = top.optional_section("limits")? {
        for id in LIMITS {
            let register = id.register();
            if section.has(register.name) {
                let value = value_within(&mut section, register)?;
                of_protection(&mut protection, id).into_iter().for_each(|field| field.set(value));
            }
        }
        section.finish()?;
    }
    let mut calibration = JointCalibration::default();
    if let Some(mut section) = top.optional_section("calibration")? {
        calibration.pressures = [
            to_line(&mut section, ["pressure_a_zero_code", "pressure_a_codes_per_bar"], 1.0)?,
            to_line(&mut section, ["pressure_b_zero_code", "pressure_b_codes_per_bar"], 1.0)?,
        ];
        calibration.angle =
            to_line(&mut section, ["angle_zero_code", "angle_codes_per_degree"], 1_f64.to_degrees())?;
        section.finish()?;
    }
    top.finish()?;
    Ok(JointSettings { protection, calibration })
}

/// Gives a board its settings.
///
/// # Errors
/// It does not answer, refuses them, or has others behind that.
pub fn give(link: &mut JointLink, settings: &JointSettings) -> Result<(), JointBoardError> {
    let told = link.settings(&JointRequest::Settings(Some(*settings)))?;
    if told == *settings { Ok(()) } else { Err(JointBoardError::OtherSettings) }
}

/// What is another one with other settings, a line each: name, before and after.
pub fn changes(before: &JointSettings, after: &JointSettings) -> Vec<String> {
    let limit = |settings: &JointSettings, id| limit(&settings.protection, id).map(|value| value.to_string());
    let limits = LIMITS.into_iter().map(|id| (id.register().name, limit(before, id), limit(after, id)));
    let lines = |settings: &JointSettings| {
        let JointCalibration { pressures: [a, b], angle } = settings.calibration;
        [("bar", a), ("bar", b), ("rad", angle)].map(|(unit, line)| Some(line_in_words(line, unit)))
    };
    let sensors = ["pressure a", "pressure b", "angle"].into_iter().zip(lines(before)).zip(lines(after));
    let sensors = sensors.map(|((name, before), after)| (name, before, after));
    limits
        .chain(sensors)
        .filter(|(_, before, after)| before != after)
        .map(|(name, before, after)| {
            format!("{name:<24}{} -> {}", before.unwrap_or_default(), after.unwrap_or_default())
        })
        .collect()
}

/// A limit by its register, as a number.
pub(super) fn limit(protection: &Protection, id: Id) -> Option<f32> {
    let mut protection = *protection;
    of_protection(&mut protection, id).map(|field| field.get().number() as f32)
}

/// The line of a sensor in a unit.
pub(super) fn line_in_words(line: Option<Line>, unit: &str) -> String {
    line.map_or("standard".to_owned(), |Line { zero_code, codes_per_unit }| {
        format!("{zero_code} + {codes_per_unit} a {unit}")
    })
}
