//! The commands of the bench against a board on a desk, in a directory of their own.

use std::path::{Path, PathBuf};
use std::process::{Command, Output};

use serde_json::Value;
use tempfile::TempDir;
use wire::Protection;
use wire::image::Linked;
use wire::registers::UNIT;

use crate::desk::Desk;
use fleet::board::Board;
use fleet::line::Way;

/// How much faster time passes there.
const PACE: f64 = 5.0;

/// A board on a desk, with a directory for `mgpi`, which stands beside the tests' programs.
#[derive(Debug)]
pub struct DeskBench {
    desk: Desk,
    directory: TempDir,
}

impl DeskBench {
    /// A board whose bus is sound, and the paper's model as `paper.toml`.
    pub fn new() -> Self {
        Self::disturbed(|_, bytes| bytes)
    }

    /// The same, on a bus whose bytes `disturb` may change.
    ///
    /// # Panics
    /// There is no directory for it, or no model.
    pub fn disturbed(disturb: impl FnMut(Way, Vec<u8>) -> Vec<u8> + Send + 'static) -> Self {
        Self::at(Desk::new(PACE, disturb))
    }

    /// Boards of these numbers on one line.
    ///
    /// # Panics
    /// There is no directory for it, or no model.
    pub fn line(units: &[u8]) -> Self {
        Self::at(Desk::line(PACE, units, |_, bytes| bytes))
    }

    /// A board that takes images; the one that it runs has this head.
    ///
    /// # Panics
    /// There is no directory for it, or no model.
    pub fn with_images(
        linked: Linked,
        disturb: impl FnMut(Way, Vec<u8>) -> Vec<u8> + Send + 'static,
    ) -> Self {
        Self::at(Desk::of(
            PACE,
            move || vec![Board::of_number(UNIT, Protection::SIMULATED).with_images(&linked)],
            disturb,
        ))
    }

    fn at(desk: Desk) -> Self {
        let directory = tempfile::tempdir().expect("a temporary directory");
        let model = concat!(env!("CARGO_MANIFEST_DIR"), "/../examples/paper-tables-1-2.toml");
        std::fs::copy(model, directory.path().join("paper.toml")).expect("the paper's model");
        Self { desk, directory }
    }

    /// The directory in which commands run.
    pub fn directory(&self) -> &Path {
        self.directory.path()
    }

    /// A command with the port behind it.
    pub fn command(&self, arguments: &str) -> Command {
        let mut command = Command::new(mgpi());
        command.args(arguments.split_whitespace()).arg("--port").arg(self.desk.port());
        command.current_dir(self.directory.path());
        command
    }

    /// Runs a command.
    ///
    /// # Panics
    /// It does not run.
    pub fn run(&self, arguments: &str) -> Output {
        self.command(arguments).output().expect("mgpi runs")
    }

    /// Runs a command, which must succeed; answers its standard output.
    ///
    /// # Panics
    /// It fails.
    pub fn succeeds(&self, arguments: &str) -> String {
        let output = self.run(arguments);
        assert!(output.status.success(), "{arguments}: {}", String::from_utf8_lossy(&output.stderr));
        String::from_utf8(output.stdout).expect("UTF-8")
    }

    /// Runs a command, which must fail with status 2; answers its message.
    ///
    /// # Panics
    /// It does not.
    pub fn refuses(&self, arguments: &str) -> String {
        let output = self.run(arguments);
        assert_eq!(output.status.code(), Some(2), "{arguments}: {}", String::from_utf8_lossy(&output.stdout));
        String::from_utf8(output.stderr).expect("UTF-8")
    }

    /// What `mgpi status` says, for programs.
    ///
    /// # Panics
    /// It says nothing.
    pub fn status(&self) -> Value {
        serde_json::from_str(&self.succeeds("status --json")).expect("JSON")
    }

    /// The path of a file in the directory.
    pub fn path(&self, file: &str) -> PathBuf {
        self.directory.path().join(file)
    }

    /// The end of the board's bus that a host opens.
    pub fn port(&self) -> &Path {
        self.desk.port()
    }

    /// Reads a file of the directory.
    ///
    /// # Panics
    /// There is no such file.
    pub fn read(&self, file: &str) -> String {
        std::fs::read_to_string(self.path(file)).expect(file)
    }

    /// Writes a file into the directory.
    ///
    /// # Panics
    /// It cannot be written.
    pub fn write(&self, file: &str, content: &str) {
        std::fs::write(self.path(file), content).expect(file);
    }
}

/// The program, two directories above the test's.
///
/// # Panics
/// The test does not know where it is.
pub fn mgpi() -> PathBuf {
    let test = std::env::current_exe().expect("this program");
    test.parent().and_then(|deps| deps.parent()).expect("its directory").join("mgpi")
}

impl Default for DeskBench {
    fn default() -> Self {
        Self::new()
    }
}
