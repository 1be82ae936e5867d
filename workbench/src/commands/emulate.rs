//! `mgpi emulate`: the firmware in the emulator, by hand.

use std::io::{BufRead, BufReader};
use std::path::PathBuf;
use std::process::{Command, Stdio};
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
    let mut emulator = qemu(&elf);
    emulator.args(["-chardev", "pty,id=link"]);
    // QEMU names the port in the first line of its standard output, which it keeps back when that is no terminal.
    let mut command = Command::new("stdbuf");
    command.arg("-oL").arg(emulator.get_program()).args(emulator.get_args());
    command.stdin(Stdio::null()).stdout(Stdio::piped());
    let mut group = ChildGroup::spawn(&mut command).map_err(EmulatorError::NotStarted)?;
    let (_, output) = group.pipes();
    thread::scope(|scope| {
        if let Some(output) = output {
            // Ends with the emulator; a log that cannot be read is no reason to end it.
            scope.spawn(|| {
                let mut output = BufReader::new(output);
                let mut line = String::new();
                if output.read_line(&mut line).is_ok()
                    && let Some(port) = port(&line)
                {
                    say!("serial port {port}; Ctrl-C ends the emulator");
                }
                decoder.follow(output, |entry| say!("{entry}"))
            });
        }
        let ended = wait(&mut group, &stop);
        drop(group);
        ended
    })
}

/// Until the emulator ends, which is an error, or a stop is requested.
fn wait(group: &mut ChildGroup, stop: &Stop) -> Result<(), Error> {
    while !stop.is_requested() {
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
