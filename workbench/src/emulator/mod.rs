//! The board's firmware in an emulator: QEMU's `netduinoplus2`, an STM32F405.
//!
//! # Design
//! The emulated serial port is one end of a pair of connected sockets, handed over as QEMU's standard input: no name
//! in the file system, nothing left behind. QEMU's standard output is the firmware's log (defmt over semihosting),
//! kept in an unnamed file and decoded when it is asked for.
//!
//! # Contract
//! [`Emulator::request`] sends one request and waits for its response, for ever only if the firmware keeps talking.
//! When the emulator ends, or does not answer within [`ANSWER_LIMIT`], the error carries the firmware's log.
//!
//! # Limits
//! Time in the emulator is not real time: results repeat, durations say nothing about the board.

pub mod image;
pub mod log;

use std::fs::File;
use std::io::{self, ErrorKind, Read, Write};
use std::os::fd::OwnedFd;
use std::os::unix::net::UnixStream;
use std::path::Path;
use std::process::{Command, Stdio};
use std::time::{Duration, Instant};

use thiserror::Error;
use wire::{FRAME_BYTES, FrameError, Receiver, Request, Response};

use crate::child::{ChildGroup, Stop, WAIT_SLICE, contents};
use log::{LogDecoder, LogError};

/// How long the firmware may take for an answer, its start included. It takes a quarter of a millisecond; on a machine
/// that is kept busy by others, where each of a configuration's bytes waits its turn, some ten seconds.
pub const ANSWER_LIMIT: Duration = Duration::from_secs(60);

/// The program.
const QEMU: &str = "qemu-system-arm";

/// Why the emulator does not do its work.
#[derive(Debug, Error)]
#[allow(missing_docs, reason = "the messages say what the variants and their fields are")]
pub enum EmulatorError {
    #[error("{QEMU} cannot be started: {0}; `cargo xtask setup` installs it")]
    NotStarted(io::Error),
    #[error("the emulator's log cannot be kept: {0}")]
    Log(#[from] LogError),
    #[error("the emulator has died: {ending}\nthe firmware's log:\n{log}")]
    Died { ending: String, log: String },
    #[error("the emulator has died: {0}")]
    Ended(String),
    #[error("the firmware has not answered within {} s\nits log:\n{log}", ANSWER_LIMIT.as_secs())]
    Silent { log: String },
    #[error("the firmware's answer cannot be read: {0}")]
    Unreadable(#[from] FrameError),
    #[error("stopped")]
    Stopped,
}

/// The options that every use of the emulator has in common; the serial port is the character device `link`.
pub fn qemu(elf: &Path) -> Command {
    let mut command = Command::new(QEMU);
    command
        .args(["-machine", "netduinoplus2", "-cpu", "cortex-m4", "-display", "none", "-monitor", "none"])
        .args(["-semihosting-config", "enable=on,target=native"])
        .args(["-serial", "null", "-serial", "chardev:link", "-kernel"])
        .arg(elf);
    command
}

/// A board in the emulator.
#[derive(Debug)]
pub struct Emulator {
    group: ChildGroup,
    link: UnixStream,
    receiver: Receiver,
    log: File,
    decoder: LogDecoder,
    stop: Stop,
}

impl Emulator {
    /// Starts the firmware and waits for its greeting.
    ///
    /// # Errors
    /// The firmware's file is none, or the emulator cannot be started, dies or is silent.
    pub fn start(elf: &Path, stop: &Stop) -> Result<Self, EmulatorError> {
        let decoder = LogDecoder::of(elf)?;
        let (link, group, log) = launch(elf).map_err(EmulatorError::NotStarted)?;
        let mut emulator = Self { group, link, receiver: Receiver::new(), log, decoder, stop: stop.clone() };
        emulator.receive()?;
        Ok(emulator)
    }

    /// Sends a request and waits for the response.
    ///
    /// # Errors
    /// The emulator dies, is silent, or answers what is no response; a stop is requested.
    pub fn request(&mut self, request: &Request) -> Result<Response, EmulatorError> {
        let mut buffer = [0; FRAME_BYTES];
        let frame = wire::encode(request, &mut buffer)?;
        match self.link.write_all(frame) {
            Ok(()) => self.receive(),
            Err(_) => Err(self.died()),
        }
    }

    /// The firmware's log so far, a line an entry.
    pub fn log(&self) -> String {
        let mut text = String::new();
        let decoded = contents(&self.log)
            .and_then(|bytes| self.decoder.follow(&*bytes, |entry| text += &format!("  {entry}\n")));
        match decoded {
            Ok(()) => text.trim_end().to_owned(),
            Err(error) => format!("  (unreadable: {error})"),
        }
    }

    fn receive(&mut self) -> Result<Response, EmulatorError> {
        let begin = Instant::now();
        let mut bytes = [0; FRAME_BYTES];
        loop {
            let received = match self.link.read(&mut bytes) {
                Ok(0) => return Err(self.died()),
                Ok(count) => &bytes[..count],
                Err(error) if is_time_out(&error) => &[],
                Err(_) => return Err(self.died()),
            };
            for &byte in received {
                if let Some(response) = self.receiver.push(byte) {
                    return Ok(response?);
                }
            }
            if self.stop.is_requested() {
                return Err(EmulatorError::Stopped);
            }
            if received.is_empty() && begin.elapsed() > ANSWER_LIMIT {
                return Err(EmulatorError::Silent { log: self.log() });
            }
        }
    }

    fn died(&mut self) -> EmulatorError {
        EmulatorError::Died { ending: self.group.end(), log: self.log() }
    }
}

fn launch(elf: &Path) -> io::Result<(UnixStream, ChildGroup, File)> {
    let (ours, theirs) = UnixStream::pair()?;
    ours.set_read_timeout(Some(WAIT_SLICE))?;
    let log = tempfile::tempfile()?;
    let mut qemu = qemu(elf);
    // Descriptor 0 is the standard input.
    qemu.args(["-chardev", "socket,id=link,fd=0"]).stdin(Stdio::from(OwnedFd::from(theirs)));
    let group = ChildGroup::spawn(qemu.stdout(log.try_clone()?))?;
    Ok((ours, group, log))
}

fn is_time_out(error: &io::Error) -> bool {
    matches!(error.kind(), ErrorKind::WouldBlock | ErrorKind::TimedOut | ErrorKind::Interrupted)
}
