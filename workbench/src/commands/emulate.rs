//! `mgpi emulate`: the firmware in the emulator, by hand.

use std::path::PathBuf;
use std::process::Stdio;
use std::thread;

use clap::Args;

use crate::Error;
use crate::child::{ChildGroup, Stop, WAIT_SLICE};
use crate::emulator::log::LogDecoder;
use crate::emulator::{EmulatorError, image, qemu};

/// Runs the firmware in the emulator, its serial port open to other programs, until Ctrl-C; shows its log.
#[derive(Args, Debug)]
pub struct Arguments {
    /// The firmware's ELF file [default: that of MGPI_FIRMWARE, else the one built beside this program]
    #[arg(long, value_name = "ELF")]
    firmware: Option<PathBuf>,
}

/// Runs the firmware.
///
/// # Errors
/// There is no firmware, or the emulator cannot be started or ends by itself.
pub fn run(arguments: &Arguments) -> Result<(), Error> {
    let elf = image::find(arguments.firmware.as_deref())?;
    let decoder = LogDecoder::of(&elf).map_err(EmulatorError::Log)?;
    let stop = Stop::on_signals();
    let mut command = qemu(&elf);
    command.args(["-chardev", "pty,id=link"]).stdin(Stdio::null()).stdout(Stdio::piped());
    let mut group = ChildGroup::spawn(&mut command).map_err(EmulatorError::NotStarted)?;
    let (_, log) = group.pipes();
    thread::scope(|scope| {
        if let Some(log) = log {
            // Ends with the emulator; a log that cannot be read is no reason to end it.
            scope.spawn(|| decoder.follow(log, |entry| say!("{entry}")));
        }
        let ended = wait(&mut group, &stop);
        drop(group);
        ended
    })
}

/// Until the emulator ends, which is an error, or a stop is requested. Says where the port is as soon as QEMU does.
fn wait(group: &mut ChildGroup, stop: &Stop) -> Result<(), Error> {
    let mut announced = false;
    while !stop.is_requested() {
        if !announced && let Some(port) = port(&group.messages()) {
            say!("serial port {port}; Ctrl-C ends the emulator");
            announced = true;
        }
        if !group.is_running() {
            return Err(EmulatorError::Ended(group.end()).into());
        }
        thread::sleep(WAIT_SLICE);
    }
    Ok(())
}

/// The port in QEMU's "char device redirected to /dev/pts/3 (label link)".
fn port(messages: &str) -> Option<&str> {
    messages.lines().find_map(|line| line.split_once("redirected to ")?.1.split_whitespace().next())
}
