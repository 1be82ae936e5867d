//! A serial port of this machine whose other end is the emulated board: a pseudo terminal under a
//! name.
//!
//! # Contract
//! The name is a symbolic link, which goes with the [`Line`] and leads to the terminal by way of
//! this program: left behind by a program that was killed it leads nowhere, not to a terminal that
//! another board has meanwhile, and is replaced. Any number of programs may use the port one after
//! the other. What the board sends while nobody reads is lost as soon as the terminal is full.

use std::fs::{self, File};
use std::io::{self, ErrorKind, Read, Write};
use std::os::fd::AsFd;
use std::os::unix::fs::symlink;
use std::os::unix::net::UnixStream;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::thread::{self, JoinHandle};

use rustix::event::{PollFd, PollFlags, Timespec, poll};
use rustix::io::ioctl_fionbio;
use rustix::process::Pid;

use super::terminal::PseudoTerminal;
use crate::child::WAIT_SLICE;

/// Who has made a port's name.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Owner {
    /// An emulator that runs.
    Running(Pid),
    /// One that has ended without removing it.
    Gone,
}

impl Owner {
    /// That of a name; none if no emulator has made it.
    pub fn of(name: &Path) -> Option<Self> {
        let link = fs::read_link(name).ok()?;
        let pid = link.strip_prefix("/proc").ok().and_then(|path| path.iter().next()?.to_str()?.parse().ok());
        // The number may be another program's by now, and its descriptor anything.
        let is_terminal = || fs::read_link(&link).is_ok_and(|terminal| terminal.starts_with("/dev/pts"));
        match pid.and_then(Pid::from_raw) {
            Some(pid) if is_terminal() => Some(Self::Running(pid)),
            Some(_) => Some(Self::Gone),
            None => (!name.exists()).then_some(Self::Gone),
        }
    }
}

/// The port, as long as it is kept.
#[derive(Debug)]
pub struct Line {
    name: PathBuf,
    link: PathBuf,
    terminal: PathBuf,
    has_replaced: bool,
    is_closing: Arc<AtomicBool>,
    pump: Option<JoinHandle<()>>,
}

impl Line {
    /// Makes a port of a connection to the board.
    ///
    /// # Errors
    /// There is something of this name already, an emulator has it, or it cannot be made.
    pub fn open(name: &Path, board: UnixStream) -> io::Result<Self> {
        let mut terminal = PseudoTerminal::open()?;
        let path = terminal.path().to_owned();
        ioctl_fionbio(&*terminal.end(), true)?;
        board.set_nonblocking(true)?;
        let owner = Owner::of(name);
        match owner {
            Some(Owner::Running(pid)) => return Err(taken(pid)),
            Some(Owner::Gone) => fs::remove_file(name)?,
            None => {}
        }
        let link = terminal.path_of_this_program();
        symlink(&link, name)?;
        let is_closing = Arc::new(AtomicBool::new(false));
        let closing = is_closing.clone();
        let pump = thread::spawn(move || {
            // An end that fails has nothing more to say; the emulator tells its own end over the
            // link.
            let _ = pump(terminal.end(), &board, &closing);
        });
        let has_replaced = owner.is_some();
        Ok(Self { name: name.to_owned(), link, terminal: path, has_replaced, is_closing, pump: Some(pump) })
    }

    /// Whether it has taken the place of a name that an emulator had left behind.
    pub fn has_replaced(&self) -> bool {
        self.has_replaced
    }

    /// The terminal behind the name.
    pub fn terminal(&self) -> &Path {
        &self.terminal
    }
}

impl Drop for Line {
    fn drop(&mut self) {
        // First, since the terminal goes with the pump. Somebody else may have put something else
        // there.
        if fs::read_link(&self.name).is_ok_and(|target| target == self.link) {
            let _ = fs::remove_file(&self.name);
        }
        self.is_closing.store(true, Ordering::Relaxed);
        if let Some(pump) = self.pump.take() {
            // It does not panic.
            let _ = pump.join();
        }
    }
}

fn taken(pid: Pid) -> io::Error {
    let problem = format!("an emulator has it, process {pid}; `mgpi emulate --stop` ends that");
    io::Error::new(ErrorKind::AddrInUse, problem)
}

/// Copies between port and board until it is to close.
fn pump(port: &mut File, mut board: &UnixStream, closing: &AtomicBool) -> io::Result<()> {
    let slice = Timespec { tv_sec: 0, tv_nsec: WAIT_SLICE.subsec_nanos().into() };
    let mut buffer = [0; 1024];
    while !closing.load(Ordering::Relaxed) {
        let mut ends = [
            PollFd::from_borrowed_fd(port.as_fd(), PollFlags::IN),
            PollFd::from_borrowed_fd(board.as_fd(), PollFlags::IN),
        ];
        match poll(&mut ends, Some(&slice)) {
            Ok(0) | Err(rustix::io::Errno::INTR) => continue,
            Ok(_) => {}
            Err(error) => return Err(error.into()),
        }
        let [port_is_ready, board_is_ready] = ends.map(|end| !end.revents().is_empty());
        if port_is_ready {
            let count = received(port.read(&mut buffer))?;
            given(board.write_all(&buffer[..count]))?;
        }
        if board_is_ready {
            let count = received(board.read(&mut buffer))?;
            given(port.write_all(&buffer[..count]))?;
        }
    }
    Ok(())
}

/// How many bytes came; an end that has closed is an error.
fn received(read: io::Result<usize>) -> io::Result<usize> {
    match read {
        Ok(0) => Err(ErrorKind::BrokenPipe.into()),
        Err(error) if error.kind() == ErrorKind::WouldBlock => Ok(0),
        other => other,
    }
}

/// What an end has no room for is lost, as on a wire.
fn given(write: io::Result<()>) -> io::Result<()> {
    match write {
        Err(error) if error.kind() == ErrorKind::WouldBlock => Ok(()),
        other => other,
    }
}
