//! `mgpi emulate`: the firmware in the emulator, by hand, or as a board on its bus.

use std::io::{BufRead, BufReader};
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use std::thread;

use clap::Args;

use super::background;
use super::plant::PlantArguments;
use crate::Error;
use board_client::child::{ChildGroup, WAIT_SLICE};
use board_client::emulator::image::Image;
use board_client::emulator::line::Line;
use board_client::emulator::log::LogDecoder;
use board_client::emulator::{Emulator, EmulatorError, image, qemu, real_time};
use board_client::pil::plant::PlantProcess;
use board_client::pil::{PilError, lock_step};
use board_client::stop::Stop;

/// Runs the firmware in the emulator until Ctrl-C: as a board with a plant, in real time, whose bus
/// is a serial port of this machine; or, without --port, with its service link open to other
/// programs and its log shown.
#[derive(Args, Debug)]
pub struct Arguments {
    /// Makes the board's bus a serial port of this name, a path
    #[arg(long, value_name = "PORT")]
    port: Option<PathBuf>,
    #[command(flatten)]
    plant: PlantArguments,
    /// The firmware's ELF file [default: that of MGPI_FIRMWARE, else the one built beside this
    /// program, else the one in it]
    #[arg(long, value_name = "ELF")]
    firmware: Option<PathBuf>,
    /// Go on in the background: the command returns as soon as the board answers, and --stop ends
    /// the emulator
    #[arg(long, requires = "port")]
    background: bool,
    /// End the emulator that has this port
    #[arg(long, requires = "port", conflicts_with_all = ["background", "ready_fd"])]
    stop: bool,
    /// Write the line `ready` to this open file descriptor as soon as the board answers
    #[arg(long, value_name = "FD", requires = "port", conflicts_with = "background")]
    ready_fd: Option<u32>,
}

/// Runs the firmware.
///
/// # Errors
/// There is no firmware, or the emulator cannot be started or ends by itself.
pub fn run(arguments: &Arguments) -> Result<(), Error> {
    match &arguments.port {
        Some(port) if arguments.stop => background::end(port),
        Some(_) if arguments.background => background::start(),
        Some(port) => on_bus(port, arguments),
        None => by_link(&image::find(arguments.firmware.as_deref())?),
    }
}

/// Runs the board in real time, on a serial port of this name.
fn on_bus(port: &Path, Arguments { plant, firmware, ready_fd, .. }: &Arguments) -> Result<(), Error> {
    let elf = image::find(firmware.as_deref())?;
    on_line(port, &elf, plant, &Stop::on_signals(), |line| {
        if line.has_replaced() {
            say!("{}: was left by an emulator that was killed, and is replaced", port.display());
        }
        say!("serial port {} ({}); Ctrl-C ends the emulator", port.display(), line.terminal().display());
        background::tell_ready(*ready_fd)
    })
}

/// Runs a board with this plant on a serial port of this name until a stop is requested; `ready` is
/// called as soon as the port is there.
///
/// # Errors
/// Emulator, plant or port cannot be started, or end by themselves.
pub fn on_line(
    port: &Path,
    elf: &Image,
    arguments: &PlantArguments,
    stop: &Stop,
    ready: impl FnOnce(&Line) -> Result<(), Error>,
) -> Result<(), Error> {
    let mut plant = PlantProcess::start(&arguments.program(), stop).map_err(PilError::from)?;
    let (mut board, bus) = Emulator::start_with_bus(elf, stop)?;
    lock_step::protect(&mut board, arguments.protection(real_time::PERIOD.as_secs_f32()))?;
    let refused = |problem| EmulatorError::Line { name: port.to_owned(), problem };
    let line = Line::open(port, bus).map_err(refused)?;
    ready(&line)?;
    let run = real_time::run(&mut board, &mut plant, stop, |late| {
        say!(
            "this machine is slow: a tick came {:.2} s late. The board's time then passes more slowly than that of the \
             wall; recordings and logs are in the board's time, and stay right",
            late.as_secs_f64()
        );
    });
    match run {
        Err(PilError::Stopped) => Ok(()),
        other => Ok(other?),
    }
}

/// Runs the firmware with its link open to other programs.
fn by_link(elf: &Path) -> Result<(), Error> {
    let decoder = LogDecoder::of(elf).map_err(EmulatorError::Log)?;
    let stop = Stop::on_signals();
    let mut emulator = qemu(elf, "null");
    emulator.args(["-chardev", "pty,id=link"]);
    // QEMU names the port in the first line of its standard output, which it keeps back when that
    // is no terminal.
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
