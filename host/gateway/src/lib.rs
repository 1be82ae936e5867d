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
//! | `line` | a line's thread |
//! | `record` | everything that the boards tell, in a file |
//! | `lib` | the threads together |
//!
//! # Contract
//! A gateway drives nothing by itself: a board is started for a client, and a sign of life goes to
//! it with each set point of that client and with nothing else. So a board whose client, gateway or
//! line is gone vents within its own patience, as does one that another program has started.

pub mod boards;
pub mod clock;
pub mod driving;
pub mod line;
pub mod lines;
pub mod record;
pub mod seen;

use std::sync::mpsc::{RecvTimeoutError, Sender, channel};
use std::thread::{self, JoinHandle};
use std::time::Duration;

use crate::boards::Boards;
use crate::driving::{Driving, Refused, SetPoint};
use crate::line::{Ask, Order};
use crate::lines::Line;

/// How long an order may take: a line with a silent board gets to it within a round. Unit: s.
const ORDER: Duration = Duration::from_secs(2);

/// The threads of all lines, until it is dropped.
#[derive(Debug)]
pub struct Gateway {
    boards: Boards,
    driving: Driving,
    /// Those of the lines, and how many boards each has.
    orders: Vec<(usize, Sender<Order>)>,
    threads: Vec<JoinHandle<()>>,
}

impl Gateway {
    /// Starts a thread a line.
    pub fn start(lines: Vec<Line>) -> Self {
        let boards = Boards::of(&lines);
        let driving = Driving::of(boards.all().len());
        let (mut orders, mut threads, mut first) = (Vec::new(), Vec::new(), 0);
        for line in lines {
            let (sender, receiver) = channel();
            let (count, begin) = (line.boards.len(), first);
            let (all, driving) = (boards.clone(), driving.clone());
            orders.push((count, sender));
            threads.push(thread::spawn(move || line::run(&line, begin, &all, &driving, &receiver)));
            first += count;
        }
        Self { boards, driving, orders, threads }
    }

    /// All boards.
    pub fn boards(&self) -> &Boards {
        &self.boards
    }

    /// Stops and vents all boards of all lines.
    pub fn stop_all(&self) {
        self.driving.end_all();
        self.orders.iter().for_each(|(_, line)| {
            // A line whose thread has ended has no boards any more.
            let _ = line.send(Order::StopAll);
        });
    }

    /// Releases the latched fault of the board at this place among all.
    ///
    /// # Errors
    /// There is no such board, or it has not done so.
    pub fn acknowledge(&self, index: usize) -> Result<(), Refused> {
        self.ask(index, Ask::Acknowledge)
    }

    /// Stops and vents a board, whoever drives it.
    ///
    /// # Errors
    /// There is no such board, or it has not done so.
    pub fn stop(&self, index: usize) -> Result<(), Refused> {
        self.driving.end(index);
        self.ask(index, Ask::Stop)
    }

    /// Starts a board for a client, from where its muscle is; answers the grant that its set points
    /// have to carry. They have to come from now on.
    ///
    /// # Errors
    /// There is no such board, it is driven for somebody, or it is in no state to be started.
    pub fn start_board(&self, index: usize) -> Result<u32, Refused> {
        let grant = self.driving.grant(index)?;
        match self.ask(index, Ask::Start) {
            Ok(()) => Ok(grant),
            Err(refused) => {
                self.driving.end(index);
                Err(refused)
            }
        }
    }

    /// Takes a client's set point for a board.
    ///
    /// # Errors
    /// Why not; the board then goes on with what it has, as long as its patience lasts.
    pub fn set(&self, index: usize, point: SetPoint) -> Result<(), Refused> {
        self.driving.set(index, point)
    }

    fn ask(&self, index: usize, ask: Ask) -> Result<(), Refused> {
        let mut first = 0;
        for (count, line) in &self.orders {
            if index < first + count {
                let (told, done) = channel();
                if line.send(Order::One(index - first, ask, told)).is_err() {
                    return Err(Refused::Late);
                }
                return match done.recv_timeout(ORDER) {
                    Ok(done) => done.map_err(Refused::Board),
                    // A line without a port drops what it is asked.
                    Err(RecvTimeoutError::Timeout | RecvTimeoutError::Disconnected) => Err(Refused::Late),
                };
            }
            first += count;
        }
        Err(Refused::NoBoard)
    }
}

impl Drop for Gateway {
    fn drop(&mut self) {
        // Without their senders the threads end.
        self.orders.clear();
        for thread in self.threads.drain(..) {
            // One that panicked has nothing more to tell.
            let _ = thread.join();
        }
    }
}
