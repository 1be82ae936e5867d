//! A serial port by its name: raw bytes, every wait with an end.
//!
//! # Contract
//! One program has the port at a time: an advisory lock on it, which others that lock (`pyserial`
//! with `exclusive`, `picocom`) respect too. Eight bits, no flow control; a pseudo terminal takes
//! rate and parity and ignores them.

use std::fs;
use std::io::{self, Read, Write};
use std::os::fd::AsFd;
use std::path::{Path, PathBuf};
use std::time::Instant;

use clap::ValueEnum;
use rustix::event::{PollFd, PollFlags, Timespec, poll};
use rustix::fs::{FlockOperation, Mode, OFlags, flock};
use rustix::io::Errno;
use rustix::termios::{ControlModes, OptionalActions, QueueSelector, tcflush, tcgetattr, tcsetattr};
use thiserror::Error;

/// Where an operating system lists its serial ports, the lasting names first.
const DIRECTORIES: [(&str, &str); 3] = [("/dev/serial/by-id", ""), ("/dev", "ttyUSB"), ("/dev", "ttyACM")];

/// How the bytes go over the line.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Line {
    /// Unit: bit/s.
    pub baud: u32,
    /// The bit that checks the others.
    pub parity: Parity,
}

/// The bit that checks the others.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum Parity {
    /// There is none
    None,
    /// The ones are even in number
    Even,
    /// The ones are odd in number
    Odd,
}

/// Why a port cannot be used.
#[derive(Debug, Error)]
#[allow(missing_docs, reason = "the messages say what the variants and their fields are")]
pub enum PortError {
    #[error("{}: no such port; there {}", port.display(), known(.present))]
    Missing { port: PathBuf, present: Vec<PathBuf> },
    #[error("{}: busy: another program has this port", .0.display())]
    Busy(PathBuf),
    #[error("{}: not permitted; on most systems the group dialout may use serial ports", .0.display())]
    Denied(PathBuf),
    #[error("{}: not a serial port", .0.display())]
    NotSerial(PathBuf),
    #[error("{}: {problem}", port.display())]
    Io { port: PathBuf, problem: io::Error },
    #[error("{}: gone: the cable was unplugged, or the emulator has ended", .0.display())]
    Gone(PathBuf),
}

fn known(present: &[PathBuf]) -> String {
    match present {
        [] => "is none on this machine".to_owned(),
        some => format!(
            "are {}",
            some.iter().map(|port| port.display().to_string()).collect::<Vec<_>>().join(", ")
        ),
    }
}

/// The serial ports of this machine that an adapter makes.
fn present() -> Vec<PathBuf> {
    let entries = |(directory, prefix): (&str, &'static str)| {
        let entries = fs::read_dir(directory).into_iter().flatten().flatten().map(|entry| entry.path());
        entries.filter(move |path| {
            path.file_name().is_some_and(|name| name.as_encoded_bytes().starts_with(prefix.as_bytes()))
        })
    };
    let mut ports: Vec<PathBuf> = DIRECTORIES.into_iter().flat_map(entries).collect();
    ports.sort();
    ports
}

/// An open port.
#[derive(Debug)]
pub struct Port {
    name: PathBuf,
    file: fs::File,
}

impl Port {
    /// Opens a port: a path, or its name under `/dev`.
    ///
    /// # Errors
    /// There is no such port, another program has it, the user may not use it, or it is no serial
    /// port.
    pub fn open(name: &Path, line: Line) -> Result<Self, PortError> {
        let under_dev = Path::new("/dev").join(name);
        let path = if !name.exists() && under_dev.exists() { &under_dev } else { name };
        let flags = OFlags::RDWR | OFlags::NOCTTY | OFlags::NONBLOCK | OFlags::CLOEXEC;
        let file = rustix::fs::open(path, flags, Mode::empty()).map_err(|error| refused(name, error))?;
        flock(&file, FlockOperation::NonBlockingLockExclusive).map_err(|error| refused(name, error))?;
        let mut settings = tcgetattr(&file).map_err(|_| PortError::NotSerial(name.to_owned()))?;
        settings.make_raw();
        let (set, parity) = match line.parity {
            Parity::None => (ControlModes::empty(), ControlModes::empty()),
            Parity::Even => (ControlModes::PARENB, ControlModes::PARENB),
            Parity::Odd => (ControlModes::PARENB | ControlModes::PARODD, ControlModes::PARENB),
        };
        settings.control_modes -= ControlModes::PARENB | ControlModes::PARODD | ControlModes::CRTSCTS;
        settings.control_modes |= set | parity | ControlModes::CLOCAL | ControlModes::CREAD;
        let set =
            settings.set_speed(line.baud).and_then(|()| tcsetattr(&file, OptionalActions::Now, &settings));
        set.map_err(|error| refused(name, error))?;
        Ok(Self { name: name.to_owned(), file: file.into() })
    }

    /// What the port was opened by.
    pub fn name(&self) -> &Path {
        &self.name
    }

    /// Forgets what has come in.
    ///
    /// # Errors
    /// The port is gone.
    pub fn discard(&self) -> Result<(), PortError> {
        tcflush(&self.file, QueueSelector::IFlush).map_err(|error| self.lost(error.into()))
    }

    /// Sends all of the bytes.
    ///
    /// # Errors
    /// The port does not take them by the deadline, or is gone.
    pub fn send(&mut self, mut bytes: &[u8], deadline: Instant) -> Result<(), PortError> {
        while !bytes.is_empty() {
            if !self.wait(PollFlags::OUT, deadline)? {
                return Err(self.lost(io::ErrorKind::TimedOut.into()));
            }
            match self.file.write(bytes) {
                Ok(count) => bytes = &bytes[count..],
                Err(error) if error.kind() == io::ErrorKind::WouldBlock => {}
                Err(error) => return Err(self.lost(error)),
            }
        }
        Ok(())
    }

    /// Takes what comes first, at least a byte, or nothing by the deadline; answers how many bytes.
    ///
    /// # Errors
    /// The port is gone.
    pub fn receive(&mut self, buffer: &mut [u8], deadline: Instant) -> Result<usize, PortError> {
        while self.wait(PollFlags::IN, deadline)? {
            match self.file.read(buffer) {
                Ok(0) => return Err(PortError::Gone(self.name.clone())),
                Ok(count) => return Ok(count),
                Err(error) if error.kind() == io::ErrorKind::WouldBlock => {}
                Err(error) => return Err(self.lost(error)),
            }
        }
        Ok(0)
    }

    /// Whether the port is ready before the deadline.
    fn wait(&self, what: PollFlags, deadline: Instant) -> Result<bool, PortError> {
        loop {
            let left = deadline.saturating_duration_since(Instant::now());
            let left = Timespec { tv_sec: left.as_secs() as i64, tv_nsec: left.subsec_nanos().into() };
            match poll(&mut [PollFd::from_borrowed_fd(self.file.as_fd(), what)], Some(&left)) {
                Err(Errno::INTR) => {}
                Ok(ready) => return Ok(ready > 0),
                Err(error) => return Err(self.lost(error.into())),
            }
        }
    }

    fn lost(&self, problem: io::Error) -> PortError {
        // What a terminal without its other end says.
        if problem.raw_os_error() == Some(Errno::IO.raw_os_error()) {
            return PortError::Gone(self.name.clone());
        }
        PortError::Io { port: self.name.clone(), problem }
    }
}

fn refused(port: &Path, error: Errno) -> PortError {
    let port = port.to_owned();
    match error {
        // A link that leads nowhere is left of an emulator that was killed.
        Errno::NOENT if port.is_symlink() => PortError::Gone(port),
        Errno::NOENT | Errno::NODEV | Errno::NXIO => PortError::Missing { port, present: present() },
        Errno::BUSY | Errno::WOULDBLOCK => PortError::Busy(port),
        Errno::ACCESS | Errno::PERM => PortError::Denied(port),
        Errno::NOTTY | Errno::ISDIR => PortError::NotSerial(port),
        error => PortError::Io { port, problem: error.into() },
    }
}
