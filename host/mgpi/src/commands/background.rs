//! Boards without hardware in the background: a command that returns as soon as they answer, and
//! one that ends them.

use std::fs;
use std::io::{self, BufRead, BufReader, Read, Seek, Write};
use std::path::Path;
use std::process::{Command, Stdio};
use std::thread;
use std::time::{Duration, Instant};

use board_client::child::WAIT_SLICE;
use board_client::emulator::EmulatorError;
use board_client::emulator::line::Owner;
use rustix::process::{Signal, kill_process};

use crate::Error;

/// What is written where somebody waits for the boards.
const READY: &str = "ready";
/// How long a program may take to end.
const END: Duration = Duration::from_secs(10);

/// Says that the boards answer, to a descriptor where one is given.
///
/// # Errors
/// It cannot be written.
pub fn tell_ready(descriptor: Option<u32>) -> Result<(), Error> {
    if let Some(descriptor) = descriptor {
        let told = fs::OpenOptions::new().write(true).open(format!("/dev/fd/{descriptor}"));
        told.and_then(|mut file| writeln!(file, "{READY}")).map_err(EmulatorError::Untold)?;
    }
    Ok(())
}

/// Starts this command again without --background, and waits until its boards answer.
///
/// # Errors
/// It does not start, or ends before; what it said then.
pub fn start() -> Result<(), Error> {
    let arguments = std::env::args_os().skip(1).filter(|argument| argument != "--background");
    let start = || {
        let mut messages = tempfile::tempfile()?;
        let mut command = Command::new(std::env::current_exe()?);
        command.args(arguments).args(["--ready-fd", "1"]);
        command.stdin(Stdio::null()).stdout(Stdio::piped()).stderr(messages.try_clone()?);
        let mut emulator = command.spawn()?;
        let output = emulator.stdout.take().ok_or(io::ErrorKind::BrokenPipe)?;
        for line in BufReader::new(output).lines() {
            match line?.replace("Ctrl-C ends", "--stop ends") {
                line if line == READY => return Ok(None),
                line => say!("{line}"),
            }
        }
        // It has ended, and said why.
        emulator.wait()?;
        let mut said = String::new();
        messages.rewind()?;
        messages.read_to_string(&mut said)?;
        Ok(Some(said.trim_start_matches("error: ").trim_end().to_owned()))
    };
    match start().map_err(EmulatorError::NotInBackground)? {
        None => Ok(()),
        Some(said) => Err(EmulatorError::NotReady(said).into()),
    }
}

/// Ends the program that has a port, and removes the name that one has left.
///
/// # Errors
/// There is none, or it does not end.
pub fn end(port: &Path) -> Result<(), Error> {
    let refused = |problem: io::Error| EmulatorError::Line { name: port.to_owned(), problem };
    match Owner::of(port) {
        None => return Err(EmulatorError::NoEmulator(port.to_owned()).into()),
        Some(Owner::Gone) => {
            fs::remove_file(port).map_err(refused)?;
            say!("{}: was left by an emulator that was killed, and is removed", port.display());
        }
        Some(Owner::Running(process)) => {
            kill_process(process, Signal::TERM).map_err(|error| refused(error.into()))?;
            let deadline = Instant::now() + END;
            while Owner::of(port) == Some(Owner::Running(process)) {
                if Instant::now() > deadline {
                    return Err(refused(io::ErrorKind::TimedOut.into()).into());
                }
                thread::sleep(WAIT_SLICE);
            }
        }
    }
    Ok(())
}
