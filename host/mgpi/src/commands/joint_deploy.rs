//! `mgpi deploy --joint`: a joint's model, and its board's settings, to a board with two channels.

use std::path::Path;

use board_client::joint::deploy::deploy;
use board_client::joint::link::Address;
use board_client::joint::parameters;
use board_client::joint::run::PERIOD_S;
use board_client::joint::settings::changes;
use clap::Args;
use recording::joint::file::JointFile;
use wire::fingerprint;
use wire::joint::JointRequest;

use super::joint_board::BoardArguments;
use crate::Error;

/// A model that is off by more of its range of angles is not for a board: the bound of a muscle's
/// of its stroke. Unit: 1.
const WORST: f64 = 0.1;

/// What is asked of a joint beside what is of a muscle.
#[derive(Args, Debug)]
#[command(next_help_heading = "Joint")]
pub struct JointArguments {
    /// The model is that of two muscles at a joint, from `mgpi identify --joint`, for a board with
    /// two channels at its service link
    #[arg(long, conflicts_with_all = ["keep_gains", "Gains", "unit", "parity"])]
    joint: bool,
    #[command(flatten)]
    board: BoardArguments,
}

/// What any model is deployed with.
pub struct Arguments<'a> {
    pub joint: &'a JointArguments,
    pub model: &'a Path,
    pub address: Address,
    pub dry_run: bool,
    pub force: bool,
}

impl JointArguments {
    /// Whether it is a joint.
    pub fn is_meant(&self) -> bool {
        self.joint
    }
}

/// Deploys.
///
/// # Errors
/// A file is not what it should be, the model is off too far, or the board does not take or keep
/// what it is given.
pub fn run(arguments: Arguments<'_>) -> Result<(), Error> {
    let Arguments { joint, model: file, address, dry_run, force } = arguments;
    let model = JointFile::read(file)?;
    demand_worth(file, &model, force)?;
    let control = parameters(&model.parameters, PERIOD_S)?;
    let settings = joint.board.settings()?;
    let mut link = joint.board.open(&address)?;
    let installed = match link.installed()? {
        None => "the board has no joint yet",
        Some(installed) if installed == fingerprint(&control) => "the board has this joint already",
        Some(_) => "the board has another joint",
    };
    say!("{installed}; it gets\n  {:<24}that of {}", "joint", file.display());
    let before = link.settings(&JointRequest::Settings(None))?;
    let changes = settings.map(|settings| changes(&before, &settings)).unwrap_or_default();
    if changes.is_empty() {
        say!("  {:<24}stay", "limits and calibration");
    }
    changes.iter().for_each(|change| say!("  {change}"));
    if dry_run {
        say!("nothing has been changed (--dry-run)");
        return Ok(());
    }
    deploy(&mut link, &control, settings.as_ref())?;
    say!("{} is installed, and kept without power; both muscles are vented until a start", file.display());
    Ok(())
}

/// Says what a joint's model is worth. One that is off by too much is not for a board, unless the
/// user insists.
fn demand_worth(file: &Path, model: &JointFile, force: bool) -> Result<(), Error> {
    let (lowest, highest) = model.parameters.angles;
    let share = model.identification.heldout_rmse_deg / (highest - lowest).to_degrees();
    let worth = format!("off by {:.2} % of its range of angles on held-out samples", 100.0 * share);
    if share > WORST && !force {
        return Err(Error::Usage(format!(
            "{}: {worth}\n  A model that is off by more than 10 % is not deployed. --force deploys it all the same",
            file.display()
        )));
    }
    say!("{}: two muscles at a joint, {worth}", file.display());
    Ok(())
}
