//! `mgpi` at a port, in a directory of its own.

use std::path::{Path, PathBuf};
use std::process::{Command, Output};

use tempfile::TempDir;

/// What runs there. The program stands beside the tests' programs.
#[derive(Debug)]
pub struct Commands {
    port: PathBuf,
    directory: TempDir,
}

impl Commands {
    /// At this port, in an empty directory.
    ///
    /// # Panics
    /// There is no directory for it.
    pub fn at(port: &Path) -> Self {
        Self { port: port.to_owned(), directory: tempfile::tempdir().expect("a temporary directory") }
    }

    /// The directory in which commands run.
    pub fn directory(&self) -> &Path {
        self.directory.path()
    }

    /// A command with the port behind it.
    pub fn command(&self, arguments: &str) -> Command {
        let mut command = Command::new(mgpi());
        command.args(arguments.split_whitespace()).arg("--port").arg(&self.port);
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
        let said = String::from_utf8(output.stderr).expect("UTF-8");
        assert_eq!(output.status.code(), Some(2), "{arguments}: {said}");
        said
    }

    /// Names of all files of the directory, sorted.
    ///
    /// # Panics
    /// It cannot be read.
    pub fn files(&self) -> Vec<String> {
        let entries = std::fs::read_dir(self.directory()).expect("a directory");
        let mut names: Vec<String> =
            entries.map(|entry| entry.expect("an entry").file_name().display().to_string()).collect();
        names.sort();
        names
    }

    /// The path of a file in the directory.
    pub fn path(&self, file: &str) -> PathBuf {
        self.directory.path().join(file)
    }

    /// The end that a host opens.
    pub fn port(&self) -> &Path {
        &self.port
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
