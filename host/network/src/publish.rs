//! Telemetry, states and liveliness of all boards.
//!
//! | key of a board | what | when |
//! |---|---|---|
//! | `telemetry` | what it measures | each answer |
//! | `state` | its state, its fault, or why it is not seen | each change; the last ones for late joiners |
//! | `alive` | a token | while it answers |
//! | `trajectory` | how far its trajectory has come | each step |
//! | `refused` | a set point that was not taken, and why | each |

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::Receiver;
use std::thread::{self, JoinHandle};
use std::time::Duration;

use gateway::boards::{Board, Boards, Listener, News};
use gateway::seen::{Progress, Telemetry};
use serde_json::{Value, json};
use wire::{Fault, State};
use zenoh::bytes::Encoding;
use zenoh::liveliness::LivelinessToken;
use zenoh::qos::CongestionControl;
use zenoh::{Session, Wait};
use zenoh_ext::{AdvancedPublisher, AdvancedPublisherBuilderExt, CacheConfig};

use crate::NetworkError;
use crate::keys::{Keys, VERSION};
use crate::orders::Refusal;

/// How long it takes at most to see that there is nothing more to publish.
const PATIENCE: Duration = Duration::from_millis(100);
/// How many changes of its state are kept of a board for who joins late.
const KEPT: usize = 100;

/// Publishes, until it is dropped.
#[derive(Debug)]
pub struct Publisher {
    is_ended: Arc<AtomicBool>,
    thread: Option<JoinHandle<()>>,
}

/// A board as it is published.
struct Published {
    name: String,
    telemetry: zenoh::pubsub::Publisher<'static>,
    state: AdvancedPublisher<'static>,
    alive: Option<LivelinessToken>,
    /// Messages of telemetry so far: a gap in it is a message that was lost on its way.
    count: u64,
    /// As it was last published.
    last: Option<Seen>,
}

impl Published {
    /// None of a board that is gone: it has no keys.
    fn declare(
        session: &Session,
        keys: &Keys,
        index: usize,
        board: &Board,
    ) -> Result<Option<Self>, NetworkError> {
        let of = |problem: zenoh::Error| NetworkError::of(&problem);
        let Some((telemetry, state)) = keys.of_board(index, "telemetry").zip(keys.of_board(index, "state"))
        else {
            return Ok(None);
        };
        // Nothing is dropped for a subscriber that is slow for a moment.
        let telemetry = session
            .declare_publisher(telemetry)
            .encoding(Encoding::APPLICATION_JSON)
            .congestion_control(CongestionControl::Block)
            .wait()
            .map_err(of)?;
        let state = session
            .declare_publisher(state)
            .encoding(Encoding::APPLICATION_JSON)
            .congestion_control(CongestionControl::Block)
            .cache(CacheConfig::default().max_samples(KEPT))
            .publisher_detection()
            .wait()
            .map_err(of)?;
        Ok(Some(Self { name: board.name.clone(), telemetry, state, alive: None, count: 0, last: None }))
    }
}

/// State and fault of a board, or why it is not seen.
type Seen = Result<(State, u8), String>;

impl Publisher {
    /// Publishes all that is new of these boards.
    ///
    /// # Errors
    /// The session does not take a key.
    pub fn start(
        session: &Session,
        boards: &Boards,
        keys: &Keys,
        refusals: Receiver<Refusal>,
    ) -> Result<Self, NetworkError> {
        let (is_ended, listener) = (Arc::new(AtomicBool::new(false)), boards.listen());
        let mut work = Work {
            session: session.clone(),
            keys: keys.clone(),
            all: boards.clone(),
            published: Vec::new(),
            listener,
            refusals,
            is_ended: is_ended.clone(),
        };
        work.arrange()?;
        let thread = Some(thread::spawn(move || work.run()));
        Ok(Self { is_ended, thread })
    }
}

impl Drop for Publisher {
    fn drop(&mut self) {
        self.is_ended.store(true, Ordering::Relaxed);
        if let Some(thread) = self.thread.take() {
            // One that panicked has nothing more to publish.
            let _ = thread.join();
        }
    }
}

struct Work {
    session: Session,
    keys: Keys,
    all: Boards,
    /// Each board at its place among all; none of one that is gone.
    published: Vec<Option<Published>>,
    listener: Listener,
    refusals: Receiver<Refusal>,
    is_ended: Arc<AtomicBool>,
}

impl Work {
    fn run(mut self) {
        while !self.is_ended.load(Ordering::Relaxed) {
            match self.listener.next(PATIENCE) {
                Some(News::Telemetry(index, telemetry)) => self.telemetry(index, &telemetry),
                Some(News::Problem(index, problem)) => self.problem(index, problem.in_words()),
                Some(News::Trajectory(index, progress)) => self.trajectory(index, &progress),
                // A session that is closed ends this thread soon.
                Some(News::Arranged) => drop(self.arrange()),
                None => {}
            }
            while let Ok(refusal) = self.refusals.try_recv() {
                let told = json!({"sequence": refusal.sequence, "reason": refusal.reason});
                self.put(refusal.index, "refused", &told);
            }
        }
    }

    /// The boards are others than before; those that stay are published on.
    fn arrange(&mut self) -> Result<(), NetworkError> {
        let boards = self.all.all();
        self.keys.arrange(&boards);
        for (index, board) in boards.iter().enumerate() {
            if self.published.len() <= index {
                self.published.push(None);
            }
            let Some(place) = self.published.get_mut(index) else { continue };
            match place {
                Some(_) if board.is_gone => *place = None,
                Some(_) => {}
                None => *place = Published::declare(&self.session, &self.keys, index, board)?,
            }
        }
        Ok(())
    }

    fn put(&self, index: usize, what: &str, told: &Value) {
        let Some(key) = self.keys.of_board(index, what) else { return };
        // Who has gone is told nothing.
        let _ = self.session.put(key, told.to_string()).encoding(Encoding::APPLICATION_JSON).wait();
    }

    fn trajectory(&self, index: usize, progress: &Progress) {
        let mut told = json!({"version": VERSION, "phase": progress.phase()});
        match progress {
            Progress::Ready { start_s } => told["start_s"] = Boards::unix_s(*start_s).into(),
            Progress::Playing { start_tick, start_s, bound_s } => {
                told["start_tick"] = (*start_tick).into();
                told["start_s"] = Boards::unix_s(*start_s).into();
                told["bound_s"] = (*bound_s).into();
            }
            Progress::Done { underrun_ticks } => told["underrun_ticks"] = (*underrun_ticks).into(),
            Progress::Ended { reason } => told["reason"] = reason.as_str().into(),
        }
        self.put(index, "trajectory", &told);
    }

    fn telemetry(&mut self, index: usize, telemetry: &Telemetry) {
        let Some(Some(published)) = self.published.get_mut(index) else { return };
        let mut told = telemetry.to_json();
        told["version"] = VERSION.into();
        told["name"] = published.name.as_str().into();
        told["unix_s"] = Boards::unix_s(telemetry.time_s).into();
        published.count += 1;
        told["count"] = published.count.into();
        told["missed"] = self.listener.missed().into();
        // A session that is closed ends this thread soon.
        let _ = published.telemetry.put(told.to_string()).wait();
        if published.alive.is_none()
            && let Some(key) = self.keys.of_board(index, "alive")
        {
            published.alive = self.session.liveliness().declare_token(key).wait().ok();
        }
        self.seen(index, Ok((telemetry.state, telemetry.fault)), telemetry.time_s);
    }

    fn problem(&mut self, index: usize, problem: String) {
        if let Some(Some(published)) = self.published.get_mut(index) {
            // The token goes with it.
            published.alive = None;
        }
        self.seen(index, Err(problem), Boards::now_s());
    }

    /// Publishes how a board is seen, if that is new.
    fn seen(&mut self, index: usize, now: Seen, time_s: f64) {
        let Some(Some(published)) = self.published.get_mut(index) else { return };
        if published.last.as_ref() == Some(&now) {
            return;
        }
        let (state, code, problem) = match &now {
            Ok((state, code)) => (Some(format!("{state:?}")), Some(*code), None),
            Err(problem) => (None, None, Some(problem.as_str())),
        };
        let name = code.and_then(Fault::of_code).map(|fault| format!("{fault:?}"));
        let told = json!({
            "version": VERSION, "name": published.name, "unix_s": Boards::unix_s(time_s), "state": state, "fault": code,
            "fault_name": name, "problem": problem,
        });
        // A session that is closed ends this thread soon.
        let _ = published.state.put(told.to_string()).wait();
        published.last = Some(now);
    }
}
