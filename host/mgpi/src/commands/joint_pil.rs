//! `mgpi pil --joint`: the firmware of two channels, in the emulator, in a loop with a plant.

use std::f64::consts::PI;
use std::path::Path;

use recording::Choice;
use recording::joint::file::JointFile;
use recording::unit::Unit;
use serde_json::json;

use crate::Error;
use crate::output::Outputs;
use board_client::emulator::Emulator;
use board_client::emulator::image::{self, Which};
use board_client::joint::log::{figures, limited, log};
use board_client::joint::{JointWanted, Loop, parameters};
use board_client::pil::PilError;
use board_client::pil::plant::{PlantProcess, Program};
use board_client::pil::reference::Reference;
use board_client::stop::Stop;
use report::joint::tracked::to_html;

/// The columns of a reference.
const ANGLE: &str = "reference_deg";
const STIFFNESS: &str = "stiffness_nm_per_rad";

/// What a joint is run with.
pub struct Arguments<'a> {
    pub model: &'a Path,
    pub reference: &'a Path,
    pub choice: Choice,
    pub rate_hz: f64,
    pub plant: Program,
    pub firmware: Option<&'a Path>,
    pub verbose: bool,
    pub log: Option<&'a Path>,
    pub report: Option<&'a Path>,
    pub json: Option<&'a Path>,
}

/// Runs the firmware of a joint, in the emulator, with a plant.
///
/// # Errors
/// A file is not what it should be, firmware or plant do not do their work, the joint is not the
/// model's, an output cannot be written, or the user interrupts.
pub fn run(arguments: &Arguments<'_>, mut outputs: Outputs) -> Result<(), Error> {
    let Arguments {
        model,
        reference,
        choice,
        rate_hz,
        plant,
        firmware,
        verbose,
        log: log_file,
        report,
        json,
    } = arguments;
    let file = JointFile::read(model)?;
    let table = choice.table(reference)?;
    let of = |column| Reference::of(&table, column, choice.clone(), *rate_hz);
    let (angle, stiffness) = (of(ANGLE)?, of(STIFFNESS)?);
    angle.say_notes(reference);
    let degrees = |angle: f64| angle * 180.0 / PI;
    let (lowest, highest) = (degrees(file.parameters.angles.0), degrees(file.parameters.angles.1));
    for asked in [angle.range().0, angle.range().1] {
        if !(lowest..=highest).contains(&asked) {
            return Err(Error::Usage(format!(
                "{}, column {ANGLE}: {asked} degrees is outside the angles of {}, {lowest:.2} to {highest:.2} degrees",
                reference.display(),
                model.display()
            )));
        }
    }
    let parameters = parameters(&file.parameters, rate_hz.recip())?;
    let stop = Stop::on_signals();
    let mut process = PlantProcess::start(plant, &stop).map_err(PilError::from)?;
    let image = image::find_which(Which::Joint, *firmware)?;
    let mut board = Emulator::start_joint(&image, &stop).map_err(PilError::from)?;
    let mut joint = Loop::new(&parameters, &mut board, &mut process, stop)?;
    let wanted: Vec<JointWanted> = (angle.points(0.0).zip(stiffness.points(0.0)))
        .map(|(angle_deg, stiffness)| JointWanted { angle_deg, stiffness })
        .collect();
    joint.start(wanted[0].stiffness)?;
    joint.approach(&wanted[0])?;
    let samples = joint.follow(wanted.into_iter(), |_, _| ())?;
    if *verbose {
        eprintln!("the firmware's log:\n{}\nthe plant's messages:\n{}", board.log(), process.messages());
    }
    let range_deg = highest - lowest;
    let figures = figures(&samples);
    let [angle_limited, stiffness_limited] = limited(&samples);
    if let Some(file) = log_file {
        outputs.stage(file, log(&samples).as_bytes())?;
    }
    if let Some(file) = report {
        let source = format!("Reference {}, model {}", reference.display(), model.display());
        outputs.stage(file, to_html(&samples, range_deg, &source).as_bytes())?;
    }
    if let Some(file) = json {
        let value = json!({
            "ticks": samples.len(),
            "rmse_deg": figures.rmse,
            "mae_deg": figures.mae,
            "max_error_deg": figures.max_error,
            "range_deg": range_deg,
            "ticks_angle_limited": angle_limited,
            "ticks_stiffness_limited": stiffness_limited,
        });
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
