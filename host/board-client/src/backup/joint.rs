//! The backup of a joint's board: its file, format 1; what differs between two, key by key.
//!
//! ```toml
//! # what it is
//! format = 1
//! # what the next line is
//! sha256 = "…"
//! kind = "joint_board"
//!
//! [board]          # where it comes from
//! [protection]     # registers of the group "Protection" of a board with one muscle
//! [calibration]    # lines of the sensors; one that is missing is the standard one
//! [controller]     # gains and rates; this and the model only of a board with a joint
//! [model.…]        # the tables of the model file of a joint
//! ```
//!
//! The checksum is that of a backup of a board with one muscle, and so is how numbers are written.
//! Angles of the model are degrees in double precision, which read back as the same bits in single
//! precision.

use std::path::Path;

use model_core::pid::PidParameters;
use recording::joint::file::{of_section, to_table};
use recording::model_file::section::{KeyError, Section};
use toml::{Table, Value};
use wire::joint::{
    BoardJointControl, BoardJointParameters, JOINT_VERSION, JointCalibration, JointHello, JointSettings,
};
use wire::{Line, Refusal, Scaling, fingerprint};

use super::framed::{BackupFileError, JOINT, Problem, between, shorten};
use super::section::{self, shortest};

/// The oldest messages whose joints and limits are those of today.
const OLDEST: u16 = 7;
/// Keys of the gains, shares of the stiffness, and of the rates.
const PID: [&str; 5] = ["kp", "ki_per_s", "kd_s", "derivative_filter_s", "tracking_time_s"];
const RATES: [&str; 4] = ["turn_rad_per_s", "stiffen_nm_per_rad_s", "slew_bar_per_s", "period_s"];
/// Keys of the sensors' lines, in the order of [`JointCalibration`].
const LINES: [[&str; 2]; 3] = [
    ["pressure_a_zero_code", "pressure_a_codes_per_bar"],
    ["pressure_b_zero_code", "pressure_b_codes_per_bar"],
    ["angle_zero_code", "angle_codes_per_rad"],
];
/// Keys of the scalings that a board had: of the sensors, and of the commands.
const COMMAND: [&str; 2] = ["command_zero_code", "command_codes_per_bar"];

/// What a joint's board has been told.
#[derive(Clone, Debug, PartialEq)]
pub struct JointBackup {
    /// The joint with its controller; none on a board without one.
    pub control: Option<BoardJointParameters>,
    /// Limits of the plant, and lines of the sensors.
    pub settings: JointSettings,
}

/// The board that a backup is of; nothing of it is restored.
#[derive(Clone, Debug, PartialEq)]
pub struct JointOrigin {
    /// Version of its firmware.
    pub firmware: [u16; 3],
    /// Version of its messages.
    pub messages: u16,
    /// Of both pressures, the angle, and the commands.
    pub scalings: [Scaling; 4],
}

/// A backup with the board that it is of.
#[derive(Clone, Debug, PartialEq)]
pub struct JointBackupFile {
    /// Where it comes from.
    pub origin: JointOrigin,
    /// What is restored.
    pub backup: JointBackup,
}

impl JointBackup {
    /// What changes where `before` becomes this, a line each; none where both are the same.
    pub fn differences(&self, before: &Self) -> Vec<String> {
        between("", &of_backup(before), &of_backup(self))
    }

    /// Whether both are the same, bit by bit.
    pub fn is(&self, other: &Self) -> bool {
        let bits = |backup: &Self| fingerprint(&(&backup.control, &backup.settings));
        self == other && bits(self) == bits(other)
    }
}

impl JointOrigin {
    /// The board that has said so of itself.
    pub fn of(hello: &JointHello) -> Self {
        let JointHello { version, firmware, pressures: [a, b], angle, command, .. } = *hello;
        // What a code says counts; which codes are plausible is the firmware's own.
        let scalings = [a, b, angle, command].map(said);
        Self { firmware, messages: version, scalings }
    }

    /// In what this board differs from another, a line each.
    pub fn differences(&self, other: &Self) -> Vec<String> {
        between("", &of_origin(other), &of_origin(self))
    }
}

impl JointBackupFile {
    /// The file's text.
    pub fn to_toml(&self) -> String {
        let board = Table::from_iter([("board".to_owned(), Value::Table(of_origin(&self.origin)))]);
        JOINT.to_toml(&[board, of_backup(&self.backup)])
    }

    /// Reads a backup; `as_it_is`: also one whose checksum is that of another content.
    ///
    /// # Errors
    /// See [`super`]'s contract.
    pub fn read(file: &Path, as_it_is: bool) -> Result<Self, BackupFileError> {
        JOINT.read(file, as_it_is, content)
    }

    /// Reads the text of a backup; `file` is its name in messages.
    ///
    /// # Errors
    /// See [`super`]'s contract.
    pub fn parse(file: &Path, text: &str, as_it_is: bool) -> Result<Self, BackupFileError> {
        JOINT.parse((file, text), as_it_is, content)
    }
}

fn content(mut top: Section) -> Result<JointBackupFile, Problem> {
    let origin = origin(top.section("board")?)?;
    let protection = section::to_protection(top.section("protection")?)?.checked()?;
    let calibration = to_calibration(top.section("calibration")?)?;
    let control = match top.optional_section("controller")? {
        None => None,
        Some(controller) => Some(to_control(controller, top.section("model")?)?),
    };
    top.finish()?;
    if let Some(control) = &control {
        BoardJointControl::try_new(control).map_err(Refusal::from)?;
    }
    Ok(JointBackupFile {
        origin,
        backup: JointBackup { control, settings: JointSettings { protection, calibration } },
    })
}

/// What is restored, as it stands in the file.
fn of_backup(backup: &JointBackup) -> Table {
    let JointBackup { control, settings: JointSettings { protection, calibration } } = backup;
    let mut top = Table::new();
    top.insert("protection".into(), Value::Table(section::of_protection(protection)));
    let JointCalibration { pressures: [a, b], angle } = *calibration;
    let lines = [a, b, angle].into_iter().zip(LINES);
    let lines = lines.filter_map(|(line, keys)| {
        line.map(|Line { zero_code, codes_per_unit }| numbers(&keys, &[zero_code, codes_per_unit]))
    });
    top.insert("calibration".into(), Value::Table(lines.flatten().collect()));
    if let Some(control) = control {
        let BoardJointParameters { joint, pid, turn_rad_per_s, stiffen_per_s, slew_bar_per_s, period_s } =
            control;
        let PidParameters { kp, ki, kd, derivative_filter_s, tracking_time_s } = *pid;
        let mut controller = numbers(&PID, &[kp, ki, kd, derivative_filter_s, tracking_time_s]);
        controller.extend(numbers(&RATES, &[*turn_rad_per_s, *stiffen_per_s, *slew_bar_per_s, *period_s]));
        top.insert("controller".into(), Value::Table(controller));
        // The host has room for as many stops as a board.
        if let Ok(joint) = joint.convert() {
            let mut model = Value::Table(to_table(&joint));
            shorten(&mut model, |key| key.ends_with("_deg"));
            top.insert("model".into(), model);
        }
    }
    top
}

fn numbers(keys: &[&str], numbers: &[f32]) -> Table {
    keys.iter().zip(numbers).map(|(key, number)| ((*key).to_owned(), shortest(*number).into())).collect()
}

fn to_control(mut controller: Section, mut model: Section) -> Result<BoardJointParameters, Problem> {
    let joint = of_section(&mut model)?;
    model.finish()?;
    let mut number = |key| controller.number(key).map(|number| number as f32);
    let [kp, ki, kd, filter, tracking] = PID;
    let [turn, stiffen, slew, period] = RATES;
    let control = BoardJointParameters {
        joint: joint.convert()?,
        pid: PidParameters {
            kp: number(kp)?,
            ki: number(ki)?,
            kd: number(kd)?,
            derivative_filter_s: number(filter)?,
            tracking_time_s: number(tracking)?,
        },
        turn_rad_per_s: number(turn)?,
        stiffen_per_s: number(stiffen)?,
        slew_bar_per_s: number(slew)?,
        period_s: number(period)?,
    };
    controller.finish()?;
    Ok(control)
}

fn to_calibration(mut section: Section) -> Result<JointCalibration, KeyError> {
    let [a, b, angle] = LINES;
    let mut line = |keys| to_line(&mut section, keys, 1.0);
    let calibration = JointCalibration { pressures: [line(a)?, line(b)?], angle: line(angle)? };
    section.finish()?;
    Ok(calibration)
}

/// The line of a sensor, both of its numbers or none; `units`: of the file in one of the board.
pub(crate) fn to_line(section: &mut Section, keys: [&str; 2], units: f64) -> Result<Option<Line>, KeyError> {
    let [zero, gain] = keys;
    if !keys.iter().any(|key| section.has(key)) {
        return Ok(None);
    }
    let zero_code = section.number(zero)? as f32;
    Ok(Some(Line { zero_code, codes_per_unit: (units * section.number(gain)?) as f32 }))
}

/// What is said of the board, with the version that has to fit.
fn of_origin(origin: &JointOrigin) -> Table {
    let JointOrigin { firmware: [major, minor, patch], messages, scalings } = origin;
    let mut table = Table::new();
    table.insert("firmware".to_owned(), format!("{major}.{minor}.{patch}").into());
    table.insert("messages".to_owned(), i64::from(*messages).into());
    for (Scaling { zero_code, codes_per_unit, .. }, keys) in scalings.iter().zip(scaling_keys()) {
        table.extend(numbers(&keys, &[*zero_code, *codes_per_unit]));
    }
    table
}

fn scaling_keys() -> [[&'static str; 2]; 4] {
    let [a, b, angle] = LINES;
    [a, b, angle, COMMAND]
}

fn origin(mut board: Section) -> Result<JointOrigin, KeyError> {
    let messages = section::messages(&mut board, OLDEST..=JOINT_VERSION)?;
    let firmware = section::release(&mut board)?;
    let mut scalings = [said(Scaling { zero_code: 0.0, codes_per_unit: 1.0, code_min: 0, code_max: 0 }); 4];
    for (scaling, [zero, gain]) in scalings.iter_mut().zip(scaling_keys()) {
        scaling.zero_code = board.number(zero)? as f32;
        scaling.codes_per_unit = board.number(gain)? as f32;
    }
    board.finish()?;
    Ok(JointOrigin { firmware, messages, scalings })
}

/// A scaling without its bounds.
fn said(scaling: Scaling) -> Scaling {
    Scaling { code_min: 0, code_max: u16::MAX, ..scaling }
}
