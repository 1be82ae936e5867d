//! All boards of all lines watched by one program: a thread a line asks its boards in turn for what
//! they measure, tells their clocks from this machine's with a bound, and passes orders on.
//!
//! # Design
//! | file | what it is |
//! |---|---|
//! | `lines` | the file that says which boards there are |
//! | `clock` | a board's ticks on this machine's clock, with a bound |
//! | `seen` | what a board tells |
//! | `boards` | all boards as they were last seen, shared |
//! | `driving` | who drives a board, and by which set point next |
//! | `trajectory` | a course of set points over time |
//! | `start` | its common start on several boards |
//! | `stream` | a trajectory on its way to a board |
//! | `line` | a line's thread |
//! | `record` | everything that the boards tell, in a file |
//! | `lib` | the threads together |
//!
//! # Contract
//! A gateway drives nothing by itself: a board is started for a client, and a sign of life goes to
//! it with each word of that client, of which all but those during a trajectory are set points, and
//! with nothing else. So a board whose client, gateway or
//! line is gone vents within its own patience, as does one that another program has started.

pub mod boards;
pub mod clock;
pub mod driving;
pub mod line;
pub mod lines;
pub mod record;
pub mod seen;
pub mod start;
pub mod stream;
pub mod trajectory;

use std::sync::mpsc::{Receiver, RecvTimeoutError, Sender, channel};
use std::sync::{Mutex, MutexGuard, PoisonError};
use std::thread::{self, JoinHandle};
use std::time::{Duration, Instant};

use crate::boards::{Board, Boards};
use crate::driving::{Driving, Refused, SetPoint};
use crate::line::{Ask, Order};
use crate::lines::{Group, Limits, Line, Lines, Member};
use crate::start::{Phase, Start};
use crate::trajectory::Trajectory;

/// How long an order may take: a line with a silent board gets to it within a round. Unit: s.
const ORDER: Duration = Duration::from_secs(2);
/// The least time from an order to a start: eight boards of a line at 115,200 bit/s have their points
/// within it. Unit: s.
const LEAD_S: f64 = 1.0;
/// The start of a trajectory that shall begin as soon as can be: with time for one round more. Unit: s.
const SOONEST_S: f64 = LEAD_S + 0.2;
/// The farthest start, by convention: a start beyond it is a wrong clock rather than a plan. Unit: s.
const FARTHEST_S: f64 = 60.0;

/// The threads of all lines, until it is dropped.
#[derive(Debug)]
pub struct Gateway {
    boards: Boards,
    driving: Driving,
    lines: Mutex<Running>,
}

/// What runs now.
#[derive(Debug, Default)]
struct Running {
    lines: Vec<RunningLine>,
    groups: Vec<Group>,
}

/// A line's thread.
#[derive(Debug)]
struct RunningLine {
    line: Line,
    /// Its boards among all.
    indices: Vec<usize>,
    orders: Sender<Order>,
    thread: JoinHandle<()>,
    /// That of the last trajectory on it.
    start: Option<Start>,
}

/// A part of a trajectory: which board, for whom it was started, and the points (s from the start
/// on, mm).
#[derive(Clone, Debug, PartialEq)]
pub struct Part {
    /// The board's place among all.
    pub index: usize,
    /// For whom it was started.
    pub grant: u32,
    /// Times and set points.
    pub points: Vec<(f64, f64)>,
}

impl Gateway {
    /// Starts a thread a line.
    pub fn start(lines: Lines) -> Self {
        let gateway =
            Self { boards: Boards::of(&lines.lines), driving: Driving::default(), lines: Mutex::default() };
        gateway.arrange(lines);
        gateway
    }

    /// These are the lines and groups from now on. A line whose port is as it was goes on, and so do
    /// those of its boards that stay; what is driven on a board that goes is stopped.
    pub fn arrange(&self, Lines { lines, groups }: Lines) {
        let mut running = self.running();
        let places = self.boards.arrange(&lines);
        let limits = |place: usize| {
            let of = |(line, places): (&Line, &Vec<usize>)| {
                let at = places.iter().position(|other| *other == place)?;
                line.boards.get(at).map(|member| member.limits)
            };
            lines.iter().zip(&places).find_map(of).unwrap_or_else(Limits::usual)
        };
        self.driving.limit((0..self.boards.all().len()).map(limits));
        let mut before = std::mem::take(&mut running.lines);
        let mut ended = Vec::new();
        // Ports that are no longer used are free before others are opened.
        for line in before.extract_if(.., |old| !lines.iter().any(|line| line.goes_on_from(&old.line))) {
            // It has ended already if this fails.
            let _ = line.orders.send(Order::Members(Vec::new()));
            drop(line.orders);
            ended.push(line.thread);
        }
        for thread in ended {
            // One that panicked has nothing more to tell.
            let _ = thread.join();
        }
        for (line, indices) in lines.into_iter().zip(places) {
            let members: Vec<_> = indices.iter().copied().zip(line.boards.iter().cloned()).collect();
            let old = before.iter().position(|old| line.goes_on_from(&old.line));
            running.lines.push(match old.map(|old| before.swap_remove(old)) {
                Some(old) if old.orders.send(Order::Members(members.clone())).is_ok() => {
                    RunningLine { line, indices, ..old }
                }
                _ => self.run(line, indices, members),
            });
        }
        running.groups = groups;
    }

    fn run(&self, line: Line, indices: Vec<usize>, members: Vec<(usize, Member)>) -> RunningLine {
        let (orders, receiver) = channel();
        let (address, exchange) = (line.address.clone(), line.exchange);
        let (all, driving) = (self.boards.clone(), self.driving.clone());
        let thread = thread::spawn(move || line::run(&address, exchange, members, &all, &driving, &receiver));
        RunningLine { line, indices, orders, thread, start: None }
    }

    /// All boards.
    pub fn boards(&self) -> &Boards {
        &self.boards
    }

    /// The groups: the name of each, and the places of its boards among all.
    pub fn groups(&self) -> Vec<(String, Vec<usize>)> {
        let boards = self.boards.all();
        let place = |name: &String| boards.iter().position(|board| !board.is_gone && board.name == *name);
        let places = |group: &Group| (group.name.clone(), group.boards.iter().filter_map(place).collect());
        self.running().groups.iter().map(places).collect()
    }

    /// The places of a group's boards; none if there is no such group.
    pub fn group(&self, name: &str) -> Vec<usize> {
        self.groups().into_iter().find(|(group, _)| group == name).map_or_else(Vec::new, |(_, places)| places)
    }

    /// The places of the boards that have this name: one, or those of a group; none if nobody has.
    pub fn named(&self, name: &str) -> Vec<usize> {
        let is_it = |board: &Board| !board.is_gone && board.name == name;
        if let Some(place) = self.boards.all().iter().position(is_it) {
            return vec![place];
        }
        self.group(name)
    }

    /// Stops and vents all boards of all lines.
    pub fn stop_all(&self) {
        self.driving.end_all();
        self.running().lines.iter().for_each(|line| {
            // A line whose thread has ended has no boards any more.
            let _ = line.orders.send(Order::StopAll);
        });
    }

    /// Releases the latched faults of these boards.
    ///
    /// # Errors
    /// The first that is not there, or has not done so; it is tried with each.
    pub fn acknowledge(&self, indices: &[usize]) -> Result<(), Refused> {
        self.ask(indices, Ask::Acknowledge)
    }

    /// Stops and vents boards, whoever drives them: all of a line by one order to all.
    ///
    /// # Errors
    /// The first that is not there, or has not done so; it is tried with each.
    pub fn stop(&self, indices: &[usize]) -> Result<(), Refused> {
        indices.iter().for_each(|index| self.driving.end(*index));
        if indices.len() > 1 {
            for line in &self.running().lines {
                if line.indices.iter().all(|index| indices.contains(index)) {
                    // What is not heard is asked of each below.
                    let _ = line.orders.send(Order::StopAll);
                }
            }
        }
        self.ask(indices, Ask::Stop)
    }

    /// Starts boards for a client, from where their muscles are; answers the grant that set points
    /// for them have to carry. They have to come from now on. All are started, or none is.
    ///
    /// # Errors
    /// One is not there, is driven for somebody, or is in no state to be started.
    pub fn start_boards(&self, indices: &[usize]) -> Result<u32, Refused> {
        let grant = self.driving.grant_all(indices)?;
        let asked: Vec<_> = indices.iter().map(|index| (*index, Ask::Start(grant))).collect();
        self.driving.vouch(indices, Some(Instant::now() + ORDER));
        let done = self.ask_each(&asked).into_iter().fold(Ok(()), Result::and);
        self.driving.vouch(indices, None);
        done.map(|()| grant).inspect_err(|_| {
            indices.iter().for_each(|index| self.driving.end(*index));
            if indices.len() > 1 {
                // Those that have started vent; one that has not refuses, which is as well.
                let _ = self.ask(indices, Ask::Stop);
            }
        })
    }

    /// Starts boards for a client, each by a grant of its own, as far as they are in a state to be
    /// started; answers for each when all have been tried.
    pub fn start_each(&self, indices: &[usize]) -> Vec<Result<u32, Refused>> {
        let grants: Vec<_> = indices.iter().map(|index| (*index, self.driving.grant(*index))).collect();
        let (asked, granted): (Vec<_>, Vec<_>) = (grants.iter())
            .filter_map(|(index, grant)| Some(((*index, Ask::Start(*grant.as_ref().ok()?)), *index)))
            .unzip();
        self.driving.vouch(&granted, Some(Instant::now() + ORDER));
        let mut done = self.ask_each(&asked).into_iter();
        self.driving.vouch(&granted, None);
        let told = |(index, grant): (usize, Result<u32, Refused>)| {
            let grant = grant?;
            let done = done.next().unwrap_or(Err(Refused::Late));
            done.map(|()| grant).inspect_err(|_| self.driving.end(index))
        };
        grants.into_iter().map(told).collect()
    }

    /// Takes a client's set point for a board.
    ///
    /// # Errors
    /// Why not; the board then goes on with what it has, as long as its patience lasts.
    pub fn set(&self, index: usize, point: SetPoint) -> Result<(), Refused> {
        self.driving.set(index, point)
    }

    /// Takes a trajectory for one or several boards, which begin at once; all of them or none. The
    /// start is `at_s` since the gateway's start, or as soon as can be. Answers when it is. Unit: s.
    ///
    /// # Errors
    /// The first board that may not, and why; nothing has changed then.
    pub fn play(&self, parts: Vec<Part>, at_s: Option<f64>) -> Result<f64, (usize, Refused)> {
        let first = parts.first().ok_or((0, Refused::NoBoard))?.index;
        let now_s = Boards::now_s();
        let at_s = at_s.unwrap_or(now_s + SOONEST_S);
        let in_s = at_s - now_s;
        let at = if in_s < 0.0 {
            Err(Refused::Past { by_s: -in_s })
        } else if in_s < LEAD_S {
            Err(Refused::Soon { in_s, lead_s: LEAD_S })
        } else if in_s <= FARTHEST_S {
            Ok(())
        } else {
            Err(Refused::Far { in_s, most_s: FARTHEST_S })
        };
        at.map_err(|refused| (first, refused))?;
        let boards = self.boards.all();
        let mut running = self.running();
        let mut checked = Vec::new();
        for Part { index, grant, points } in parts {
            let check = || -> Result<_, Refused> {
                let limits = self.driving.may_play(index, grant)?;
                let board = boards.get(index).filter(|board| !board.is_gone).ok_or(Refused::NoBoard)?;
                let told = board.telemetry.as_ref().filter(|_| board.problem.is_none());
                let before_mm = told.and_then(|told| told.reference_mm).ok_or(Refused::NotTracking)?;
                if checked.iter().any(|(_, other, _)| *other == index) {
                    return Err(Refused::Twice);
                }
                let trajectory = Trajectory::of(points, &limits, before_mm)?;
                let line = running.lines.iter().position(|line| line.indices.contains(&index));
                let line = line.ok_or(Refused::NoBoard)?;
                if running.lines.get(line).is_some_and(|line| line.waits(now_s)) {
                    return Err(Refused::LineWaits);
                }
                Ok((line, index, trajectory))
            };
            checked.push(check().map_err(|refused| (index, refused))?);
        }
        let start = Start::of(checked.len(), at_s);
        for (line, index, trajectory) in checked {
            let Some(line) = running.lines.get_mut(line) else { continue };
            line.start = Some(start.clone());
            self.driving.plays(index, true);
            if line.orders.send(Order::Play(index, trajectory, start.clone())).is_err() {
                start.give_up("a line has ended".to_owned());
            }
        }
        Ok(at_s)
    }

    /// Asks boards for something, all lines at once; waits for all.
    fn ask(&self, indices: &[usize], ask: Ask) -> Result<(), Refused> {
        let asked: Vec<_> = indices.iter().map(|index| (*index, ask)).collect();
        // Each is waited for, whatever the others say.
        self.ask_each(&asked).into_iter().fold(Ok(()), Result::and)
    }

    /// The same, each for something of its own; what has become of each.
    fn ask_each(&self, asked: &[(usize, Ask)]) -> Vec<Result<(), Refused>> {
        let sent: Vec<_> = {
            let running = self.running();
            let one = |&(index, ask): &(usize, Ask)| -> Result<_, Refused> {
                let line = running.lines.iter().find(|line| line.indices.contains(&index));
                let line = line.ok_or(Refused::NoBoard)?;
                let (told, done) = channel();
                line.orders.send(Order::One(index, ask, told)).map_err(|_| Refused::Late)?;
                Ok(done)
            };
            asked.iter().map(one).collect()
        };
        let until = Instant::now() + ORDER;
        let wait = |sent: Result<Receiver<Result<(), String>>, Refused>| -> Result<(), Refused> {
            match sent?.recv_timeout(until.saturating_duration_since(Instant::now())) {
                Ok(done) => done.map_err(Refused::Board),
                // A line without a port drops what it is asked.
                Err(RecvTimeoutError::Timeout | RecvTimeoutError::Disconnected) => Err(Refused::Late),
            }
        };
        sent.into_iter().map(wait).collect()
    }

    fn running(&self) -> MutexGuard<'_, Running> {
        // What a thread that panicked left is whole: lines are put in one by one.
        self.lines.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

impl RunningLine {
    /// Whether a trajectory on it has not begun.
    fn waits(&self, now_s: f64) -> bool {
        let is_ahead = |start: &Start| now_s < start.at_s && !matches!(start.phase(), Phase::GivenUp(_));
        self.start.as_ref().is_some_and(is_ahead)
    }
}

impl Drop for Gateway {
    fn drop(&mut self) {
        let lines = std::mem::take(&mut self.running().lines);
        // Without their senders the threads end.
        let threads: Vec<_> = lines.into_iter().map(|line| line.thread).collect();
        for thread in threads {
            // One that panicked has nothing more to tell.
            let _ = thread.join();
        }
    }
}
