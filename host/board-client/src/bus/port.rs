//! A serial port by its name: raw bytes, every wait with an end.
//!
//! # Contract
//! One program has the port at a time: an advisory lock on it, which others that lock (`pyserial`
//! with `exclusive`, `picocom`) respect too. Eight bits, no flow control; a pseudo terminal takes
//! rate and parity and ignores them.

use std::io::{self, ErrorKind};
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

use clap::ValueEnum;
use serial2::{FlowControl, KeepSettings, SerialPort};
use thiserror::Error;

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

/// The serial ports of this machine.
fn present() -> Vec<PathBuf> {
    let mut ports = SerialPort::available_ports().unwrap_or_default();
    ports.sort();
    ports
}

/// An open port.
#[derive(Debug)]
pub struct Port {
    name: PathBuf,
    serial: SerialPort,
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
        let refused = |error| refused(name, error);
        let mut serial = SerialPort::open(path, KeepSettings).map_err(refused)?;
        system::lock(&serial).map_err(refused)?;
        let mut settings = serial.get_configuration().map_err(refused)?;
        settings.set_raw();
        settings.set_flow_control(FlowControl::None);
        settings.set_parity(line.parity.into());
        settings.set_baud_rate(line.baud).map_err(refused)?;
        match serial.set_configuration(&settings) {
            // It has no parity, and that is not applied.
            Err(_) if is_pseudo_terminal(path) => {}
            applied => applied.map_err(refused)?,
        }
        Ok(Self { name: name.to_owned(), serial })
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
        self.serial.discard_input_buffer().map_err(|error| self.lost(error))
    }

    /// Sends all of the bytes.
    ///
    /// # Errors
    /// The port does not take them by the deadline, or is gone.
    pub fn send(&mut self, mut bytes: &[u8], deadline: Instant) -> Result<(), PortError> {
        while !bytes.is_empty() {
            self.serial.set_write_timeout(left(deadline)).map_err(|error| self.lost(error))?;
            match self.serial.write(bytes) {
                Ok(count) => bytes = &bytes[count..],
                Err(error) if is_passing(&error) && Instant::now() < deadline => {}
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
        loop {
            self.serial.set_read_timeout(left(deadline)).map_err(|error| self.lost(error))?;
            match self.serial.read(buffer) {
                Ok(0) => return Err(PortError::Gone(self.name.clone())),
                Ok(count) => return Ok(count),
                Err(error) if error.kind() == ErrorKind::TimedOut => return Ok(0),
                Err(error) if is_passing(&error) && Instant::now() < deadline => {}
                Err(error) if is_passing(&error) => return Ok(0),
                Err(error) => return Err(self.lost(error)),
            }
        }
    }

    fn lost(&self, problem: io::Error) -> PortError {
        if system::is_gone(&problem) {
            return PortError::Gone(self.name.clone());
        }
        PortError::Io { port: self.name.clone(), problem }
    }
}

impl From<Parity> for serial2::Parity {
    fn from(parity: Parity) -> Self {
        match parity {
            Parity::None => Self::None,
            Parity::Even => Self::Even,
            Parity::Odd => Self::Odd,
        }
    }
}

impl From<Parity> for wire::Parity {
    fn from(parity: Parity) -> Self {
        match parity {
            Parity::None => Self::None,
            Parity::Even => Self::Even,
            Parity::Odd => Self::Odd,
        }
    }
}

impl From<wire::Parity> for Parity {
    fn from(parity: wire::Parity) -> Self {
        match parity {
            wire::Parity::None => Self::None,
            wire::Parity::Even => Self::Even,
            wire::Parity::Odd => Self::Odd,
        }
    }
}

/// The time to a deadline, in the whole milliseconds that a port waits for.
fn left(deadline: Instant) -> Duration {
    let left = deadline.saturating_duration_since(Instant::now());
    Duration::from_millis(left.as_micros().div_ceil(1000) as u64)
}

/// Whether a read or write may be repeated: a signal came, or another program was faster.
fn is_passing(error: &io::Error) -> bool {
    matches!(error.kind(), ErrorKind::Interrupted | ErrorKind::WouldBlock)
}

/// Whether a path leads to a terminal whose other end is a program.
fn is_pseudo_terminal(path: &Path) -> bool {
    path.canonicalize().is_ok_and(|path| path.starts_with("/dev/pts"))
}

fn refused(port: &Path, error: io::Error) -> PortError {
    let port = port.to_owned();
    match error.kind() {
        // A link that leads nowhere is left of an emulator that was killed.
        ErrorKind::NotFound if port.is_symlink() => PortError::Gone(port),
        ErrorKind::NotFound => PortError::Missing { port, present: present() },
        ErrorKind::ResourceBusy | ErrorKind::WouldBlock => PortError::Busy(port),
        ErrorKind::PermissionDenied if system::DENIES_BUSY_PORTS => PortError::Busy(port),
        ErrorKind::PermissionDenied => PortError::Denied(port),
        ErrorKind::IsADirectory => PortError::NotSerial(port),
        _ if system::is_no_port(&error) => PortError::NotSerial(port),
        _ if system::is_no_device(&error) => PortError::Missing { port, present: present() },
        _ => PortError::Io { port, problem: error },
    }
}

/// What Unix has of its own.
#[cfg(unix)]
mod system {
    use std::io;

    use rustix::fs::{FlockOperation, flock};
    use rustix::io::Errno;
    use serial2::SerialPort;

    /// Whether the system says of a port that another program has that it may not be used.
    pub const DENIES_BUSY_PORTS: bool = false;

    /// Keeps other programs that lock it from a port.
    pub fn lock(port: &SerialPort) -> io::Result<()> {
        Ok(flock(port, FlockOperation::NonBlockingLockExclusive)?)
    }

    pub fn is_no_port(error: &io::Error) -> bool {
        Errno::from_io_error(error) == Some(Errno::NOTTY)
    }

    pub fn is_no_device(error: &io::Error) -> bool {
        matches!(Errno::from_io_error(error), Some(Errno::NODEV | Errno::NXIO))
    }

    /// What a terminal without its other end says.
    pub fn is_gone(error: &io::Error) -> bool {
        Errno::from_io_error(error) == Some(Errno::IO)
    }
}

/// Other systems open a port for one program alone, and have no terminals in the place of ports.
#[cfg(not(unix))]
mod system {
    use std::io;

    use serial2::SerialPort;

    pub const DENIES_BUSY_PORTS: bool = true;

    pub fn lock(_: &SerialPort) -> io::Result<()> {
        Ok(())
    }

    pub fn is_no_port(_: &io::Error) -> bool {
        false
    }

    pub fn is_no_device(_: &io::Error) -> bool {
        false
    }

    pub fn is_gone(error: &io::Error) -> bool {
        error.kind() == io::ErrorKind::NotConnected
    }
}
