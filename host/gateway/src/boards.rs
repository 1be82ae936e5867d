//! All boards as they were last seen, shared by the lines' threads and by those who look.

use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::mpsc::{Receiver, SyncSender, sync_channel};
use std::sync::{Arc, Condvar, LazyLock, Mutex, MutexGuard, PoisonError};
use std::time::{Duration, Instant, SystemTime, UNIX_EPOCH};

use serde_json::{Value, json};

use crate::lines::{Line, Member};
use crate::seen::{Problem, Progress, Telemetry};

/// The moment from which times are counted.
static START: LazyLock<Instant> = LazyLock::new(Instant::now);

/// How much news is kept for who does not take it: ten seconds of sixteen boards at 100 Hz.
const QUEUE: usize = 16_000;

/// All boards.
#[derive(Clone, Debug)]
pub struct Boards(Arc<Shared>);

/// What is new of a board.
#[derive(Clone, Debug)]
pub enum News {
    /// It has answered; which board of all.
    Telemetry(usize, Telemetry),
    /// It is not seen, or is again not seen.
    Problem(usize, Problem),
    /// Its trajectory has come so far.
    Trajectory(usize, Progress),
    /// There are other boards than before: [`Boards::all`] tells which.
    Arranged,
}

/// All news, one by one.
#[derive(Debug)]
pub struct Listener {
    news: Receiver<News>,
    missed: Arc<AtomicU64>,
}

impl Listener {
    /// The next news, if there are any within the limit.
    pub fn next(&self, limit: Duration) -> Option<News> {
        self.news.recv_timeout(limit).ok()
    }

    /// How much was lost since it was not taken in time.
    pub fn missed(&self) -> u64 {
        self.missed.load(Ordering::Relaxed)
    }
}

#[derive(Debug)]
struct Shared {
    boards: Mutex<Vec<Board>>,
    is_new: Condvar,
    listeners: Mutex<Vec<(SyncSender<News>, Arc<AtomicU64>)>>,
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
    /// How far its last trajectory has come.
    pub trajectory: Option<Progress>,
    /// It was taken out of the file; its place among all stays, for when it comes again.
    pub is_gone: bool,
    /// Its last answer came in a slot.
    pub in_slots: bool,
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
        let boards = Mutex::default();
        let all = Self(Arc::new(Shared { boards, is_new: Condvar::new(), listeners: Mutex::default() }));
        all.arrange(lines);
        all
    }

    /// The boards are those of these lines from now on. A board that has the line and the name, and
    /// the number, of one before is that one, and keeps its place among all; the place of one that
    /// goes is nobody else's. Answers the places of each line's boards.
    pub fn arrange(&self, lines: &[Line]) -> Vec<Vec<usize>> {
        let mut boards = self.lock();
        boards.iter_mut().for_each(|board| board.is_gone = true);
        let mut place_of = |line: &Line, member: &Member| {
            let is_it = |board: &Board| {
                (&board.line, &board.name, board.number) == (&line.name, &member.name, member.number)
            };
            let place = boards.iter().position(is_it).unwrap_or_else(|| {
                boards.push(Board::new(line, member));
                boards.len() - 1
            });
            if let Some(board) = boards.get_mut(place) {
                board.is_gone = false;
                board.changes += 1;
            }
            place
        };
        let places = lines
            .iter()
            .map(|line| line.boards.iter().map(|member| place_of(line, member)).collect())
            .collect();
        drop(boards);
        self.0.is_new.notify_all();
        self.tell(&News::Arranged);
        places
    }

    /// A time since the gateway's start, on the clock of the day: since 1970. Unit: s.
    pub fn unix_s(since_start_s: f64) -> f64 {
        let now = SystemTime::now().duration_since(UNIX_EPOCH).map_or(0.0, |now| now.as_secs_f64());
        now - Self::now_s() + since_start_s
    }

    /// Now, since the gateway's start. Unit: s.
    pub fn now_s() -> f64 {
        START.elapsed().as_secs_f64()
    }

    /// Everything that is new from now on.
    pub fn listen(&self) -> Listener {
        let (sender, news) = sync_channel(QUEUE);
        let missed = Arc::new(AtomicU64::new(0));
        self.listeners().push((sender, missed.clone()));
        Listener { news, missed }
    }

    fn tell(&self, news: &News) {
        use std::sync::mpsc::TrySendError::{Disconnected, Full};
        self.listeners().retain(|(listener, missed)| match listener.try_send(news.clone()) {
            Ok(()) => true,
            Err(Full(_)) => {
                missed.fetch_add(1, Ordering::Relaxed);
                true
            }
            Err(Disconnected(_)) => false,
        });
    }

    /// A board has answered.
    pub fn telemetry(&self, index: usize, telemetry: Telemetry) {
        self.tell(&News::Telemetry(index, telemetry.clone()));
        self.change(index, |board| {
            board.in_slots = telemetry.in_slots;
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
        self.tell(&News::Problem(index, problem.clone()));
        self.change(index, |board| board.problem = Some(problem));
    }

    /// A board's trajectory has come so far.
    pub fn progress(&self, index: usize, progress: Progress) {
        self.tell(&News::Trajectory(index, progress.clone()));
        self.change(index, |board| board.trajectory = Some(progress));
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

    /// All boards, now, and those that have been: each at its place.
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

    fn listeners(&self) -> MutexGuard<'_, Vec<(SyncSender<News>, Arc<AtomicU64>)>> {
        self.0.listeners.lock().unwrap_or_else(PoisonError::into_inner)
    }

    fn lock(&self) -> MutexGuard<'_, Vec<Board>> {
        // A thread that panicked while it held the lock left something to show all the same.
        self.0.boards.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

impl Board {
    /// One that was not seen so far.
    fn new(line: &Line, member: &Member) -> Self {
        Self {
            name: member.name.clone(),
            line: line.name.clone(),
            number: member.number,
            telemetry: None,
            problem: None,
            trajectory: None,
            is_gone: false,
            in_slots: false,
            answered: 0,
            lost: 0,
            round: Duration::ZERO,
            changes: 0,
        }
    }

    /// For programs.
    pub fn to_json(&self) -> Value {
        json!({
            "name": self.name, "line": self.line, "number": self.number, "answered": self.answered,
            "lost": self.lost, "in_slots": self.in_slots, "round_s": self.round.as_secs_f64(),
            "problem": self.problem.as_ref().map(Problem::in_words),
            "trajectory": self.trajectory.as_ref().map(Progress::in_words),
            "telemetry": self.telemetry.as_ref().map(Telemetry::to_json),
        })
    }
}

#[cfg(test)]
pub(crate) mod tests {
    use super::*;
    use crate::lines::tests::parsed;
    use crate::seen::tests::telemetry;

    /// Three boards of one line.
    pub(crate) fn three() -> Boards {
        Boards::of(&parsed("[[line]]\nport = \"p\"\nboards = [1, 2, 3]\n").expect("a line").lines)
    }

    #[test]
    fn a_board_that_stays_keeps_its_place_and_one_that_goes_leaves_it_free_for_its_return() {
        let lines = |text: &str| parsed(&format!("[[line]]\nport = \"p\"\n{text}")).expect("lines").lines;
        let boards = Boards::of(&lines("boards = [1, 2]"));
        boards.telemetry(1, telemetry());
        let other = "boards = [3, 2]\n[[line]]\nport = \"q\"\nboards = [1]";
        assert_eq!(boards.arrange(&lines(other)), [vec![2, 1], vec![3]]);
        let gone = |boards: &Boards| boards.all().iter().map(|board| board.is_gone).collect::<Vec<_>>();
        assert_eq!(gone(&boards), [true, false, false, false]);
        assert_eq!(boards.all()[1].answered, 1);
        assert_eq!(boards.arrange(&lines("boards = [2, 1]")), [vec![1, 0]]);
        assert_eq!(gone(&boards), [false, false, true, true]);
    }

    #[test]
    fn a_listener_hears_everything_in_order_and_counts_what_it_was_too_slow_for() {
        let boards = three();
        let listener = boards.listen();
        for _ in 0..QUEUE + 5 {
            boards.telemetry(1, telemetry());
        }
        assert_eq!(listener.missed(), 5);
        let heard = std::iter::from_fn(|| listener.next(Duration::ZERO)).count();
        assert_eq!(heard, QUEUE);
        boards.problem(2, Problem::Silent("no answer".to_owned()));
        assert!(matches!(listener.next(Duration::ZERO), Some(News::Problem(2, _))));
    }
}
