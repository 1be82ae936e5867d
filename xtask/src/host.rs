//! What runs on the host: the workbench and the rig, and the tests.

use std::os::unix::process::CommandExt;
use std::path::PathBuf;
use std::process::Command;

use anyhow::{Context, Result};

use crate::{firmware, run, setup};

/// The environment variable by which tests and the workbench find the firmware.
const FIRMWARE_VARIABLE: &str = "MGPI_FIRMWARE";

/// The one by which tests find the Python with Modbus clients.
const BUS_PYTHON_VARIABLE: &str = "MGPI_BUS_PYTHON";

/// Builds `mgpi` and `rig`, as the tests have them: optimised, and built once for all.
///
/// # Errors
/// When cargo fails.
pub fn build() -> Result<()> {
    run::step("workbench and rig", || {
        run::succeed(&mut run::cargo(&["build", "--package", "workbench", "--package", "rig", "--bins"]))
    })
}

/// Where `mgpi` and `rig` are built.
fn programs() -> PathBuf {
    run::target_dir().join("debug")
}

/// The command `mgpi` in the workspace, with the firmware that was just built.
pub fn mgpi() -> Command {
    let mut command = Command::new(programs().join("mgpi"));
    command.current_dir(run::root()).env(FIRMWARE_VARIABLE, firmware::emulated_elf());
    command
}

/// The command `rig` in the workspace.
pub fn rig() -> Command {
    let mut command = Command::new(programs().join("rig"));
    command.current_dir(run::root());
    command
}

/// Gives a command `mgpi` and `rig` on its search path, and the firmware that was just built.
pub fn with_programs(command: &mut Command) -> &mut Command {
    let mut path = programs().into_os_string();
    for directory in std::env::var_os("PATH").iter() {
        path.push(":");
        path.push(directory);
    }
    command.env("PATH", path).env(FIRMWARE_VARIABLE, firmware::emulated_elf())
}

/// Plays the game of hidden causes with the workbench as it stands.
///
/// # Errors
/// When cargo fails, or the verdicts stay under their bounds.
pub fn game(arguments: &[String]) -> Result<()> {
    // The game starts the `mgpi` that stands beside it.
    run::succeed(&mut run::cargo(&["build", "--package", "workbench", "--bin", "mgpi"]))?;
    let game = ["run", "--package", "host-tests", "--bin", "game", "--"];
    run::succeed(run::cargo(&game).args(arguments))
}

/// Runs every test of the workspace; those that need the emulator find the firmware.
///
/// # Errors
/// When a test fails.
pub fn test() -> Result<()> {
    // The plant program has to stand beside `mgpi`; cargo builds only the programs of the package under test.
    run::step("programs under test", || run::succeed(&mut run::cargo(&["build", "--workspace", "--bins"])))?;
    run::step("tests", || {
        let mut test = run::cargo(&["test", "--workspace"]);
        test.env(FIRMWARE_VARIABLE, firmware::emulated_elf());
        if setup::bus_python().exists() {
            test.env(BUS_PYTHON_VARIABLE, setup::bus_python());
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
