//! The model file of a joint, `joint.toml`, format 2. Keys carry their units, angles are degrees in
//! it; reading is as strict as that of the model file of one muscle.

use std::path::{Path, PathBuf};

use model_core::joint::PullParameters;
use model_core::{List, ParameterError};
use thiserror::Error;
use toml::{Table, Value};

use super::keys::{ARM, FRICTION, KNEE, MUSCLES, PASSIVE, REST, SLIP, VISCOSITY, names};
use super::{HostJoint, HostJointParameters, STOPS};
use crate::model_file::section::{KeyError, Section};
use crate::model_file::values::{count, list, table};
use crate::{Source, TOOL, input};

/// The format that this version writes and reads.
pub const FORMAT: usize = 2;
/// What the key `kind` says.
const KIND: &str = "joint";
const ANGLES: [&str; 2] = ["angle_min_deg", "angle_max_deg"];
const LOWEST: [&str; 2] = ["lowest_at_angle_min_bar", "lowest_at_angle_max_bar"];
const HIGHEST: [&str; 2] = ["highest_at_angle_min_bar", "highest_at_angle_max_bar"];

/// A joint with what is known about it.
#[derive(Clone, Debug)]
pub struct JointFile {
    /// The raw parameters.
    pub parameters: HostJointParameters,
    /// The joint of these.
    pub joint: HostJoint,
    /// Where they come from.
    pub identification: JointIdentification,
}

/// What a joint was identified from, and how well.
#[derive(Clone, Debug, PartialEq)]
pub struct JointIdentification {
    /// What wrote the file.
    pub tool: String,
    /// The recording.
    pub recording: Source,
    /// Rows that count.
    pub scored_rows: usize,
    /// Root mean square of the simulated less the measured angle. Unit: degrees.
    pub rmse_deg: f64,
    /// The same where a model of the other rows answers, in blocks all through the recording. Unit:
    /// degrees.
    pub heldout_rmse_deg: f64,
}

/// What is wrong with the model file of a joint.
#[derive(Debug, Error)]
#[error("{}{problem}", input::name(file))]
pub struct JointFileError {
    file: PathBuf,
    problem: Problem,
}

#[derive(Debug, Error)]
enum Problem {
    #[error(": cannot be read: {0}")]
    Unreadable(#[from] std::io::Error),
    #[error(": not a TOML file, or cut off: {0}")]
    Syntax(String),
    #[error(": {0}")]
    Key(#[from] KeyError),
    #[error(
        ": format {0} is of another version; this one reads format {FORMAT}: identify the recording again"
    )]
    Format(usize),
    #[error(": no joint can be made of it: {0}")]
    Parameters(#[from] ParameterError),
}

impl JointFile {
    /// A file of an identified joint.
    ///
    /// # Errors
    /// The parameters are not those of a joint.
    pub fn new(
        parameters: HostJointParameters,
        recording: Source,
        scored_rows: usize,
        (rmse_deg, heldout_rmse_deg): (f64, f64),
    ) -> Result<Self, ParameterError> {
        let tool = TOOL.to_owned();
        let identification = JointIdentification { tool, recording, scored_rows, rmse_deg, heldout_rmse_deg };
        Ok(Self { joint: HostJoint::try_new(&parameters)?, parameters, identification })
    }

    /// Reads a file.
    ///
    /// # Errors
    /// It cannot be read, or is not what it should be.
    pub fn read(path: &Path) -> Result<Self, JointFileError> {
        let read = || parse(&input::text(path)?);
        read().map_err(|problem| JointFileError { file: path.to_owned(), problem })
    }

    /// Its text.
    pub fn to_toml(&self) -> String {
        let mut top = Table::new();
        top.insert("format".into(), count(FORMAT));
        top.insert("kind".into(), KIND.into());
        top.extend(to_table(&self.parameters));
        let JointIdentification { tool, recording, scored_rows, rmse_deg, heldout_rmse_deg } =
            &self.identification;
        top.insert(
            "identification".into(),
            table([
                ("recording", recording.file.as_str().into()),
                ("sha256", recording.sha256.as_str().into()),
                ("tool", tool.as_str().into()),
                ("scored_rows", count(*scored_rows)),
                ("rmse_deg", (*rmse_deg).into()),
                ("heldout_rmse_deg", (*heldout_rmse_deg).into()),
            ]),
        );
        top.to_string()
    }
}

/// The parameters of a joint as tables, as they stand in its model file: from an angle, however it
/// is rounded to single precision, the same bits come back.
pub fn to_table(parameters: &HostJointParameters) -> Table {
    let HostJointParameters { muscles, passive, viscosity, reaches, swing, angles } = parameters;
    let mut tables = Table::new();
    let [min, max] = ANGLES;
    tables.insert(
        "validity".into(),
        table([(min, angles.0.to_degrees().into()), (max, angles.1.to_degrees().into())]),
    );
    let reaches: Vec<f64> = reaches.iter().map(|reach| reach.to_degrees()).collect();
    tables.insert(
        "stops".into(),
        table([("reaches_deg", list(&reaches)), ("swing_deg", swing.to_degrees().into())]),
    );
    let mut rest = keyed(&names(PASSIVE), passive);
    rest.insert(VISCOSITY.name.into(), (*viscosity).into());
    tables.insert(REST.into(), Value::Table(rest));
    for (name, muscle) in MUSCLES.iter().zip(muscles) {
        tables.insert((*name).into(), Value::Table(written(muscle)));
    }
    tables
}

/// Takes the tables of [`to_table`] out of a section.
///
/// # Errors
/// A key is missing, unknown or of another kind.
pub fn of_section(top: &mut Section) -> Result<HostJointParameters, KeyError> {
    let mut validity = top.section("validity")?;
    let [low, high] = numbers(&mut validity, ANGLES)?.map(radians);
    validity.finish()?;
    let mut stops = top.section("stops")?;
    let reaches = listed(&mut stops, "reaches_deg")?.iter().copied().map(radians).collect();
    let swing = radians(stops.number("swing_deg")?);
    stops.finish()?;
    let mut rest = top.section(REST)?;
    let (passive, viscosity) = (numbers(&mut rest, names(PASSIVE))?, rest.number(VISCOSITY.name)?);
    rest.finish()?;
    let [a, b] = MUSCLES;
    let muscles = [muscle(top, a)?, muscle(top, b)?];
    Ok(HostJointParameters { muscles, passive, viscosity, reaches, swing, angles: (low, high) })
}

fn keyed(keys: &[&str], values: &[f64]) -> Table {
    keys.iter().zip(values).map(|(key, value)| ((*key).to_owned(), (*value).into())).collect()
}

fn written(muscle: &PullParameters<f64, STOPS>) -> Table {
    let mut section = keyed(&names(ARM), &muscle.arm);
    section.insert(KNEE.name.into(), muscle.knee.into());
    section.insert(FRICTION.name.into(), list(&muscle.friction));
    section.extend(keyed(&names(SLIP), &muscle.slip));
    section.extend(keyed(&LOWEST, &muscle.lowest));
    section.extend(keyed(&HIGHEST, &muscle.highest));
    section.insert("valve_lag_s".into(), muscle.valve_lag_s.into());
    section
}

fn parse(text: &str) -> Result<JointFile, Problem> {
    let table =
        text.parse::<Table>().map_err(|error| Problem::Syntax(error.message().replace('\n', ", ")))?;
    let mut top = Section::top(table);
    let kind = top.text("kind")?;
    if kind != KIND {
        return Err(top.error("kind", &format!("\"{kind}\" is no joint")).into());
    }
    let format = top.count("format")?;
    if format != FORMAT {
        return Err(Problem::Format(format));
    }
    let parameters = of_section(&mut top)?;
    let mut section = top.section("identification")?;
    let identification = JointIdentification {
        recording: Source { file: section.text("recording")?, sha256: section.text("sha256")? },
        tool: section.text("tool")?,
        scored_rows: section.count("scored_rows")?,
        rmse_deg: section.number("rmse_deg")?,
        heldout_rmse_deg: section.number("heldout_rmse_deg")?,
    };
    section.finish()?;
    top.finish()?;
    Ok(JointFile { joint: HostJoint::try_new(&parameters)?, parameters, identification })
}

fn muscle(top: &mut Section, name: &str) -> Result<PullParameters<f64, STOPS>, KeyError> {
    let mut section = top.section(name)?;
    let muscle = PullParameters {
        arm: numbers(&mut section, names(ARM))?,
        knee: section.number(KNEE.name)?,
        friction: listed(&mut section, FRICTION.name)?,
        slip: numbers(&mut section, names(SLIP))?,
        lowest: numbers(&mut section, LOWEST)?,
        highest: numbers(&mut section, HIGHEST)?,
        valve_lag_s: section.number("valve_lag_s")?,
    };
    section.finish()?;
    Ok(muscle)
}

/// Radians, by the number that [`f64::to_degrees`] multiplies by: a file that is read and written
/// again is the same, which with the reciprocal of [`f64::to_radians`] it is not.
fn radians(degrees: f64) -> f64 {
    degrees / 1f64.to_degrees()
}

fn numbers<const N: usize>(section: &mut Section, keys: [&str; N]) -> Result<[f64; N], KeyError> {
    let mut numbers = [0.0; N];
    for (number, key) in numbers.iter_mut().zip(keys) {
        *number = section.number(key)?;
    }
    Ok(numbers)
}

fn listed(section: &mut Section, key: &str) -> Result<List<f64, STOPS>, KeyError> {
    let numbers = section.numbers(key)?;
    let too_many = || section.error(key, &format!("{} numbers, at most {STOPS} are known", numbers.len()));
    List::try_from_iter(numbers.iter().copied()).ok_or_else(too_many)
}
