//! Does every task still run? The hardware watchdog is fed by the tick, and only while all others
//! have checked in lately.
//!
//! A task that stops checking in is a fault at once, and vents; since the hardware watchdog is then
//! no longer fed, a reset follows. A tick that stops by itself feeds nothing either.

use core::sync::atomic::{AtomicU8, Ordering};

use wire::fault::times::ALLOWANCE_TICKS;

/// A task other than the tick.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Task {
    /// Receives and answers.
    Link = 0,
    /// What runs when nothing else does.
    Supervisor = 1,
}

/// Number of tasks.
const TASKS: usize = 2;

/// Where tasks check in, from any priority.
#[derive(Debug, Default)]
pub struct CheckIns(AtomicU8);

impl CheckIns {
    /// Nobody has checked in.
    pub const fn new() -> Self {
        Self(AtomicU8::new(0))
    }

    /// The task runs.
    pub fn check_in(&self, task: Task) {
        self.0.fetch_or(1 << task as u8, Ordering::Relaxed);
    }
}

/// The tick's view of the others.
#[derive(Debug, Default)]
pub struct Watchdog {
    silent_ticks: [u16; TASKS],
}

impl Watchdog {
    /// Takes a tick; answers whether all tasks run, and so whether the hardware is to be fed.
    pub fn is_content(&mut self, check_ins: &CheckIns) -> bool {
        let heard = check_ins.0.swap(0, Ordering::Relaxed);
        for (task, silent) in self.silent_ticks.iter_mut().enumerate() {
            *silent = if heard >> task & 1 == 1 { 0 } else { silent.saturating_add(1) };
        }
        self.silent_ticks.iter().all(|silent| *silent <= ALLOWANCE_TICKS)
    }
}
