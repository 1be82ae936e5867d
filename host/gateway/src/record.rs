//! Everything that the boards tell, in a file: MCAP with messages of ROS 2, which its tools, and
//! `mgpi import`, read.
//!
//! | topic | type | what |
//! |---|---|---|
//! | `/NAME/joint_state` | `sensor_msgs/JointState` | contraction of the board of this name, m |
//! | `/NAME/joint_reference` | `sensor_msgs/JointState` | what its controller was asked for, m; while it tracks |
//! | `/NAME/pressure`, `/NAME/command` | `sensor_msgs/FluidPressure` | in the muscle, and put out to the valve, Pa |
//! | `/diagnostics` | `diagnostic_msgs/DiagnosticArray` | each change of state, fault, or of not being seen |
//!
//! A message an answer, with the time at which it was measured.
//!
//! # What goes wrong
//! The file grows beside its place, with `.part` behind its name, and is given its name at the end.
//! A disk that is full ends the recording, with a word, and nothing else: what was written until
//! then is kept there. A gateway that is killed leaves the same; `mcap recover` makes it whole.

use std::collections::BTreeMap;
use std::ffi::OsString;
use std::fs::{self, File};
use std::io::{self, BufWriter};
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::thread::{self, JoinHandle};
use std::time::{Duration, Instant};

use mcap::records::MessageHeader;
use mcap::{McapError, WriteOptions, Writer};
use ros::bytes::{self, BytesError};
use ros::messages::{DiagnosticArray, DiagnosticStatus, FluidPressure, Header, JointState};
use ros::types::Message;
use serde::Serialize;
use thiserror::Error;

use crate::boards::{Board, Boards, Listener, News};
use crate::seen::{Problem, Telemetry};

/// How long it takes at most to see that the recording ends.
const PATIENCE: Duration = Duration::from_millis(100);
/// From one flush to the next: what a killed gateway loses.
const FLUSH: Duration = Duration::from_secs(1);
/// The unit of pressures here in that of ROS 2.
const PA_PER_BAR: f64 = 1e5;
/// The same of lengths.
const MM_PER_M: f64 = 1e3;

/// Why nothing is recorded.
#[derive(Debug, Error)]
#[allow(missing_docs, reason = "the messages say what the variants and their fields are")]
pub enum RecordError {
    #[error("{}: there is such a file already; --force overwrites it", .0.display())]
    Exists(PathBuf),
    #[error("{}: {problem}", path.display())]
    Io { path: PathBuf, problem: io::Error },
    #[error("{}: {problem}", path.display())]
    Mcap { path: PathBuf, problem: McapError },
    #[error(transparent)]
    Bytes(#[from] BytesError),
}

/// A recording, until it is dropped.
#[derive(Debug)]
pub struct Record {
    is_ended: Arc<AtomicBool>,
    thread: Option<JoinHandle<Result<(), RecordError>>>,
}

impl Record {
    /// Begins a recording of these boards.
    ///
    /// # Errors
    /// There is such a file or one of an interrupted recording, unless `force`; it cannot be
    /// written.
    pub fn start(path: &Path, boards: &Boards, force: bool) -> Result<Self, RecordError> {
        let part = part(path);
        for path in [path, &part] {
            if !force && path.exists() {
                return Err(RecordError::Exists(path.to_owned()));
            }
        }
        let file = File::create(&part).map_err(|problem| RecordError::Io { path: part.clone(), problem })?;
        let mut sheet = Sheet::begin(part, file, boards)?;
        let is_ended = Arc::new(AtomicBool::new(false));
        let ended = is_ended.clone();
        let (listener, path) = (boards.listen(), path.to_owned());
        let thread = thread::spawn(move || {
            let recorded = sheet.run(&listener, &ended).and_then(|()| sheet.finish(&path));
            if let Err(error) = &recorded {
                eprintln!("warning: the recording has ended: {error}");
            }
            recorded
        });
        Ok(Self { is_ended, thread: Some(thread) })
    }

    /// Ends it: the file gets its name.
    ///
    /// # Errors
    /// It could not be written to its end.
    pub fn finish(mut self) -> Result<(), RecordError> {
        self.end()
    }

    fn end(&mut self) -> Result<(), RecordError> {
        self.is_ended.store(true, Ordering::Relaxed);
        match self.thread.take().map(JoinHandle::join) {
            Some(Ok(recorded)) => recorded,
            // One that panicked has said why.
            Some(Err(_)) | None => Ok(()),
        }
    }
}

impl Drop for Record {
    fn drop(&mut self) {
        // What went wrong was said when it did.
        let _ = self.end();
    }
}

/// Where a recording grows.
fn part(path: &Path) -> PathBuf {
    let mut name = OsString::from(path);
    name.push(".part");
    name.into()
}

/// A topic of the file.
#[derive(Clone, Copy)]
struct Channel {
    id: u16,
    /// How many messages it has.
    count: u32,
}

/// State and fault of a board, or why it is not seen.
type Seen = Result<(wire::State, u8), Problem>;

/// The topics of a board.
struct Topics {
    board: Board,
    /// How it was last seen.
    last: Option<Seen>,
    state: Channel,
    reference: Channel,
    pressure: Channel,
    command: Channel,
}

/// The file, while it grows.
struct Sheet {
    out: Out,
    all: Boards,
    /// Of each board at its place among all.
    boards: Vec<Topics>,
    diagnostics: Channel,
}

/// Where it goes.
struct Out {
    part: PathBuf,
    writer: Writer<BufWriter<File>>,
}

impl Out {
    fn of(&self, problem: McapError) -> RecordError {
        RecordError::Mcap { path: self.part.clone(), problem }
    }

    fn channel<M: Message>(&mut self, topic: &str) -> Result<Channel, RecordError> {
        let schema = self.writer.add_schema(M::TYPE, "ros2msg", M::DEFINITION.as_bytes());
        let schema = schema.map_err(|problem| self.of(problem))?;
        let id = self.writer.add_channel(schema, topic, "cdr", &BTreeMap::new());
        Ok(Channel { id: id.map_err(|problem| self.of(problem))?, count: 0 })
    }

    fn write<M: Serialize>(
        &mut self,
        channel: &mut Channel,
        unix_s: f64,
        message: &M,
    ) -> Result<(), RecordError> {
        let time_ns = (1e9 * unix_s) as u64;
        let header = MessageHeader {
            channel_id: channel.id,
            sequence: channel.count,
            log_time: time_ns,
            publish_time: time_ns,
        };
        channel.count = channel.count.wrapping_add(1);
        let written = self.writer.write_to_known_channel(&header, &bytes::of(message)?);
        written.map_err(|problem| self.of(problem))
    }
}

impl Sheet {
    fn begin(part: PathBuf, file: File, all: &Boards) -> Result<Self, RecordError> {
        let options =
            WriteOptions::new().profile("ros2").library(concat!("mgpi ", env!("CARGO_PKG_VERSION")));
        let writer = options.create(BufWriter::new(file));
        let writer = writer.map_err(|problem| RecordError::Mcap { path: part.clone(), problem })?;
        let mut out = Out { part, writer };
        let diagnostics = out.channel::<DiagnosticArray>("/diagnostics")?;
        let mut sheet = Self { out, all: all.clone(), boards: Vec::new(), diagnostics };
        sheet.arrange()?;
        Ok(sheet)
    }

    /// There are other boards than before: those that are new get their topics.
    fn arrange(&mut self) -> Result<(), RecordError> {
        let Self { out, all, boards, .. } = self;
        for board in all.all().into_iter().skip(boards.len()) {
            let topic = |what: &str| format!("/{}/{what}", board.name);
            boards.push(Topics {
                state: out.channel::<JointState>(&topic("joint_state"))?,
                reference: out.channel::<JointState>(&topic("joint_reference"))?,
                pressure: out.channel::<FluidPressure>(&topic("pressure"))?,
                command: out.channel::<FluidPressure>(&topic("command"))?,
                board,
                last: None,
            });
        }
        Ok(())
    }

    fn run(&mut self, listener: &Listener, is_ended: &AtomicBool) -> Result<(), RecordError> {
        let mut flushed = Instant::now();
        while !is_ended.load(Ordering::Relaxed) {
            let news = listener.next(PATIENCE);
            let (index, now) = match &news {
                Some(News::Telemetry(index, told)) => (*index, Ok((told.state, told.fault))),
                Some(News::Problem(index, problem)) => (*index, Err(problem.clone())),
                Some(News::Arranged) => {
                    self.arrange()?;
                    continue;
                }
                Some(News::Trajectory(..)) | None => continue,
            };
            let time_s = match &news {
                Some(News::Telemetry(_, told)) => {
                    self.telemetry(index, told)?;
                    told.time_s
                }
                _ => Boards::now_s(),
            };
            self.change(index, now, time_s)?;
            if flushed.elapsed() >= FLUSH {
                flushed = Instant::now();
                self.out.writer.flush().map_err(|problem| self.out.of(problem))?;
            }
        }
        Ok(())
    }

    fn telemetry(&mut self, index: usize, told: &Telemetry) -> Result<(), RecordError> {
        let (Some(topics), out) = (self.boards.get_mut(index), &mut self.out) else { return Ok(()) };
        let name = &topics.board.name;
        let unix_s = Boards::unix_s(told.time_s);
        let joint = |mm: f64| JointState {
            header: Header::at_s(unix_s),
            name: vec![name.clone()],
            position: vec![mm / MM_PER_M],
            ..JointState::default()
        };
        let pressure = |bar: f64| FluidPressure {
            header: Header { frame_id: name.clone(), ..Header::at_s(unix_s) },
            fluid_pressure: PA_PER_BAR * bar,
            variance: 0.0,
        };
        out.write(&mut topics.state, unix_s, &joint(told.contraction_mm))?;
        if let Some(reference_mm) = told.reference_mm {
            out.write(&mut topics.reference, unix_s, &joint(reference_mm))?;
        }
        out.write(&mut topics.pressure, unix_s, &pressure(told.pressure_bar))?;
        out.write(&mut topics.command, unix_s, &pressure(told.command_bar))
    }

    /// Writes how a board is seen, if that is new.
    fn change(&mut self, index: usize, now: Seen, time_s: f64) -> Result<(), RecordError> {
        let Some(Topics { board, last, .. }) = self.boards.get_mut(index) else { return Ok(()) };
        if last.as_ref() == Some(&now) {
            return Ok(());
        }
        let (level, message) = match &now {
            Ok((_, fault)) if *fault != 0 => {
                let name =
                    wire::Fault::of_code(*fault).map_or_else(String::new, |fault| format!(": {fault:?}"));
                (DiagnosticStatus::ERROR, format!("fault {fault}{name}"))
            }
            Ok((state, _)) => (DiagnosticStatus::OK, format!("{state:?}")),
            Err(problem) => (DiagnosticStatus::STALE, problem.in_words()),
        };
        let hardware_id = format!("{}/{}", board.line, board.number);
        let status =
            DiagnosticStatus { level, name: board.name.clone(), message, hardware_id, values: Vec::new() };
        let unix_s = Boards::unix_s(time_s);
        *last = Some(now);
        let message = DiagnosticArray { header: Header::at_s(unix_s), status: vec![status] };
        self.out.write(&mut self.diagnostics, unix_s, &message)
    }

    fn finish(&mut self, path: &Path) -> Result<(), RecordError> {
        self.out.writer.finish().map_err(|problem| self.out.of(problem))?;
        fs::rename(&self.out.part, path).map_err(|problem| RecordError::Io { path: path.to_owned(), problem })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::boards::tests::three;
    use crate::seen::tests::telemetry;

    #[test]
    fn each_answer_is_recorded_with_its_time_and_the_file_gets_its_name_at_the_end() {
        let directory = tempfile::tempdir().expect("a directory");
        let file = directory.path().join("lab.mcap");
        let boards = three();
        let record = Record::start(&file, &boards, false).expect("it begins");
        assert!(matches!(Record::start(&file, &boards, false), Err(RecordError::Exists(_))));
        for k in 0..100 {
            boards.telemetry(k % 3, Telemetry { time_s: 0.01 * k as f64, ..telemetry() });
        }
        boards.problem(1, Problem::Silent("no answer".to_owned()));
        thread::sleep(Duration::from_millis(200));
        assert!(!file.exists());
        record.finish().expect("written");
        let content = fs::read(&file).expect("a file");
        let messages: Vec<_> =
            mcap::MessageStream::new(&content).expect("MCAP").collect::<Result<_, _>>().expect("whole");
        let of = |topic: &str| messages.iter().filter(|message| message.channel.topic == topic).count();
        assert_eq!((of("/line-1/1/joint_state"), of("/line-1/2/pressure")), (34, 33));
        assert_eq!(of("/line-1/3/joint_reference"), 0);
        // Three boards seen for the first time, one lost.
        assert_eq!(of("/diagnostics"), 4);
        let times: Vec<u64> = messages
            .iter()
            .filter(|message| message.channel.topic.ends_with("/pressure"))
            .map(|message| message.log_time)
            .collect();
        let spans = times.windows(2).map(|pair| (pair[1] - pair[0]) as f64);
        assert!(
            spans.into_iter().all(|span_ns| (span_ns - 1e7).abs() < 2e6),
            "the times are those of the boards"
        );
    }

    #[test]
    fn a_disk_that_is_full_ends_the_recording_alone() {
        let full = Path::new("/dev/full");
        if !full.exists() {
            return;
        }
        let directory = tempfile::tempdir().expect("a directory");
        let file = directory.path().join("lab.mcap");
        std::os::unix::fs::symlink(full, part(&file)).expect("a link");
        let boards = three();
        // It may fail at its first byte or later.
        let Ok(record) = Record::start(&file, &boards, true) else { return };
        for _ in 0..20 {
            boards.telemetry(0, telemetry());
            thread::sleep(Duration::from_millis(100));
        }
        let failed = record.finish().expect_err("the disk is full").to_string();
        assert!(failed.contains("lab.mcap.part"), "{failed}");
        assert!(!file.exists());
    }
}
