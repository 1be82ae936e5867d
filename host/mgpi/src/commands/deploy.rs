//! `mgpi deploy`: a model to a board.

use std::path::PathBuf;

use clap::Args;
use indicatif::{ProgressBar, ProgressStyle};
use wire::registers::Id;
use wire::{Configuration, State};

use super::board_model;
use super::gains::Gains;
use super::joint_deploy::{self, JointArguments};
use super::port::PortArguments;
use super::tuned;
use crate::Error;
use board_client::bus::settings::settle;
use board_client::bus::{Board, BoardError, upload};
use board_client::pil::configuration;

/// Brings a model to a board: uploads, reads back, commits and verifies. Broken off, it changes
/// nothing.
///
/// Gains, filter and limits that the board has stay, unless an option says otherwise, or the
/// model's file has gains that were tuned for it; what changes is listed first. The limits of the
/// plant (protection) always stay; those of a joint's board are given by `--settings`.
#[derive(Args, Debug)]
pub struct Arguments {
    /// The model, from `mgpi identify` or `diagnose`; of a joint from `mgpi identify --joint`
    #[arg(value_name = "MODEL.toml")]
    model: PathBuf,
    /// List what would change, and change nothing
    #[arg(long)]
    dry_run: bool,
    /// Gains that the board has stay, though the model's file has tuned ones
    #[arg(long)]
    keep_gains: bool,
    /// Also deploy a model that is off by more than 10 % of stroke, or of a joint's range of angles
    #[arg(long)]
    force: bool,
    #[command(flatten)]
    port: PortArguments,
    #[command(flatten)]
    gains: Gains,
    #[command(flatten)]
    joint: JointArguments,
}

/// Deploys.
///
/// # Errors
/// The model is not for the board, or is off too far; an option is outside its limits; the board
/// does not take it.
pub fn run(arguments: &Arguments) -> Result<(), Error> {
    let Arguments { model: file, port, gains, dry_run, keep_gains, force, joint } = arguments;
    if joint.is_meant() {
        let (address, dry_run, force) = (port.link(), *dry_run, *force);
        return joint_deploy::run(joint_deploy::Arguments { joint, model: file, address, dry_run, force });
    }
    let model = board_model::read(file)?;
    board_model::demand_worth(file, &model, *force)?;
    let mut board = port.open()?;
    let period_s = board.identity().period_s;
    let mut configuration = configuration(file, &model, 1.0 / period_s)?;
    demand_rest(&mut board)?;
    let installed = installed(&mut board)?;
    let is_tuned = tuned::is_tuned(file, &model, period_s) && !(*keep_gains && installed.is_some());
    let asked = gains.asked();
    list(&mut configuration, installed.as_ref(), &asked, is_tuned)?;
    tuned::warn(file, &model, &configuration.tracking, &asked);
    if *dry_run {
        say!("nothing has been changed (--dry-run)");
        return Ok(());
    }
    let bytes = with_progress("deploying", |moved| upload::deploy(&mut board, &configuration, moved))?;
    ready(&mut board)?;
    say!("{} is installed: {bytes} bytes, read back and verified; the board is ready", file.display());
    Ok(())
}

/// What the board has; none on one without a model.
fn installed(board: &mut Board) -> Result<Option<Configuration>, BoardError> {
    match upload::fetch(board) {
        Err(BoardError::NoConfiguration) => Ok(None),
        fetched => fetched.map(Some),
    }
}

/// Says what the board gets, beside what it has, and puts it into the configuration.
fn list(
    configuration: &mut Configuration,
    installed: Option<&Configuration>,
    asked: &[(Id, f32)],
    is_tuned: bool,
) -> Result<(), BoardError> {
    let before = installed.map(|installed| &installed.tracking);
    let settings = settle(&mut configuration.tracking, before, asked, is_tuned)?;
    let model = board_model::words(&configuration.tracking);
    match before {
        None => say!("the board has no model yet; it gets\n  {:<24}{model}", "model"),
        Some(before) if before.model == configuration.tracking.model => {
            let same = if board_model::words(before) == model { "stays" } else { "with other extensions" };
            say!("the board has this model already; it gets\n  {:<24}{model}, {same}", "model");
        }
        Some(before) => {
            say!(
                "the board has a model already; it gets\n  {:<24}{} -> {model}",
                "model",
                board_model::words(before)
            );
        }
    }
    settings.iter().for_each(|setting| say!("  {setting}"));
    say!("  {:<24}stays", "protection");
    Ok(())
}

/// The board's valve is not driven.
///
/// # Errors
/// It is, or there is no answer.
pub fn demand_rest(board: &mut Board) -> Result<(), BoardError> {
    let (state, _) = board.state()?;
    if state.is_driven() {
        return Err(BoardError::State { state, needed: "drives the valve: mgpi status --stop ends that" });
    }
    Ok(())
}

/// The board has tested itself, and is ready.
///
/// # Errors
/// It does not get ready, or there is no answer.
pub fn ready(board: &mut Board) -> Result<(), BoardError> {
    match board.settled()? {
        State::Ready => Ok(()),
        state => Err(BoardError::State { state, needed: "and does not get ready: see mgpi status" }),
    }
}

/// Does the work under a bar; the work tells what it is given how many bytes of how many are done.
pub fn with_progress<T>(doing: &'static str, work: impl FnOnce(&dyn Fn(usize, usize)) -> T) -> T {
    let style = ProgressStyle::with_template("{prefix} {wide_bar} {bytes} of {total_bytes}");
    let bar = ProgressBar::new(0)
        .with_prefix(doing)
        .with_style(style.unwrap_or_else(|_| ProgressStyle::default_bar()));
    let done = work(&|done, all| {
        bar.set_length(all as u64);
        bar.set_position(done as u64);
    });
    bar.finish_and_clear();
    done
}
