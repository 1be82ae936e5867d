//! A serial port of this machine whose other end is the emulated board: a pseudo terminal under a name.
//!
//! # Contract
//! The name is a symbolic link, which goes with the [`Line`]; one that points nowhere, left behind by a program that was
//! killed, is replaced. Any number of programs may use the port one after the other. What the board sends while nobody reads
//! is lost as soon as the terminal is full.

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

use super::terminal::PseudoTerminal;
use crate::child::WAIT_SLICE;

/// The port, as long as it is kept.
#[derive(Debug)]
pub struct Line {
    name: PathBuf,
    terminal: PathBuf,
    is_closing: Arc<AtomicBool>,
    pump: Option<JoinHandle<()>>,
}

impl Line {
    /// Makes a port of a connection to the board.
    ///
    /// # Errors
    /// There is something of this name already, or it cannot be made.
    pub fn open(name: &Path, board: UnixStream) -> io::Result<Self> {
        let mut terminal = PseudoTerminal::open()?;
        let path = terminal.path().to_owned();
        ioctl_fionbio(&*terminal.end(), true)?;
        board.set_nonblocking(true)?;
        if fs::symlink_metadata(name).is_ok_and(|found| found.is_symlink()) && !name.exists() {
            fs::remove_file(name)?;
        }
        symlink(&path, name)?;
        let is_closing = Arc::new(AtomicBool::new(false));
        let closing = is_closing.clone();
        let pump = thread::spawn(move || {
            // An end that fails has nothing more to say; the emulator tells its own end over the link.
            let _ = pump(terminal.end(), &board, &closing);
        });
        Ok(Self { name: name.to_owned(), terminal: path, is_closing, pump: Some(pump) })
    }

    /// The terminal behind the name.
    pub fn terminal(&self) -> &Path {
        &self.terminal
    }
}

impl Drop for Line {
    fn drop(&mut self) {
        self.is_closing.store(true, Ordering::Relaxed);
        if let Some(pump) = self.pump.take() {
            // It does not panic.
            let _ = pump.join();
        }
        // Somebody else may have put something else there.
        if fs::read_link(&self.name).is_ok_and(|target| target == self.terminal) {
            let _ = fs::remove_file(&self.name);
        }
    }
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
