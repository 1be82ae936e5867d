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
//! | `line` | a line's thread |
//! | `lib` | the threads together |
//!
//! # Contract
//! A gateway drives nothing: it opens no valve and sends no heartbeat, so that a board that another
//! program started by the same line vents within its own patience. What it sends beside questions
//! are stops and acknowledgements.

pub mod boards;
pub mod clock;
pub mod line;
pub mod lines;
pub mod seen;

use std::sync::mpsc::{Sender, channel};
use std::thread::{self, JoinHandle};

use crate::boards::Boards;
use crate::line::Order;
use crate::lines::Line;

/// The threads of all lines, until it is dropped.
#[derive(Debug)]
pub struct Gateway {
    boards: Boards,
    /// Those of the lines, and how many boards each has.
    orders: Vec<(usize, Sender<Order>)>,
    threads: Vec<JoinHandle<()>>,
}

impl Gateway {
    /// Starts a thread a line.
    pub fn start(lines: Vec<Line>) -> Self {
        let boards = Boards::of(&lines);
        let (mut orders, mut threads, mut first) = (Vec::new(), Vec::new(), 0);
        for line in lines {
            let (sender, receiver) = channel();
            let (count, begin, all) = (line.boards.len(), first, boards.clone());
            orders.push((count, sender));
            threads.push(thread::spawn(move || line::run(&line, begin, &all, &receiver)));
            first += count;
        }
        Self { boards, orders, threads }
    }

    /// All boards.
    pub fn boards(&self) -> &Boards {
        &self.boards
    }

    /// Stops and vents all boards of all lines.
    pub fn stop_all(&self) {
        self.orders.iter().for_each(|(_, line)| {
            // A line whose thread has ended has no boards any more.
            let _ = line.send(Order::StopAll);
        });
    }

    /// Releases the latched fault of the board at this place among all; whether there is one.
    pub fn acknowledge(&self, index: usize) -> bool {
        let mut first = 0;
        for (count, line) in &self.orders {
            if index < first + count {
                return line.send(Order::Acknowledge(index - first)).is_ok();
            }
            first += count;
        }
        false
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
