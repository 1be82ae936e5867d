//! What runs on the host: `mgpi` and the rig, and the tests.

use std::os::unix::process::CommandExt;
use std::path::{Path, PathBuf};
use std::process::Command;

use anyhow::{Context, Result};

use crate::{firmware, run, setup};

/// The environment variable by which tests and `mgpi` find the firmware.
const FIRMWARE_VARIABLE: &str = "MGPI_FIRMWARE";

/// Those by which tests find a Python with Modbus clients, one with the chip's processor, and one
/// with clients of Zenoh and ROS 2.
const PYTHON_VARIABLES: [(&str, setup::Python); 3] = [
    ("MGPI_BUS_PYTHON", setup::BUS_PYTHON),
    ("MGPI_CHIP_PYTHON", setup::CHIP_PYTHON),
    ("MGPI_NETWORK_PYTHON", setup::NETWORK_PYTHON),
];

/// The packages that have tests. Those of the Python package are run by Python; with it the others'
/// macros would be built with more features, and everything a second time.
const TESTED: [&str; 3] = ["--workspace", "--exclude", "mgpi-python"];

/// Builds `mgpi` and the library of units of FMI, as the tests have them: optimised, and built once
/// for all.
///
/// # Errors
/// When cargo fails.
pub fn build() -> Result<()> {
    run::step("mgpi", || run::succeed(&mut run::cargo(&["build", "--package", "mgpi", "--package", "fmu"])))
}

/// The command `mgpi` in the workspace, with the firmware that was just built.
pub fn mgpi() -> Command {
    let mut command = Command::new(run::target_dir().join("debug/mgpi"));
    command.current_dir(run::root()).env(FIRMWARE_VARIABLE, firmware::emulated_elf());
    command
}

/// How optimised a program is built.
#[derive(Clone, Copy, PartialEq)]
pub enum Build {
    /// As users have it.
    Release,
    /// As the tests have it, which is built already.
    Tests,
}

/// Installs `mgpi`, with the firmware that was just built in it, in the folder `bin` of `root` or
/// where cargo installs.
///
/// # Errors
/// When cargo fails.
pub fn install(root: Option<&Path>, build: Build) -> Result<()> {
    let mut cargo = run::cargo(&["install", "--path", "host/mgpi", "--locked", "--force"]);
    if build == Build::Tests {
        cargo.arg("--debug");
    }
    if let Some(root) = root {
        cargo.arg("--root").arg(std::path::absolute(root)?);
    }
    run::step("install mgpi", || run::succeed(&mut cargo))
}

/// Gives a command the programs of a folder and of the system, and nothing that knows this
/// workspace.
pub fn with_installed<'a>(command: &'a mut Command, folder: &Path) -> Result<&'a mut Command> {
    let path = std::env::var_os("PATH").unwrap_or_default();
    let has_ours = |directory: &PathBuf| directory.join("mgpi").exists() || directory.join("rig").exists();
    let others = std::env::split_paths(&path).filter(|directory| !has_ours(directory));
    let path = std::env::join_paths(std::iter::once(folder.to_owned()).chain(others))?;
    Ok(command.env("PATH", path).env_remove(FIRMWARE_VARIABLE))
}

/// Plays the game of hidden causes with the finder as it stands.
///
/// # Errors
/// When cargo fails, or the verdicts stay under their bounds.
pub fn game(arguments: &[String]) -> Result<()> {
    // The game starts the `mgpi` that stands beside it. Of all packages, so that what the tests
    // have built is built: one alone would have its dependencies with fewer features.
    run::succeed(run::cargo(&["build", "--bin", "mgpi", "--bin", "game"]).args(TESTED))?;
    let game = run::target_dir().join("debug/game");
    run::succeed(Command::new(game).current_dir(run::root()).args(arguments))
}

/// Runs every test of the workspace; those that need the emulator find the firmware.
///
/// # Errors
/// When a test fails.
pub fn test() -> Result<()> {
    // Tests of other packages start `mgpi`; cargo builds only the programs of the package under
    // test.
    run::step("programs under test", || run::succeed(run::cargo(&["build", "--bins"]).args(TESTED)))?;
    run::step("tests", || {
        let mut test = run::cargo(&["test"]);
        test.args(TESTED).env(FIRMWARE_VARIABLE, firmware::emulated_elf());
        for (variable, python) in &PYTHON_VARIABLES {
            if python.program().exists() {
                test.env(variable, python.program());
            }
        }
        run::succeed(&mut test)
    })
}

/// Runs the firmware in the emulator until the user ends it.
///
/// # Errors
/// When it cannot be built or started.
pub fn emulate(arguments: &[String]) -> Result<()> {
    build()?;
    // In place of this program, so that Ctrl-C has one addressee.
    Err(mgpi().arg("emulate").args(arguments).exec()).context("cannot run mgpi")
}
