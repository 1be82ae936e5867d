//! A board in the emulator with the rig's muscle, its bus a serial port, as long as it is wanted.

use std::path::{Path, PathBuf};
use std::process::Child;
use std::thread;
use std::time::{Duration, Instant};

use anyhow::{Context, Result, bail};
use rustix::process::{Pid, Signal, kill_process};

use crate::host;

/// How long the emulator may take to start.
const START: Duration = Duration::from_secs(30);
/// How long it may take to end.
const END: Duration = Duration::from_secs(5);

/// The running emulator.
pub struct Emulated {
    program: Child,
    port: PathBuf,
}

impl Emulated {
    /// Starts the emulator; its bus is a port of this path.
    ///
    /// # Errors
    /// It does not start.
    pub fn start(port: &Path) -> Result<Self> {
        let mut command = host::mgpi();
        command.args(["emulate", "--plant", "rig", "--port"]).arg(port);
        let program = command.spawn().context("cannot run mgpi")?;
        let mut emulated = Self { program, port: port.to_owned() };
        let deadline = Instant::now() + START;
        while !emulated.port.exists() {
            if let Some(status) = emulated.program.try_wait()? {
                bail!("the emulator has ended ({status})");
            }
            if Instant::now() > deadline {
                bail!("the emulator makes no serial port within {} s", START.as_secs());
            }
            thread::sleep(Duration::from_millis(50));
        }
        Ok(emulated)
    }
}

impl Drop for Emulated {
    fn drop(&mut self) {
        // Fails where it has ended already.
        let _ = kill_process(Pid::from_child(&self.program), Signal::TERM);
        let deadline = Instant::now() + END;
        while matches!(self.program.try_wait(), Ok(None)) && Instant::now() < deadline {
            thread::sleep(Duration::from_millis(20));
        }
        let _ = self.program.kill();
        let _ = self.program.wait();
    }
}
