//! All boards as they were last seen, shared by the lines' threads and by those who look.

use std::sync::{Arc, Condvar, LazyLock, Mutex, MutexGuard, PoisonError};
use std::time::{Duration, Instant};

use serde_json::{Value, json};

use crate::lines::Line;
use crate::seen::{Problem, Telemetry};

/// The moment from which times are counted.
static START: LazyLock<Instant> = LazyLock::new(Instant::now);

/// All boards.
#[derive(Clone, Debug)]
pub struct Boards(Arc<Shared>);

#[derive(Debug)]
struct Shared {
    boards: Mutex<Vec<Board>>,
    is_new: Condvar,
}

/// A board as it was last seen.
#[derive(Clone, Debug)]
pub struct Board {
    /// Its name.
    pub name: String,
    /// The name of its line.
    pub line: String,
    /// Its number there.
    pub number: u8,
    /// What it told last.
    pub telemetry: Option<Telemetry>,
    /// Why it is not seen now.
    pub problem: Option<Problem>,
    /// Questions that it has answered.
    pub answered: u64,
    /// Questions without an answer.
    pub lost: u64,
    /// How long the last round of its line took.
    pub round: Duration,
    /// Counts all changes.
    changes: u64,
}

impl Boards {
    /// The boards of these lines, none of them seen so far.
    pub fn of(lines: &[Line]) -> Self {
        LazyLock::force(&START);
        let boards = lines.iter().flat_map(|line| {
            line.boards.iter().map(|member| Board {
                name: member.name.clone(),
                line: line.name.clone(),
                number: member.number,
                telemetry: None,
                problem: None,
                answered: 0,
                lost: 0,
                round: Duration::ZERO,
                changes: 0,
            })
        });
        Self(Arc::new(Shared { boards: Mutex::new(boards.collect()), is_new: Condvar::new() }))
    }

    /// Now, since the gateway's start. Unit: s.
    pub fn now_s() -> f64 {
        START.elapsed().as_secs_f64()
    }

    /// A board has answered.
    pub fn telemetry(&self, index: usize, telemetry: Telemetry) {
        self.change(index, |board| {
            board.telemetry = Some(telemetry);
            board.problem = None;
            board.answered += 1;
        });
    }

    /// A question was not answered.
    pub fn lost(&self, index: usize) {
        self.change(index, |board| board.lost += 1);
    }

    /// A board is not to be seen.
    pub fn problem(&self, index: usize, problem: Problem) {
        self.change(index, |board| board.problem = Some(problem));
    }

    /// A round of a line has taken so long.
    pub fn round(&self, indices: impl Iterator<Item = usize>, took: Duration) {
        let mut boards = self.lock();
        indices.filter_map(|index| boards.get_mut(index).map(|board| board.round = took)).for_each(drop);
    }

    /// Waits until something is new to who has seen so many changes, which are counted on; whether
    /// that was so within `limit`.
    pub fn news(&self, seen: &mut u64, limit: Duration) -> bool {
        let changes = |boards: &Vec<Board>| boards.iter().map(|board| board.changes).sum::<u64>();
        let is_old = |boards: &mut Vec<Board>| changes(boards) == *seen;
        let waited = self.0.is_new.wait_timeout_while(self.lock(), limit, is_old);
        let (boards, waited) = waited.unwrap_or_else(PoisonError::into_inner);
        *seen = changes(&boards);
        !waited.timed_out()
    }

    /// All boards, now.
    pub fn all(&self) -> Vec<Board> {
        self.lock().clone()
    }

    fn change(&self, index: usize, change: impl FnOnce(&mut Board)) {
        let mut boards = self.lock();
        if let Some(board) = boards.get_mut(index) {
            change(board);
            board.changes += 1;
        }
        drop(boards);
        self.0.is_new.notify_all();
    }

    fn lock(&self) -> MutexGuard<'_, Vec<Board>> {
        // A thread that panicked while it held the lock left something to show all the same.
        self.0.boards.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

impl Board {
    /// For programs.
    pub fn to_json(&self) -> Value {
        json!({
            "name": self.name, "line": self.line, "number": self.number, "answered": self.answered,
            "lost": self.lost, "round_s": self.round.as_secs_f64(),
            "problem": self.problem.as_ref().map(Problem::in_words),
            "telemetry": self.telemetry.as_ref().map(Telemetry::to_json),
        })
    }
}
