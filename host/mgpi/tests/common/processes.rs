//! The programs that `mgpi` has started.

use std::fs;
use std::process::Command;
use std::time::{Duration, Instant};

use board_client::emulator::image;

use super::Bench;

/// What is missing for tests with the emulator.
pub fn missing() -> Option<String> {
    if Command::new("qemu-system-arm").arg("--version").output().is_err() {
        return Some("no qemu-system-arm; `cargo xtask setup` installs it".to_owned());
    }
    image::find(None).err().map(|error| error.to_string())
}

/// No program may be left. One that a plant had started is no child of ours: killed, it takes a
/// moment to be gone.
pub fn assert_none_is_left(bench: &Bench) {
    let deadline = Instant::now() + Duration::from_secs(10);
    while !processes(bench).is_empty() {
        assert!(Instant::now() < deadline, "a program is left");
        std::thread::sleep(Duration::from_millis(20));
    }
}

/// The running programs that are at work in the bench's directory.
fn processes(bench: &Bench) -> Vec<u32> {
    let directory = fs::canonicalize(bench.path("")).expect("a directory");
    let entries = fs::read_dir("/proc").expect("readable");
    let numbers = entries.filter_map(|entry| entry.ok()?.file_name().to_str()?.parse::<u32>().ok());
    // A program that has ended meanwhile has no directory any more.
    numbers
        .filter(|number| fs::read_link(format!("/proc/{number}/cwd")).is_ok_and(|cwd| cwd == directory))
        .collect()
}

/// Ends them, whatever they do.
pub fn kill(bench: &Bench) {
    for number in processes(bench).into_iter().filter(|&number| number != std::process::id()) {
        // One that has just ended by itself is no matter.
        let _ = Command::new("kill").args(["-KILL", &number.to_string()]).status();
    }
}

/// The emulators among them.
pub fn emulators(bench: &Bench) -> Vec<u32> {
    let mut numbers = processes(bench);
    numbers.retain(|number| {
        fs::read_to_string(format!("/proc/{number}/comm")).is_ok_and(|name| name.starts_with("qemu-system"))
    });
    numbers
}

/// Sends a program a signal.
pub fn signal(name: &str, number: u32) {
    let sent = Command::new("kill").args([format!("-{name}"), number.to_string()]).status();
    assert!(sent.is_ok_and(|status| status.success()), "{name} to {number}");
}
