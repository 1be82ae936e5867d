//! The board's firmware in an emulator: QEMU's `netduinoplus2`, an STM32F405.
//!
//! # Design
//! The emulated serial port is one end of a pair of connected sockets, handed over as QEMU's
//! standard input: no name in the file system, nothing left behind. QEMU's standard output is the
//! firmware's log (defmt over semihosting), kept in an unnamed file and decoded when it is asked
//! for.
//!
//! The users' bus is another pair, by a name in a directory of its own that goes at once;
//! [`mod@line`] makes a serial port of it, by a [`terminal`], and [`real_time`] runs the board for
//! those who use that.
//!
//! # Contract
//! [`Emulator::request`] sends one request and waits for its response, for ever only if the
//! firmware keeps talking. When the emulator ends, or does not answer within [`ANSWER_LIMIT`], the
//! error carries the firmware's log.
//!
//! # Limits
//! Time in the emulator is not real time: results repeat, durations say nothing about the board.

pub mod image;
pub mod line;
pub mod log;
pub mod real_time;
pub mod terminal;

use std::fs::File;
use std::io::{self, ErrorKind, Read, Write};
use std::os::fd::OwnedFd;
use std::os::unix::net::{UnixListener, UnixStream};
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use std::time::{Duration, Instant};

use serde::{Serialize, de::DeserializeOwned};
use thiserror::Error;
use wire::joint::{JointRequest, JointResponse};
use wire::{FRAME_BYTES, FrameError, Receiver, Request, Response};

use crate::child::{ChildGroup, WAIT_SLICE, contents};
use crate::stop::Stop;
use log::{LogDecoder, LogError};

/// How long the firmware may take for an answer, its start included. It takes a quarter of a
/// millisecond; on a machine that is kept busy by others, where each of a configuration's bytes
/// waits its turn, some ten seconds.
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
    #[error("{}: no emulator has this port", .0.display())]
    NoEmulator(PathBuf),
    #[error("the emulator cannot be started in the background: {0}")]
    NotInBackground(io::Error),
    #[error("{0}")]
    NotReady(String),
    #[error("nobody can be told that the board is ready: {0}")]
    Untold(io::Error),
    #[error("{}: no serial port can be made there: {problem}", name.display())]
    Line { name: PathBuf, problem: io::Error },
    #[error("the firmware has not answered within {} s\nits log:\n{log}", ANSWER_LIMIT.as_secs())]
    Silent { log: String },
    #[error("the firmware's answer cannot be read: {0}")]
    Unreadable(#[from] FrameError),
    #[error("stopped")]
    Stopped,
}

/// The options that every use of the emulator has in common. The link is the character device
/// `link`; `bus`: where the users' bus goes.
pub fn qemu(elf: &Path, bus: &str) -> Command {
    let mut command = Command::new(QEMU);
    command
        .args(["-machine", "netduinoplus2", "-cpu", "cortex-m4", "-display", "none", "-monitor", "none"])
        .args(["-semihosting-config", "enable=on,target=native"])
        .args(["-serial", bus, "-serial", "chardev:link", "-kernel"])
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
    /// The firmware's file is not valid, or the emulator cannot be started, dies or is silent.
    pub fn start(elf: &Path, stop: &Stop) -> Result<Self, EmulatorError> {
        Self::launch::<Response>(elf, qemu(elf, "null"), stop)
    }

    /// The same for the firmware of a joint.
    ///
    /// # Errors
    /// As above.
    pub fn start_joint(elf: &Path, stop: &Stop) -> Result<Self, EmulatorError> {
        Self::launch::<JointResponse>(elf, qemu(elf, "null"), stop)
    }

    /// The same with the users' bus, whose other end is answered too.
    ///
    /// # Errors
    /// As above.
    pub fn start_with_bus(elf: &Path, stop: &Stop) -> Result<(Self, UnixStream), EmulatorError> {
        let directory = tempfile::tempdir().map_err(EmulatorError::NotStarted)?;
        let name = directory.path().join("bus");
        let bus = UnixListener::bind(&name).map_err(EmulatorError::NotStarted)?;
        let mut command = qemu(elf, "chardev:bus");
        command.arg("-chardev").arg(format!("socket,id=bus,path={}", name.display()));
        let emulator = Self::launch::<Response>(elf, command, stop)?;
        // The firmware has greeted: whatever the emulator connects to is connected.
        bus.set_nonblocking(true).map_err(EmulatorError::NotStarted)?;
        let (bus, _) = bus.accept().map_err(EmulatorError::NotStarted)?;
        Ok((emulator, bus))
    }

    /// Starts the firmware, whose greeting is a message of this type.
    fn launch<M: DeserializeOwned>(elf: &Path, command: Command, stop: &Stop) -> Result<Self, EmulatorError> {
        let decoder = LogDecoder::of(elf)?;
        let (link, group, log) = launch(command).map_err(EmulatorError::NotStarted)?;
        let mut emulator = Self { group, link, receiver: Receiver::new(), log, decoder, stop: stop.clone() };
        emulator.receive::<M>()?;
        Ok(emulator)
    }

    /// Sends a request and waits for the response.
    ///
    /// # Errors
    /// The emulator dies, is silent, or answers what is no response; a stop is requested.
    pub fn request(&mut self, request: &Request) -> Result<Response, EmulatorError> {
        self.exchange(request)
    }

    /// The same with the firmware of a joint.
    ///
    /// # Errors
    /// As above.
    pub fn request_joint(&mut self, request: &JointRequest) -> Result<JointResponse, EmulatorError> {
        self.exchange(request)
    }

    fn exchange<M: DeserializeOwned>(&mut self, request: &impl Serialize) -> Result<M, EmulatorError> {
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

    fn receive<M: DeserializeOwned>(&mut self) -> Result<M, EmulatorError> {
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

fn launch(mut qemu: Command) -> io::Result<(UnixStream, ChildGroup, File)> {
    let (ours, theirs) = UnixStream::pair()?;
    ours.set_read_timeout(Some(WAIT_SLICE))?;
    let log = tempfile::tempfile()?;
    // Descriptor 0 is the standard input.
    qemu.args(["-chardev", "socket,id=link,fd=0"]).stdin(Stdio::from(OwnedFd::from(theirs)));
    let group = ChildGroup::spawn(qemu.stdout(log.try_clone()?))?;
    Ok((ours, group, log))
}

fn is_time_out(error: &io::Error) -> bool {
    matches!(error.kind(), ErrorKind::WouldBlock | ErrorKind::TimedOut | ErrorKind::Interrupted)
}
