//! The boards as ROS 2 sees them by its middleware `rmw_zenoh`: topics and services of one node,
//! without ROS 2 here and without a plug-in there.
//!
//! | topic or service | type | what |
//! |---|---|---|
//! | `/NAME/joint_states` | `sensor_msgs/JointState` | all boards that are seen; position in m |
//! | `/diagnostics` | `diagnostic_msgs/DiagnosticArray` | each board: state, fault with cure, pressure, bus |
//! | `/NAME/joint_commands` | `sensor_msgs/JointState` | set points: position in m; names alone are a sign of life |
//! | `/NAME/joint_trajectory` | `trajectory_msgs/JointTrajectory` | positions in m over time, for joints that begin at once |
//! | `/NAME/start`, `/NAME/stop` | `std_srvs/Trigger` | starts all boards that are ready; stops and vents all |
//!
//! Keys, tokens and attachments are those of `rmw_zenoh_cpp` since 0.2.4
//! (docs/design.md there). A joint has the name of its board.
//!
//! # Set points
//! A command is taken by the boards that were started by the service here, while its stamp is fresh
//! ([`gateway::driving`]); a stamp of 0 stands for the moment at which it was sent.
//!
//! # Trajectories
//! The stamp is the start, 0 as soon as can be. Lines are straight: velocities and what else a point
//! may have are not looked at. What becomes of it stands in the diagnostics of each board; while it
//! waits and plays its client says that it lives, by commands with names alone.
//!
//! # Limits
//! Checked by independent decoders; there was no ROS 2 to try it with.

use std::collections::BTreeMap;
use std::sync::atomic::{AtomicBool, AtomicI64, AtomicU64, Ordering};
use std::sync::{Arc, Mutex, PoisonError};
use std::thread::{self, JoinHandle};
use std::time::{Duration, Instant};

use gateway::boards::{Board, Boards};
use gateway::driving::{Refused, SetPoint};
use gateway::seen::Progress;
use gateway::{Gateway, Part};
use ros::bytes;
use ros::messages::{
    DiagnosticArray, DiagnosticStatus, Header, JointState, JointTrajectory, JointTrajectoryPoint, KeyValue,
    Trigger, TriggerResponse,
};
use ros::types::Named;
use serde::Serialize;
use wire::State;
use wire::fault::table::TABLE;
use zenoh::bytes::ZBytes;
use zenoh::handlers::{FifoChannel, FifoChannelHandler};
use zenoh::liveliness::LivelinessToken;
use zenoh::pubsub::Subscriber;
use zenoh::qos::CongestionControl;
use zenoh::query::{Query, Queryable};
use zenoh::sample::Sample;
use zenoh::{Session, Wait};
use zenoh_ext::{ZDeserializer, ZSerializer};

use crate::NetworkError;

/// The node's name.
const NODE: &str = "mgpi_gateway";
/// From one message of joint states to the next: 50 Hz.
const STATES: Duration = Duration::from_millis(20);
/// From one message of diagnostics to the next, as ROS 2's own aggregator expects them.
const DIAGNOSTICS: Duration = Duration::from_secs(1);
/// A board that has told nothing for so long is not among the joints. Unit: s.
const GONE_S: f64 = 0.5;
/// Reliable, volatile, the last ten messages, and all else as by default, which is left out.
const QUALITY: &str = "::,10:,:,:,,";
/// Stands for what is empty, and for a slash within a part of a key.
const MANGLED: &str = "%";
/// How many questions to a service may wait.
const WAITING: usize = 16;
/// Millimetres in a metre, in which ROS 2 counts (REP 103).
const MM_PER_M: f64 = 1e3;
/// The number that tells an endpoint from the others of all nodes. Unit: byte.
type Gid = [u8; 16];

/// The node, until it is dropped.
#[derive(Debug)]
pub struct Face {
    is_ended: Arc<AtomicBool>,
    thread: Option<JoinHandle<()>>,
    _commands: [Subscriber<()>; 2],
    /// What tells ROS 2 that node and endpoints are there.
    _tokens: Vec<LivelinessToken>,
}

/// What an endpoint does, as it stands in its token.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Kind {
    Publisher,
    Subscription,
    Service,
}

impl Kind {
    fn letters(self) -> &'static str {
        match self {
            Self::Publisher => "MP",
            Self::Subscription => "MS",
            Self::Service => "SS",
        }
    }
}

/// The node, as keys name it.
struct Node {
    domain: u32,
    /// The session's identity.
    session: String,
    /// The gateway's name.
    name: String,
}

impl Node {
    /// The token of the node, or of its endpoint of this number, with what stands behind its name.
    fn token(&self, number: usize, kind: &str, rest: &str) -> String {
        let Self { domain, session, name } = self;
        format!("@ros2_lv/{domain}/{session}/0/{number}/{kind}/{MANGLED}/{MANGLED}{name}/{NODE}{rest}")
    }

    /// The token of an endpoint, and the key of its messages.
    fn endpoint<T: Named>(&self, number: usize, kind: Kind, topic: &str) -> (String, String) {
        let (type_name, hash) = (T::DDS_TYPE, T::HASH);
        let rest = format!("/{}/{type_name}/{hash}/{QUALITY}", topic.replace('/', MANGLED));
        let key = format!("{}{topic}/{type_name}/{hash}", self.domain);
        (self.token(number, kind.letters(), &rest), key)
    }
}

/// Declares endpoints, one by one.
struct Declared<'a> {
    session: &'a Session,
    node: Node,
    tokens: Vec<LivelinessToken>,
}

impl Declared<'_> {
    /// Key and number of an endpoint, whose token is declared.
    fn endpoint<T: Named>(&mut self, kind: Kind, topic: &str) -> Result<(String, Gid), NetworkError> {
        let number = self.tokens.len();
        let (token, key) = self.node.endpoint::<T>(number, kind, topic);
        self.token(token)?;
        let mut gid = self.session.zid().to_le_bytes();
        // A gateway has a handful of endpoints.
        gid[0] ^= number as u8;
        Ok((key, gid))
    }

    fn token(&mut self, token: String) -> Result<(), NetworkError> {
        let declared = self.session.liveliness().declare_token(token).wait();
        self.tokens.push(declared.map_err(|problem| NetworkError::of(&problem))?);
        Ok(())
    }

    /// A publisher of messages of this type.
    fn publisher<T: Named>(&mut self, topic: &str) -> Result<Topic, NetworkError> {
        let (key, gid) = self.endpoint::<T>(Kind::Publisher, topic)?;
        let publisher = self.session.declare_publisher(key).congestion_control(CongestionControl::Block);
        let publisher = publisher.wait().map_err(|problem| NetworkError::of(&problem))?;
        Ok(Topic { publisher, gid, sequence: AtomicI64::new(0) })
    }

    /// A service that something is done by.
    fn service(
        &mut self,
        topic: &str,
        done: impl Fn() -> TriggerResponse + Send + 'static,
    ) -> Result<(), NetworkError> {
        let (key, _) = self.endpoint::<Trigger>(Kind::Service, topic)?;
        let questions = self
            .session
            .declare_queryable(&key)
            .complete(true)
            .with(FifoChannel::new(WAITING))
            .wait()
            .map_err(|problem| NetworkError::of(&problem))?;
        // It ends with the session.
        thread::spawn(move || serve(&questions, &key, done));
        Ok(())
    }
}

/// Answers until the session ends.
fn serve(questions: &Queryable<FifoChannelHandler<Query>>, key: &str, done: impl Fn() -> TriggerResponse) {
    while let Ok(query) = questions.recv() {
        // Without it nobody could tell to which question the answer belongs.
        let Some(asked) = query.attachment().and_then(Attachment::read) else { continue };
        let Ok(answer) = bytes::of(&done()) else { continue };
        let attachment = Attachment { timestamp_ns: now_ns(), ..asked }.bytes();
        // Who has asked may have gone.
        let _ = query.reply(key, answer).attachment(attachment).wait();
    }
}

/// What goes with each message.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
struct Attachment {
    sequence: i64,
    /// Since 1970. Unit: ns.
    timestamp_ns: i64,
    gid: Gid,
}

impl Attachment {
    fn bytes(self) -> ZBytes {
        let mut serializer = ZSerializer::new();
        serializer.serialize(self.sequence);
        serializer.serialize(self.timestamp_ns);
        serializer.serialize(self.gid);
        serializer.finish()
    }

    fn read(bytes: &ZBytes) -> Option<Self> {
        let mut deserializer = ZDeserializer::new(bytes);
        Some(Self {
            sequence: deserializer.deserialize().ok()?,
            timestamp_ns: deserializer.deserialize().ok()?,
            gid: deserializer.deserialize().ok()?,
        })
    }
}

fn now_ns() -> i64 {
    (1e9 * Boards::unix_s(Boards::now_s())) as i64
}

/// A topic that is published.
struct Topic {
    publisher: zenoh::pubsub::Publisher<'static>,
    gid: Gid,
    sequence: AtomicI64,
}

impl Topic {
    fn publish<M: Serialize>(&self, message: &M) {
        let sequence = self.sequence.fetch_add(1, Ordering::Relaxed);
        let attachment = Attachment { sequence, timestamp_ns: now_ns(), gid: self.gid };
        if let Ok(content) = bytes::of(message) {
            // A session that is closed ends this thread soon.
            let _ = self.publisher.put(content).attachment(attachment.bytes()).wait();
        }
    }
}

/// The boards that were started by the service here, with their grants.
#[derive(Debug)]
struct Started {
    grants: Mutex<BTreeMap<usize, u32>>,
    /// Commands are taken in the order in which they come.
    sequence: AtomicU64,
}

impl Started {
    /// The place of the board of this name, and its grant, if it was started here.
    fn of(&self, boards: &[Board], name: &str) -> Option<(usize, u32)> {
        let index = boards.iter().position(|board| !board.is_gone && board.name == name)?;
        let grants = self.grants.lock().unwrap_or_else(PoisonError::into_inner);
        Some((index, *grants.get(&index)?))
    }
}

impl Face {
    /// Declares the node with its topics and services.
    ///
    /// # Errors
    /// The session does not take a key.
    pub fn start(
        session: &Session,
        gateway: &Arc<Gateway>,
        name: &str,
        domain: u32,
    ) -> Result<Self, NetworkError> {
        let of = |problem: zenoh::Error| NetworkError::of(&problem);
        let namespace = format!("/{name}");
        let node = Node { domain, session: session.zid().to_string(), name: name.to_owned() };
        let token = node.token(0, "NN", "");
        let mut declared = Declared { session, node, tokens: Vec::new() };
        declared.token(token)?;
        let states = declared.publisher::<JointState>(&format!("{namespace}/joint_states"))?;
        let diagnostics = declared.publisher::<DiagnosticArray>("/diagnostics")?;
        let started = Arc::new(Started { grants: Mutex::default(), sequence: AtomicU64::new(0) });
        let (all, its) = (gateway.clone(), started.clone());
        declared.service(&format!("{namespace}/start"), move || start_all(&all, &its))?;
        let all = gateway.clone();
        declared.service(&format!("{namespace}/stop"), move || {
            all.stop_all();
            TriggerResponse { success: true, message: "all boards are told to vent".to_owned() }
        })?;
        let commands = format!("{namespace}/joint_commands");
        let (key, _) = declared.endpoint::<JointState>(Kind::Subscription, &commands)?;
        let (all, its) = (gateway.clone(), started.clone());
        let commands = session
            .declare_subscriber(key)
            .callback(move |sample| take(&sample, &all, &its))
            .wait()
            .map_err(of)?;
        let trajectories = format!("{namespace}/joint_trajectory");
        let (key, _) = declared.endpoint::<JointTrajectory>(Kind::Subscription, &trajectories)?;
        let all = gateway.clone();
        let trajectories = session
            .declare_subscriber(key)
            .callback(move |sample| play(&sample, &all, &started))
            .wait()
            .map_err(of)?;
        let is_ended = Arc::new(AtomicBool::new(false));
        let (boards, ended) = (gateway.boards().clone(), is_ended.clone());
        let thread = thread::spawn(move || publish(&boards, &states, &diagnostics, &ended));
        Ok(Self {
            is_ended,
            thread: Some(thread),
            _commands: [commands, trajectories],
            _tokens: declared.tokens,
        })
    }
}

impl Drop for Face {
    fn drop(&mut self) {
        self.is_ended.store(true, Ordering::Relaxed);
        if let Some(thread) = self.thread.take() {
            // One that panicked has nothing more to publish.
            let _ = thread.join();
        }
    }
}

fn publish(boards: &Boards, states: &Topic, diagnostics: &Topic, is_ended: &AtomicBool) {
    let (mut seen, mut next_state, mut next_diagnostics) = (0, Instant::now(), Instant::now());
    while !is_ended.load(Ordering::Relaxed) {
        thread::sleep(next_state.saturating_duration_since(Instant::now()));
        next_state = (next_state + STATES).max(Instant::now());
        if boards.news(&mut seen, STATES) {
            states.publish(&joint_state(&boards.all(), Boards::now_s()));
        }
        if Instant::now() >= next_diagnostics {
            next_diagnostics = Instant::now() + DIAGNOSTICS;
            let status = boards.all().iter().filter(|board| !board.is_gone).map(status).collect();
            let header = Header::at_s(Boards::unix_s(Boards::now_s()));
            diagnostics.publish(&DiagnosticArray { header, status });
        }
    }
}

/// All boards that are seen; the stamp is that of the newest.
fn joint_state(boards: &[Board], now_s: f64) -> JointState {
    let mut state = JointState::default();
    let mut newest_s = f64::NEG_INFINITY;
    for board in boards.iter().filter(|board| !board.is_gone && board.problem.is_none()) {
        let Some(told) = board.telemetry.as_ref().filter(|told| now_s - told.time_s < GONE_S) else {
            continue;
        };
        state.name.push(board.name.clone());
        state.position.push(told.contraction_mm / MM_PER_M);
        newest_s = newest_s.max(told.time_s);
    }
    state.header = Header::at_s(Boards::unix_s(if newest_s.is_finite() { newest_s } else { now_s }));
    state
}

/// What ROS 2's tools show of a board.
fn status(board: &Board) -> DiagnosticStatus {
    let fault = board.telemetry.as_ref().and_then(|told| told.fault());
    let row = fault.and_then(|fault| TABLE.iter().find(|row| row.fault == fault));
    let (level, message) = match (&board.problem, &board.telemetry, row) {
        (Some(problem), _, _) => (DiagnosticStatus::STALE, problem.in_words()),
        (None, None, _) => (DiagnosticStatus::STALE, "not seen so far".to_owned()),
        (None, Some(_), Some(row)) => {
            (DiagnosticStatus::ERROR, format!("{}. Cause: {}. Cure: {}", row.title, row.cause, row.cure))
        }
        (None, Some(told), None) if told.state == State::Fault => {
            (DiagnosticStatus::ERROR, format!("fault {}", told.fault))
        }
        (None, Some(told), None) => (DiagnosticStatus::OK, format!("{:?}", told.state)),
    };
    let mut values = vec![("line", board.line.clone()), ("number", board.number.to_string())];
    if let Some(told) = &board.telemetry {
        values.extend([
            ("pressure, bar", format!("{:.3}", told.pressure_bar)),
            ("command, bar", format!("{:.3}", told.command_bar)),
            ("supply, bar", format!("{:.2}", told.supply_bar)),
            ("temperature, °C", format!("{:.1}", told.temperature_c)),
            ("clock's bound, ms", format!("{:.2}", 1e3 * told.time_bound_s)),
        ]);
    }
    values.extend(board.trajectory.as_ref().map(|progress| ("trajectory", progress.in_words())));
    values.extend([("questions answered", board.answered.to_string()), ("lost", board.lost.to_string())]);
    let values = values.into_iter().map(|(key, value)| KeyValue { key: key.to_owned(), value }).collect();
    let hardware_id = format!("{}/{}", board.line, board.number);
    DiagnosticStatus { level, name: format!("mgpi: {}", board.name), message, hardware_id, values }
}

/// Starts all boards that are ready.
fn start_all(gateway: &Gateway, started: &Started) -> TriggerResponse {
    let boards = gateway.boards().all();
    let is_ready = |board: &Board| {
        let told = board.telemetry.as_ref().filter(|_| !board.is_gone && board.problem.is_none());
        told.is_some_and(|told| told.state == State::Ready)
    };
    let ready: Vec<usize> = (0..boards.len()).filter(|index| is_ready(&boards[*index])).collect();
    let (mut count, mut refused) = (0, Vec::new());
    for (index, answer) in ready.iter().zip(gateway.start_each(&ready)) {
        match answer {
            Ok(grant) => {
                started.grants.lock().unwrap_or_else(PoisonError::into_inner).insert(*index, grant);
                count += 1;
            }
            Err(reason) => refused.push(format!("{}: {reason}", boards[*index].name)),
        }
    }
    let success = count > 0 && refused.is_empty();
    let message = match refused.is_empty() {
        true if count == 0 => "no board is ready".to_owned(),
        true => format!("{count} boards track, each as long as it gets set points (its bus_silent_ticks)"),
        false => refused.join("; "),
    };
    TriggerResponse { success, message }
}

/// Takes the set points of a command.
fn take(sample: &Sample, gateway: &Gateway, started: &Started) {
    let Ok(command) = bytes::read::<JointState>(&sample.payload().to_bytes()) else { return };
    let stamp_s = command.header.stamp.s();
    let sent_s = match sample.attachment().and_then(Attachment::read) {
        Some(attachment) if stamp_s == 0.0 => 1e-9 * attachment.timestamp_ns as f64,
        _ => stamp_s,
    };
    let age_s = Boards::unix_s(Boards::now_s()) - sent_s;
    let boards = gateway.boards().all();
    let is_life = command.position.is_empty();
    for (place, name) in command.name.iter().enumerate() {
        let position_m = command.position.get(place);
        let Some((index, grant)) = started.of(&boards, name).filter(|_| is_life || position_m.is_some())
        else {
            continue;
        };
        let sequence = started.sequence.fetch_add(1, Ordering::Relaxed);
        let mm = position_m.map(|position_m| MM_PER_M * position_m);
        let point = SetPoint { grant, sequence, mm, age_s };
        // ROS 2's topics have no answer: the board's state, and its silence, show in diagnostics.
        let _ = gateway.set(index, point);
    }
}

/// Takes a trajectory. What is refused is told where its progress would be: ROS 2's topics have no
/// answer.
fn play(sample: &Sample, gateway: &Gateway, started: &Started) {
    let Ok(message) = bytes::read::<JointTrajectory>(&sample.payload().to_bytes()) else { return };
    let boards = gateway.boards().all();
    let stamp_s = message.header.stamp.s();
    let at_s = (stamp_s != 0.0).then(|| stamp_s - Boards::unix_s(0.0));
    let (mut parts, mut refused) = (Vec::new(), None);
    for (place, name) in message.joint_names.iter().enumerate() {
        let Some(index) = boards.iter().position(|board| !board.is_gone && board.name == *name) else {
            eprintln!("warning: a trajectory is refused: there is no board {name}");
            return;
        };
        // A point without this joint has no number for it, which is refused.
        let point = |point: &JointTrajectoryPoint| {
            let position_m = point.positions.get(place).copied().unwrap_or(f64::NAN);
            (point.time_from_start.s(), MM_PER_M * position_m)
        };
        let points = message.points.iter().map(point).collect();
        match started.of(&boards, name) {
            Some((_, grant)) => parts.push(Part { index, grant, points }),
            None => refused = Some((index, Refused::NotDriven)),
        }
    }
    let named: Vec<usize> = parts.iter().map(|part| part.index).collect();
    let refused = refused.or_else(|| gateway.play(parts, at_s).err());
    if let Some((index, refused)) = refused {
        let name = boards.get(index).map_or("", |board| &board.name);
        for index in named.into_iter().chain([index]) {
            gateway
                .boards()
                .progress(index, Progress::Ended { reason: format!("refused: {name}: {refused}") });
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn tokens_and_keys_are_those_of_rmw_zenoh() {
        let node = Node { domain: 3, session: "1a2b".to_owned(), name: "lab".to_owned() };
        assert_eq!(node.token(0, "NN", ""), "@ros2_lv/3/1a2b/0/0/NN/%/%lab/mgpi_gateway");
        let (token, key) = node.endpoint::<JointState>(2, Kind::Publisher, "/lab/joint_states");
        let hash = "RIHS01_a13ee3a330e346c9d87b5aa18d24e11690752bd33a0350f11c5882bc9179260e";
        assert_eq!(key, format!("3/lab/joint_states/sensor_msgs::msg::dds_::JointState_/{hash}"));
        let endpoint = format!("%lab%joint_states/sensor_msgs::msg::dds_::JointState_/{hash}/::,10:,:,:,,");
        assert_eq!(token, format!("@ros2_lv/3/1a2b/0/2/MP/%/%lab/mgpi_gateway/{endpoint}"));
    }

    #[test]
    fn an_attachment_is_33_bytes_and_comes_back() {
        let attachment = Attachment { sequence: 7, timestamp_ns: 1 << 60, gid: [3; 16] };
        let bytes = attachment.bytes();
        assert_eq!(bytes.len(), 8 + 8 + 1 + 16);
        assert_eq!(&bytes.to_bytes()[..8], 7_i64.to_le_bytes());
        assert_eq!(Attachment::read(&bytes), Some(attachment));
        assert_eq!(Attachment::read(&ZBytes::from(vec![1, 2, 3])), None);
    }
}
