//! A pseudo terminal: a serial port whose other end is a program of this machine.

use std::fs::File;
use std::io;
use std::os::fd::AsRawFd;
use std::path::{Path, PathBuf};

use rustix::io::{FdFlags, fcntl_setfd};
use rustix::pty::{OpenptFlags, grantpt, openpt, ptsname, unlockpt};
use rustix::termios::{OptionalActions, tcgetattr, tcsetattr};

/// A terminal that lives while it is kept, whoever opens and closes its port meanwhile.
#[derive(Debug)]
pub struct PseudoTerminal {
    end: File,
    path: PathBuf,
    /// Kept open, so that the program's end lives while nobody uses the port.
    port: File,
}

impl PseudoTerminal {
    /// A raw terminal: nothing is echoed or changed.
    ///
    /// # Errors
    /// The system has none left.
    pub fn open() -> io::Result<Self> {
        let end = openpt(OpenptFlags::RDWR | OpenptFlags::NOCTTY)?;
        // Programs that are started meanwhile do not keep it alive.
        fcntl_setfd(&end, FdFlags::CLOEXEC)?;
        grantpt(&end)?;
        unlockpt(&end)?;
        let path = PathBuf::from(ptsname(&end, Vec::new())?.to_string_lossy().into_owned());
        let port = File::options().read(true).write(true).open(&path)?;
        let mut settings = tcgetattr(&port)?;
        settings.make_raw();
        tcsetattr(&port, OptionalActions::Now, &settings)?;
        Ok(Self { end: end.into(), path, port })
    }

    /// The program's end.
    pub fn end(&mut self) -> &mut File {
        &mut self.end
    }

    /// What others open.
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// The same by way of this program, so that it leads nowhere as soon as this program has ended:
    /// the terminal's own path may be another terminal's by then.
    pub fn path_of_this_program(&self) -> PathBuf {
        format!("/proc/{}/fd/{}", std::process::id(), self.port.as_raw_fd()).into()
    }
}
