//! `mgpi deploy`: a model to a board.

use std::path::PathBuf;

use clap::Args;
use indicatif::{ProgressBar, ProgressStyle};
use wire::State;

use super::gains::Gains;
use super::port::PortArguments;
use crate::Error;
use crate::bus::BoardError;
use crate::bus::upload;
use crate::model_file::ModelFile;
use crate::pil::configuration;

/// Brings a model to a board: uploads, reads back, commits and verifies. Broken off, it changes nothing.
#[derive(Args, Debug)]
pub struct Arguments {
    /// The model, from `mgpi identify` or `diagnose`
    #[arg(value_name = "MODEL.toml")]
    model: PathBuf,
    #[command(flatten)]
    port: PortArguments,
    #[command(flatten)]
    gains: Gains,
    /// Highest command in bar [default: the model's]
    #[arg(long, value_name = "BAR")]
    max_bar: Option<f32>,
}

/// Deploys.
///
/// # Errors
/// The model is not for the board, or the board does not take it.
pub fn run(arguments: &Arguments) -> Result<(), Error> {
    let Arguments { model: file, port, gains, max_bar } = arguments;
    let model = ModelFile::read(file)?;
    let mut board = port.open()?;
    let mut configuration = configuration(file, &model, gains.pid(), 1.0 / board.identity().period_s)?;
    let tracking = &mut configuration.tracking;
    tracking.command_max = tracking.command_max.min(max_bar.unwrap_or(f32::INFINITY));
    if let (state, _) = board.state().map_err(BoardError::from)?
        && state.is_driven()
    {
        return Err(
            BoardError::State { state, needed: "drives the valve: mgpi status --stop ends that" }.into()
        );
    }
    let style = ProgressStyle::with_template("deploying {wide_bar} {bytes} of {total_bytes}");
    let bar = ProgressBar::new(0).with_style(style.unwrap_or_else(|_| ProgressStyle::default_bar()));
    let bytes = upload::deploy(&mut board, &configuration, &|done, all| {
        bar.set_length(all as u64);
        bar.set_position(done as u64);
    })?;
    bar.finish_and_clear();
    let state = board.settled()?;
    if state != State::Ready {
        return Err(BoardError::State { state, needed: "and does not get ready: see mgpi status" }.into());
    }
    say!("{} is installed: {bytes} bytes, read back and verified; the board is ready", file.display());
    Ok(())
}
