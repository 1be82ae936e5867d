//! Boards without hardware, many of them: the firmware's library on the host, each with a muscle of
//! the rig, several on a line, each line a serial port of this machine.
//!
//! # Design
//! | file | what it is |
//! |---|---|
//! | `board` | a board: the control law, the bus and the link of the firmware, tick by tick |
//! | `images` | its two places for images, in memory |
//! | `line` | boards on one line and the muscles that they drive, in time |
//! | `lib` | a fleet: lines by names, a thread each |
//!
//! # Timing contract
//! A thread a line makes up for ticks that are late by up to 50 ms; what is later is lost, and the
//! time of the line's boards slips against that of the wall ([`Fleet::longest_delay`]). Answers
//! come as late as their bytes, and those of the request, would take at the rate that the boards
//! have. The ports themselves have no rate: one that is opened at another rate is understood.
//!
//! # Limits
//! No analogue side, no processor: what the emulator and the model of the chip show stays unseen.
//! What a board keeps is lost with the fleet.

pub mod board;
pub mod images;
pub mod line;

use std::io;
use std::os::unix::net::UnixStream;
use std::path::{Path, PathBuf};
use std::thread::{self, JoinHandle};
use std::time::Duration;

use board_client::emulator::line::Line as Port;
use board_client::stop::Stop;
use rig::effect::Hide;
use rig::effects::Effects;
use rig::parameters::DEAD_LOAD_N;
use rig::plant::{Kind, Plant, Setup};
use thiserror::Error;
use wire::Protection;

use crate::board::Board;
use crate::line::{Driven, Pace, Watch};

/// The largest number of a board.
pub const LARGEST_UNIT: u8 = 247;

/// How strongly an effect is hidden: plainly visible.
const STRENGTH: f64 = 1.0;

/// What a fleet is made of.
#[derive(Clone, Debug)]
pub struct Setting {
    /// How many boards there are; they have the numbers from 1 on.
    pub boards: u8,
    /// On how many lines they are, as evenly as can be.
    pub lines: u8,
    /// Seed of the first board's muscle; the others have those that follow.
    pub seed: u64,
    /// What is hidden in the muscles.
    pub hide: Option<Hide>,
    /// What the boards protect themselves by.
    pub protection: Protection,
}

impl Setting {
    /// Looks whether a fleet can be like that.
    ///
    /// # Errors
    /// There are no such numbers of boards or lines.
    pub fn check(&self) -> Result<(), FleetError> {
        let &Self { boards, lines, .. } = self;
        if !(1..=LARGEST_UNIT).contains(&boards) {
            return Err(FleetError::Boards { boards });
        }
        if !(1..=boards).contains(&lines) {
            return Err(FleetError::Lines { lines, boards });
        }
        Ok(())
    }
}

/// Why there is no fleet.
#[derive(Debug, Error)]
#[allow(missing_docs, reason = "the messages say what the variants and their fields are")]
pub enum FleetError {
    #[error("{boards} boards are not in 1 to {LARGEST_UNIT}, the numbers of a bus")]
    Boards { boards: u8 },
    #[error("{lines} lines are not in 1 to {boards}, the number of boards")]
    Lines { lines: u8, boards: u8 },
    #[error("{}: no serial port can be made there: {problem}", name.display())]
    Port { name: PathBuf, problem: io::Error },
    #[error("{}: its boards have ended: {problem}", name.display())]
    Ended { name: PathBuf, problem: io::Error },
}

/// Lines of boards, until they are dropped.
#[derive(Debug)]
pub struct Fleet {
    lines: Vec<FleetLine>,
    stop: Stop,
}

/// A line of a fleet.
#[derive(Debug)]
struct FleetLine {
    name: PathBuf,
    units: Vec<u8>,
    watch: Watch,
    /// Goes before the boards do.
    port: Option<Port>,
    boards: Option<JoinHandle<io::Result<()>>>,
}

impl Fleet {
    /// Starts boards on lines `line-1`, `line-2` and so on of a directory.
    ///
    /// # Errors
    /// The numbers are not possible, or the ports are not.
    pub fn start(directory: &Path, setting: &Setting) -> Result<Self, FleetError> {
        setting.check()?;
        let &Setting { boards, lines, .. } = setting;
        let mut fleet = Self { lines: Vec::new(), stop: Stop::default() };
        for line in 0..lines {
            let share = |line: u8| (u16::from(line) * u16::from(boards) / u16::from(lines)) as u8;
            let units: Vec<u8> = (share(line) + 1..=share(line + 1)).collect();
            let name = line_name(directory, line + 1);
            let started = fleet.add(&name, units, setting);
            started.map_err(|problem| FleetError::Port { name, problem })?;
        }
        Ok(fleet)
    }

    fn add(&mut self, name: &Path, units: Vec<u8>, setting: &Setting) -> io::Result<()> {
        let (mut ours, theirs) = UnixStream::pair()?;
        let port = Port::open(name, theirs)?;
        let (watch, stop) = (Watch::default(), self.stop.clone());
        let (told, members, setting) = (watch.clone(), units.clone(), setting.clone());
        let boards = thread::Builder::new().name(name.display().to_string()).spawn(move || {
            // Made where they run: neither a plant nor a control may change its thread.
            let mut boards: Vec<Driven> = members.into_iter().map(|unit| driven(unit, &setting)).collect();
            line::run(&mut ours, &mut boards, Pace::REAL, &stop, &told, |_, bytes| bytes)
        })?;
        let name = name.to_owned();
        self.lines.push(FleetLine { name, units, watch, port: Some(port), boards: Some(boards) });
        Ok(())
    }

    /// The lines: the name of each, and the numbers of its boards.
    pub fn lines(&self) -> impl Iterator<Item = (&Path, &[u8])> {
        self.lines.iter().map(|line| (&*line.name, &*line.units))
    }

    /// By how much a tick of the line that was late the most has been late.
    pub fn longest_delay(&self) -> Duration {
        self.lines.iter().map(|line| line.watch.longest_delay()).max().unwrap_or_default()
    }

    /// Looks whether all lines are at work.
    ///
    /// # Errors
    /// One has ended; why.
    pub fn check(&mut self) -> Result<(), FleetError> {
        for line in &mut self.lines {
            if line.boards.as_ref().is_some_and(JoinHandle::is_finished)
                && let Some(boards) = line.boards.take()
            {
                let problem = match boards.join() {
                    Ok(Err(problem)) => problem,
                    Ok(Ok(())) | Err(_) => io::Error::other("they have panicked"),
                };
                return Err(FleetError::Ended { name: line.name.clone(), problem });
            }
        }
        Ok(())
    }
}

impl Drop for Fleet {
    fn drop(&mut self) {
        // The first line's goes last: who waits for it finds none of the others.
        for line in self.lines.iter_mut().rev() {
            line.port.take();
        }
        self.stop.request();
        for boards in self.lines.iter_mut().filter_map(|line| line.boards.take()) {
            // What went wrong in one is told while the fleet is at work.
            let _ = boards.join();
        }
    }
}

/// The port of a line; the first is 1.
pub fn line_name(directory: &Path, line: u8) -> PathBuf {
    directory.join(format!("line-{line}"))
}

/// A board of this number with its muscle.
fn driven(unit: u8, Setting { seed, hide, protection, .. }: &Setting) -> Driven {
    let seed = seed.wrapping_add(u64::from(unit) - 1);
    let hidden = hide.as_ref().map(|hide| hide.effects(seed)).unwrap_or_default();
    let effects = Effects::drawn(&hidden, STRENGTH, seed);
    let plant = Plant::new(&Setup { kind: Kind::Rig, effects, seed, load_n: DEAD_LOAD_N, noise: true });
    Driven::new(Board::of_number(unit, *protection), plant)
}
