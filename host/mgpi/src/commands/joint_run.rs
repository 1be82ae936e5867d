//! What a run of a joint is asked for and leaves, in the emulator (`mgpi pil --joint`) and on a
//! board (`mgpi track --joint`).

use std::path::Path;

use board_client::joint::log::{figures, limited};
use board_client::joint::{JointSample, JointWanted};
use board_client::pil::reference::Reference;
use recording::Choice;
use recording::joint::file::JointFile;
use recording::unit::Unit;
use report::joint::tracked::to_html;
use serde_json::{Value, json};

use crate::Error;
use crate::output::Outputs;

/// The columns of a reference.
const ANGLE: &str = "reference_deg";
const STIFFNESS: &str = "stiffness_nm_per_rad";
/// And one that may be missing: a torque from outside that is known beforehand.
const TORQUE: &str = "torque_newton_metre";

/// What a joint is to do.
#[derive(Debug)]
pub struct Asked<'a> {
    model: &'a Path,
    reference: &'a Path,
    /// Its model.
    pub file: JointFile,
    /// At each tick; at least one.
    pub wanted: Vec<JointWanted>,
    /// Of the model's angles. Unit: degrees.
    range_deg: f64,
}

impl<'a> Asked<'a> {
    /// Reads a model and a reference, `rate_hz` ticks a second.
    ///
    /// # Errors
    /// A file is not what it should be, an angle is outside the model's range, or a stiffness is
    /// not above 0.
    pub fn read(model: &'a Path, reference: &'a Path, choice: &Choice, rate_hz: f64) -> Result<Self, Error> {
        let file = JointFile::read(model)?;
        let table = choice.table(reference)?;
        let of = |column| Reference::of(&table, column, choice.clone(), rate_hz);
        let (angle, stiffness) = (of(ANGLE)?, of(STIFFNESS)?);
        let torque = table.find(TORQUE)?.map(|_| of(TORQUE)).transpose()?;
        angle.say_notes(reference);
        let angles = file.parameters.angles;
        let (lowest, highest) = (angles.0.to_degrees(), angles.1.to_degrees());
        let refused = |column: &str, problem: String| {
            Err(Error::Usage(format!("{}, column {column}: {problem}", reference.display())))
        };
        for asked in [angle.range().0, angle.range().1] {
            if !(lowest..=highest).contains(&asked) {
                let model = model.display();
                return refused(
                    ANGLE,
                    format!(
                        "{asked} degrees is outside the angles of {model}, {lowest:.2} to {highest:.2} degrees"
                    ),
                );
            }
        }
        if stiffness.range().0 <= 0.0 {
            let asked = stiffness.range().0;
            return refused(STIFFNESS, format!("{asked} N m/rad is no stiffness, which is above 0"));
        }
        let torques = torque.iter().flat_map(|torque| torque.points(0.0)).chain(std::iter::repeat(0.0));
        let wanted = (angle.points(0.0).zip(stiffness.points(0.0)).zip(torques))
            .map(|((angle_deg, stiffness), torque_nm)| JointWanted { angle_deg, stiffness, torque_nm })
            .collect();
        Ok(Self { model, reference, file, wanted, range_deg: highest - lowest })
    }

    /// Stages the page and the figures of a run, as far as they are wanted, and puts all outputs
    /// into their places; then says the figures. `others`: figures beside those.
    ///
    /// # Errors
    /// An output cannot be written.
    pub fn finish(
        &self,
        samples: &[JointSample],
        others: &[(&str, Value)],
        (report, json_file): (Option<&Path>, Option<&Path>),
        mut outputs: Outputs,
    ) -> Result<(), Error> {
        let range_deg = self.range_deg;
        let figures = figures(samples);
        let [angle_limited, stiffness_limited] = limited(samples);
        if let Some(file) = report {
            let source = format!("Reference {}, model {}", self.reference.display(), self.model.display());
            outputs.stage(file, to_html(samples, range_deg, &source).as_bytes())?;
        }
        if let Some(file) = json_file {
            let mut value = json!({
                "ticks": samples.len(),
                "rmse_deg": figures.rmse,
                "mae_deg": figures.mae,
                "max_error_deg": figures.max_error,
                "range_deg": range_deg,
                "ticks_angle_limited": angle_limited,
                "ticks_stiffness_limited": stiffness_limited,
            });
            for (name, other) in others {
                value[*name] = other.clone();
            }
            outputs.stage(file, format!("{value:#}\n").as_bytes())?;
        }
        outputs.commit()?;
        let unit = Unit::of_column(ANGLE).unwrap_or(Unit::MM);
        say!("tracking      {}", figures.in_words_beside((range_deg, "range"), unit));
        if angle_limited + stiffness_limited > 0 {
            say!(
                "limited       the angle in {angle_limited}, the stiffness in {stiffness_limited} of {} ticks: the \
                 pressures' bounds or the slew rate do not allow it",
                samples.len()
            );
        }
        Ok(())
    }
}
