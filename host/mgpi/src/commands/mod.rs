//! The commands of `mgpi`, one a file: arguments, and what is done with them.

pub mod adapted;
#[cfg(unix)]
mod background;
pub mod backup;
pub mod batch;
mod board_file;
mod board_model;
pub mod bring_up;
pub mod bus;
pub mod calibrate;
pub mod capture;
pub mod compare;
pub mod completions;
pub mod deploy;
pub mod diagnose;
mod diagnosed_summary;
mod duration_bar;
#[cfg(unix)]
pub mod emulate;
pub mod export;
#[cfg(unix)]
pub mod fleet;
mod gains;
pub mod gateway;
pub mod identify;
pub mod import;
mod instructions;
mod joint_backup;
mod joint_board;
mod joint_capture;
mod joint_deploy;
mod joint_identify;
#[cfg(unix)]
mod joint_pil;
mod joint_run;
mod joint_slack;
mod joint_track;
mod kept;
mod learnt;
pub mod man;
mod number;
#[cfg(unix)]
pub mod pil;
pub mod plan;
#[cfg(unix)]
mod plant;
mod port;
mod reading;
mod recorded;
pub mod report;
pub mod restore;
pub mod rig;
pub mod scan;
mod search;
mod show;
pub mod simulate;
pub mod status;
pub mod track;
pub mod tune;
mod tuned;
pub mod update;
pub mod watch;

use ::rig::command::Command as Rig;
use clap::{Parser, Subcommand};

use crate::Error;

/// Models, identifies and controls pneumatic artificial muscles with hysteresis.
#[derive(Debug, Parser)]
#[command(name = "mgpi", version)]
pub struct CommandLine {
    #[command(subcommand)]
    command: Command,
}

#[derive(Debug, Subcommand)]
enum Command {
    Identify(identify::Arguments),
    Compare(compare::Arguments),
    Import(import::Arguments),
    Batch(batch::Arguments),
    Diagnose(diagnose::Arguments),
    Simulate(simulate::Arguments),
    Export(export::Arguments),
    Tune(tune::Arguments),
    Report(report::Arguments),
    #[cfg(unix)]
    Pil(Box<pil::Arguments>),
    Plan(plan::Arguments),
    #[cfg(unix)]
    Emulate(emulate::Arguments),
    #[cfg(unix)]
    Fleet(fleet::Arguments),
    Capture(capture::Arguments),
    Deploy(deploy::Arguments),
    Backup(backup::Arguments),
    Restore(restore::Arguments),
    Track(track::Arguments),
    Adapted(adapted::Arguments),
    Status(status::Arguments),
    Bus(bus::Arguments),
    Scan(scan::Arguments),
    Calibrate(calibrate::Arguments),
    Update(update::Arguments),
    BringUp(bring_up::Arguments),
    Watch(watch::Arguments),
    Gateway(gateway::Arguments),
    /// The simulated muscle: recordings, references and a plant to try everything without hardware
    #[command(subcommand)]
    Rig(Box<Rig>),
    Completions(completions::Arguments),
    Man(man::Arguments),
}

impl CommandLine {
    /// Does what the command line asks for.
    ///
    /// # Errors
    /// Whatever keeps the command from its work; then no output has been written.
    pub fn run(self) -> Result<(), Error> {
        match self.command {
            Command::Identify(arguments) => identify::run(&arguments),
            Command::Batch(arguments) => batch::run(&arguments),
            Command::Import(arguments) => import::run(&arguments),
            Command::Compare(arguments) => compare::run(&arguments),
            Command::Diagnose(arguments) => diagnose::run(&arguments),
            Command::Simulate(arguments) => simulate::run(&arguments),
            Command::Export(arguments) => export::run(&arguments),
            Command::Tune(arguments) => tune::run(&arguments),
            Command::Report(arguments) => report::run(&arguments),
            #[cfg(unix)]
            Command::Pil(arguments) => pil::run(&arguments),
            Command::Plan(arguments) => plan::run(&arguments),
            #[cfg(unix)]
            Command::Emulate(arguments) => emulate::run(&arguments),
            #[cfg(unix)]
            Command::Fleet(arguments) => fleet::run(&arguments),
            Command::Capture(arguments) => capture::run(&arguments),
            Command::Deploy(arguments) => deploy::run(&arguments),
            Command::Backup(arguments) => backup::run(&arguments),
            Command::Restore(arguments) => restore::run(&arguments),
            Command::Track(arguments) => track::run(&arguments),
            Command::Adapted(arguments) => adapted::run(&arguments),
            Command::Status(arguments) => status::run(&arguments),
            Command::Bus(arguments) => bus::run(&arguments),
            Command::Scan(arguments) => scan::run(&arguments),
            Command::Calibrate(arguments) => calibrate::run(&arguments),
            Command::Update(arguments) => update::run(&arguments),
            Command::BringUp(arguments) => bring_up::run(&arguments),
            Command::Watch(arguments) => watch::run(&arguments),
            Command::Gateway(arguments) => gateway::run(&arguments),
            Command::Rig(command) => rig::run(&command),
            Command::Completions(arguments) => completions::run(&arguments),
            Command::Man(arguments) => man::run(&arguments),
        }
    }
}
