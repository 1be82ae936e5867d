//! `mgpi pil --joint`: the firmware of two channels, in the emulator, in a loop with a plant.

use std::path::Path;

use recording::Choice;

use super::joint_run::Asked;
use crate::Error;
use crate::output::Outputs;
use board_client::emulator::Emulator;
use board_client::emulator::image::{self, Which};
use board_client::joint::log::log;
use board_client::joint::{Loop, parameters, settings};
use board_client::pil::PilError;
use board_client::pil::plant::{PlantProcess, Program};
use board_client::stop::Stop;

/// What a joint is run with.
pub struct Arguments<'a> {
    pub model: &'a Path,
    pub reference: &'a Path,
    pub choice: Choice,
    pub rate_hz: f64,
    /// Limits and calibration of the board.
    pub settings: Option<&'a Path>,
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
    let Arguments { model, reference, choice, rate_hz, plant, firmware, verbose, .. } = arguments;
    let asked = Asked::read(model, reference, choice, *rate_hz)?;
    let parameters = parameters(&asked.file.parameters, rate_hz.recip())?;
    let settings = arguments.settings.map(settings::read).transpose()?;
    let stop = Stop::on_signals();
    let mut process = PlantProcess::start(plant, &stop).map_err(PilError::from)?;
    let image = image::find_which(Which::Joint, *firmware)?;
    let mut board = Emulator::start_joint(&image, &stop).map_err(PilError::from)?;
    let mut joint = Loop::new((&parameters, settings.as_ref()), &mut board, &mut process, stop)?;
    let first = asked.wanted[0];
    joint.start(&first)?;
    joint.approach(&first)?;
    let samples = joint.follow(asked.wanted.iter().copied(), |_, _| ())?;
    if *verbose {
        eprintln!("the firmware's log:\n{}\nthe plant's messages:\n{}", board.log(), process.messages());
    }
    if let Some(file) = arguments.log {
        outputs.stage(file, log(&samples).as_bytes())?;
    }
    asked.finish(&samples, &[], (arguments.report, arguments.json), outputs)
}
