//! A board in the emulator with the rig's muscle, its bus a serial port, as long as it is wanted.

use std::path::{Path, PathBuf};

use anyhow::Result;

use crate::{host, run};

/// The running emulator.
pub struct Emulated {
    port: PathBuf,
}

impl Emulated {
    /// Starts the emulator; its bus is a port of this path, where the board answers when this
    /// returns.
    ///
    /// # Errors
    /// It does not start.
    pub fn start(port: &Path) -> Result<Self> {
        run::succeed(host::mgpi().args(["emulate", "--background", "--port"]).arg(port))?;
        Ok(Self { port: port.to_owned() })
    }
}

impl Drop for Emulated {
    fn drop(&mut self) {
        // One that has ended by itself has said why.
        let _ = run::succeed(host::mgpi().args(["emulate", "--stop", "--port"]).arg(&self.port));
    }
}
