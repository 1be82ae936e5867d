//! The common start of a trajectory on several boards: all of them or none.
//!
//! # Contract
//! Each board is prepared by its line's thread. As soon as all are, the lines count down to the one
//! moment. Where one is not in time, or cannot be, the start is given up, for all of them.

use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

/// A start, shared by the lines that have a part in it.
#[derive(Clone, Debug)]
pub struct Start {
    /// When, since the gateway's start. Unit: s.
    pub at_s: f64,
    phase: Arc<Mutex<Phase>>,
}

/// How far it has come.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Phase {
    /// So many boards have not got their points so far.
    Preparing(usize),
    /// All have.
    Ready,
    /// It is given up; why.
    GivenUp(String),
}

impl Start {
    /// Of so many boards.
    pub fn of(boards: usize, at_s: f64) -> Self {
        Self { at_s, phase: Arc::new(Mutex::new(Phase::Preparing(boards))) }
    }

    /// One more board has its points.
    pub fn prepared(&self) {
        let mut phase = self.lock();
        if let Phase::Preparing(missing) = *phase {
            *phase = if missing > 1 { Phase::Preparing(missing - 1) } else { Phase::Ready };
        }
    }

    /// It cannot be; the first reason counts.
    pub fn give_up(&self, reason: String) {
        let mut phase = self.lock();
        if !matches!(*phase, Phase::GivenUp(_)) {
            *phase = Phase::GivenUp(reason);
        }
    }

    /// How far it has come.
    pub fn phase(&self) -> Phase {
        self.lock().clone()
    }

    /// Whether two are the same.
    pub fn is(&self, other: &Self) -> bool {
        Arc::ptr_eq(&self.phase, &other.phase)
    }

    fn lock(&self) -> MutexGuard<'_, Phase> {
        // What a thread that panicked left is whole: each change is one assignment.
        self.phase.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn it_is_ready_with_the_last_board_and_given_up_for_all_with_the_first() {
        let start = Start::of(2, 1.0);
        start.prepared();
        assert_eq!(start.phase(), Phase::Preparing(1));
        start.clone().prepared();
        assert_eq!(start.phase(), Phase::Ready);
        start.give_up("the line is cut".to_owned());
        start.give_up("another reason".to_owned());
        start.prepared();
        assert_eq!(start.phase(), Phase::GivenUp("the line is cut".to_owned()));
    }
}
