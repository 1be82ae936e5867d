//! `mgpi fleet`: many boards without hardware.

use std::path::{Path, PathBuf};
use std::sync::mpsc::channel;
use std::thread::{self, JoinHandle};
use std::time::Duration;
use std::{fs, io};

use ::fleet::{Fleet, LARGEST_UNIT, Setting, line_name};
use ::rig::effect::Hide;
use board_client::child::WAIT_SLICE;
use board_client::emulator::{EmulatorError, image};
use board_client::stop::Stop;
use clap::Args;
use wire::Protection;

use super::plant::PlantArguments;
use super::{background, emulate};
use crate::Error;

/// A delay of a tick that is worth a word: what is later is not made up for.
const LATE: Duration = Duration::from_millis(50);

/// Runs many boards without hardware until Ctrl-C: the firmware's library on this machine, each
/// board with a simulated muscle of its own, in real time. The lines are serial ports `line-1`,
/// `line-2` and so on in a directory; the boards have the numbers from 1 on, over all lines. As on
/// a real board a model is deployed first, and the monitors are on. What a board is told to keep
/// is lost with the fleet.
#[derive(Args, Debug)]
pub struct Arguments {
    /// The directory for the ports; it is made if it is not there
    #[arg(value_name = "DIRECTORY")]
    directory: PathBuf,
    /// Number of boards, 1 to 247
    #[arg(long, default_value_t = 16, value_name = "N")]
    boards: u8,
    /// Number of lines
    #[arg(long, default_value_t = 4, value_name = "N")]
    lines: u8,
    /// Number of boards more whose firmware runs in the emulator: each is number 1 of a line of its
    /// own, behind the others
    #[arg(long, default_value_t = 0, value_name = "N")]
    emulated: u8,
    /// Seed of the first board's muscle; the others have those that follow
    #[arg(long, default_value_t = 1)]
    seed: u64,
    /// What to hide in each muscle: effects joined by `+`, `random` or `random-pair`
    #[arg(long, value_name = "EFFECT[+EFFECT]")]
    hide: Option<Hide>,
    /// Run the boards without the monitors of their muscles
    #[arg(long)]
    no_monitors: bool,
    /// Go on in the background: the command returns as soon as the ports are there, and --stop ends
    /// the boards
    #[arg(long)]
    background: bool,
    /// End the boards that have their ports in this directory
    #[arg(long, conflicts_with_all = ["background", "ready_fd"])]
    stop: bool,
    /// Write the line `ready` to this open file descriptor as soon as the ports are there
    #[arg(long, value_name = "FD", conflicts_with = "background")]
    ready_fd: Option<u32>,
}

/// Runs the boards, or ends them.
///
/// # Errors
/// As [`on_lines`]; there are none to end.
pub fn run(arguments: &Arguments) -> Result<(), Error> {
    if arguments.stop {
        end(&arguments.directory)
    } else if arguments.background {
        background::start()
    } else {
        on_lines(arguments)
    }
}

/// Ends the boards, and removes the names of those that were killed.
///
/// # Errors
/// There are none.
fn end(directory: &Path) -> Result<(), Error> {
    let is_there = |name: &PathBuf| name.symlink_metadata().is_ok();
    background::end(&line_name(directory, 1))?;
    let mut left = (2..=LARGEST_UNIT).map(|line| line_name(directory, line)).filter(is_there);
    left.try_for_each(|name| background::end(&name))
}

/// Runs the boards until a stop is requested.
///
/// # Errors
/// The numbers are not possible, the ports cannot be made, or the boards of a line end by
/// themselves.
fn on_lines(arguments: &Arguments) -> Result<(), Error> {
    let &Arguments { boards, lines, seed, no_monitors, .. } = arguments;
    let stop = Stop::on_signals();
    let protection = if no_monitors { Protection::SIMULATED } else { Protection::STANDARD };
    let setting = Setting { boards, lines, seed, hide: arguments.hide.clone(), protection };
    setting.check()?;
    let refused = |problem| EmulatorError::Line { name: arguments.directory.clone(), problem };
    fs::create_dir_all(&arguments.directory).map_err(refused)?;
    let mut fleet = Fleet::start(&arguments.directory, &setting)?;
    let emulated = (1..=arguments.emulated)
        .map(|number| {
            let port = line_name(&arguments.directory, lines.saturating_add(number));
            Emulated::start(port, PlantArguments::built_in(arguments.hide.clone(), no_monitors), &stop)
        })
        .filter_map(Result::transpose)
        .collect::<Result<Vec<_>, _>>()?;
    for (port, units) in fleet.lines() {
        let numbers = match units {
            [one] => format!("board {one}"),
            [first, .., last] => format!("boards {first} to {last}"),
            [] => continue,
        };
        say!("{}: {numbers}", port.display());
    }
    for Emulated { port, .. } in &emulated {
        say!("{}: board 1, in the emulator", port.display());
    }
    say!("Ctrl-C ends the boards");
    background::tell_ready(arguments.ready_fd)?;
    let mut is_told = false;
    while !stop.is_requested() {
        fleet.check()?;
        if emulated.iter().any(|board| board.thread.is_finished()) {
            break;
        }
        let delay = fleet.longest_delay();
        if delay > LATE && !is_told {
            say!(
                "this machine is slow: a tick came {:.2} s late, and the time of a line's boards passes more slowly \
                 than that of the wall",
                delay.as_secs_f64()
            );
            is_told = true;
        }
        thread::sleep(WAIT_SLICE);
    }
    // The others go on until these have ended.
    stop.request();
    emulated.into_iter().try_for_each(Emulated::end)?;
    say!("the latest tick came {:.1} ms late", 1e3 * fleet.longest_delay().as_secs_f64());
    Ok(())
}

/// A board in the emulator, on a line of its own.
struct Emulated {
    port: PathBuf,
    thread: JoinHandle<Result<(), Error>>,
}

impl Emulated {
    /// Starts one, and waits until its port is there; none where a stop comes before.
    ///
    /// # Errors
    /// There is no firmware, or the emulator cannot be started.
    fn start(port: PathBuf, plant: PlantArguments, stop: &Stop) -> Result<Option<Self>, Error> {
        let elf = image::find(None)?;
        let (told, is_ready) = channel();
        let (name, stop) = (port.clone(), stop.clone());
        let thread = thread::spawn(move || {
            emulate::on_line(&name, &elf, &plant, &stop, |_| {
                // Who waits for it is there.
                let _ = told.send(());
                Ok(())
            })
        });
        let board = Self { port, thread };
        // Without a word it has ended, and says why.
        match is_ready.recv() {
            Ok(()) => Ok(Some(board)),
            Err(_) => board.end().map(|()| None),
        }
    }

    /// Waits until it has ended.
    ///
    /// # Errors
    /// It has ended by itself; why.
    fn end(self) -> Result<(), Error> {
        let panicked = |_| io::Error::other("it has panicked");
        let refused = |problem| EmulatorError::Line { name: self.port, problem };
        self.thread.join().map_err(panicked).map_err(refused)?
    }
}
