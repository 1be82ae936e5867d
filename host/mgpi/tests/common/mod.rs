//! Runs the command `mgpi` in a directory of its own.
#![allow(dead_code, reason = "each test program uses its part")]

pub mod processes;

use std::io::Write;
use std::path::PathBuf;
use std::process::{Command, Output, Stdio};

use tempfile::TempDir;

/// A directory that a test works in.
pub struct Bench {
    directory: TempDir,
}

impl Bench {
    /// An empty directory.
    pub fn new() -> Self {
        Self { directory: tempfile::tempdir().expect("a temporary directory") }
    }

    /// The path of a file in the directory.
    pub fn path(&self, name: &str) -> PathBuf {
        self.directory.path().join(name)
    }

    /// Writes a file.
    pub fn write(&self, name: &str, content: impl AsRef<[u8]>) -> &Self {
        std::fs::write(self.path(name), content).expect("writable");
        self
    }

    /// Reads a file.
    pub fn read(&self, name: &str) -> String {
        std::fs::read_to_string(self.path(name)).expect("readable")
    }

    /// Names of all files, sorted.
    pub fn files(&self) -> Vec<String> {
        let entries = std::fs::read_dir(self.directory.path()).expect("readable");
        let mut names: Vec<String> =
            entries.map(|entry| entry.expect("readable").file_name().display().to_string()).collect();
        names.sort();
        names
    }

    /// Runs the command in the directory; arguments are separated by spaces.
    pub fn mgpi(&self, arguments: &str) -> Output {
        Command::new(env!("CARGO_BIN_EXE_mgpi"))
            .args(arguments.split_whitespace())
            .current_dir(self.directory.path())
            .output()
            .expect("mgpi runs")
    }

    /// Runs the command with this on its standard input.
    pub fn fed(&self, arguments: &str, content: &[u8]) -> Output {
        let mut child = Command::new(env!("CARGO_BIN_EXE_mgpi"))
            .args(arguments.split_whitespace())
            .current_dir(self.directory.path())
            .stdin(Stdio::piped())
            .stdout(Stdio::piped())
            .stderr(Stdio::piped())
            .spawn()
            .expect("mgpi runs");
        child.stdin.take().expect("a pipe").write_all(content).expect("it reads");
        child.wait_with_output().expect("it ends")
    }

    /// Runs the command, which must succeed; answers its standard output.
    pub fn succeeds(&self, arguments: &str) -> String {
        let output = self.mgpi(arguments);
        assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
        String::from_utf8(output.stdout).expect("UTF-8")
    }

    /// Runs the command, which must fail with status 2 and leave the directory as it was; answers
    /// its message.
    pub fn refuses(&self, arguments: &str) -> String {
        let before = self.files();
        let output = self.mgpi(arguments);
        let message = String::from_utf8(output.stderr).expect("UTF-8");
        assert_eq!(output.status.code(), Some(2), "{message}");
        assert_eq!(self.files(), before, "something was written");
        message
    }
}

impl Drop for Bench {
    /// A test that fails leaves no program at work, which would take the processor from all others.
    fn drop(&mut self) {
        if std::thread::panicking() {
            processes::kill(self);
        }
    }
}

/// Even noise of -0.5 to 0.5, the same for the same seed.
pub fn noise(mut seed: u64) -> impl FnMut() -> f64 {
    move || {
        seed = seed.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (seed >> 33) as f64 / f64::from(1_u32 << 31) - 0.5
    }
}

/// A recording: triangles of falling height (6 to 1 bar) and the paper's model's answer, 20 rows a
/// second.
pub fn recording(bench: &Bench, name: &str) {
    let mut text = "time_s,pressure_bar\n".to_owned();
    for row in 0..1200 {
        let (triangle, step) = (row / 200, row % 200);
        let share = f64::from(step.min(200 - step)) / 100.0;
        text += &format!("{},{}\n", f64::from(row) / 20.0, share * f64::from(6 - triangle));
    }
    let model = bench.write("drive.csv", text).write("paper.toml", PAPER);
    model.succeeds(&format!("simulate paper.toml --input drive.csv -o {name}"));
}

/// The model of the paper's Tables 1 and 2.
pub const PAPER: &str = include_str!("../../../../examples/paper-tables-1-2.toml");
