//! Registers read and written: a Modbus RTU client.
//!
//! # Lost answers
//! A question whose answer does not come, or comes damaged, is asked again, `TRIES` times in all.
//! That does no harm where a question leads to the same state however often it is heard: readings,
//! and writings of values. What counts what it hears (a command, a push into a queue) is written by
//! [`Client::write_once`], and whoever asks finds out by a reading whether it was heard
//! ([`BusError::is_lost`]).
//!
//! # Sign of life
//! A board that drives its valve wants another number in its heartbeat at short intervals. Whoever
//! has opened it says so by [`Client::beat_each`]. From then on each reading carries one (function
//! 23, which writes and reads), another one at each try; before a writing it goes out by itself,
//! where it is due. It is counted here, by the program's own thread, question by question: where
//! that hangs, no question and no heartbeat comes.
//!
//! # Limits
//! The port is emptied before each question, and of late answers after one that was asked again;
//! one that is later still is taken for noise as long as it differs in unit, function or length.

use std::path::PathBuf;
use std::thread;
use std::time::{Duration, Instant};

use crc::{CRC_16_MODBUS, Crc};
use rmodbus::client::ModbusRequest;
use rmodbus::{ErrorKind, ModbusProto};
use thiserror::Error;
use wire::BusParameters;
use wire::registers::{Id, Register};
use wire::slots::{self, ANSWER_BYTES, Answer, Member, Slots};

use super::port::{Line, Port, PortError};

/// How often a question is asked. Before each try a heartbeat may be due for the board, which vents
/// where its host is silent for longer than its limit: so a question is asked often rather than
/// long.
const TRIES: usize = 16;
/// What comes after so long a silence is no answer to a question before.
const LATE: Duration = Duration::from_millis(30);
/// So long what comes late is waited for: somebody who goes on sends no answers.
const LATEST: Duration = Duration::from_millis(300);
/// Behind the answer of the last slot the others are over, too: what came together may be read
/// apart.
const OVER: Duration = Duration::from_millis(2);
/// The most registers of a reading.
pub const MOST_READ: u16 = 125;
/// The most registers of a writing.
pub const MOST_WRITTEN: usize = 123;
/// An answer without its content: unit, function, length or exception, CRC. Unit: byte.
const SHORTEST: usize = 5;
/// Answer to a writing: unit, function, address, value or count, CRC. Unit: byte.
const WRITTEN: usize = 8;
/// The bit that marks the function of an exception.
const EXCEPTION: u8 = 0x80;

/// Whether an answer, as far as it has come, is an exception.
fn is_exception(answer: &[u8]) -> bool {
    answer.get(1).is_some_and(|function| function & EXCEPTION != 0)
}

/// Why registers were not read or written.
#[derive(Debug, Error)]
#[allow(missing_docs, reason = "the messages say what the variants and their fields are")]
pub enum BusError {
    #[error(transparent)]
    Port(#[from] PortError),
    #[error(
        "{}: no answer from unit {unit} within {limit_s} s, asked {tries} times: is the board powered, its unit {unit} \
         and its rate {baud} bit/s, are A and B swapped?", port.display()
    )]
    Silent { port: PathBuf, unit: u8, limit_s: f64, tries: usize, baud: u32 },
    #[error("{}: damaged answers only ({problem}): is the rate {baud} bit/s, has one board alone this number?", port.display())]
    Damaged { port: PathBuf, problem: ErrorKind, baud: u32 },
    #[error("the board refuses to {question}: {}", in_words(*.exception))]
    Refused { question: String, exception: ErrorKind },
}

impl BusError {
    /// Whether the board may have heard the question, only its answer is missing.
    pub fn is_lost(&self) -> bool {
        matches!(self, Self::Silent { .. } | Self::Damaged { .. })
    }

    /// What the board says against it, if that is the reason.
    pub fn exception(&self) -> Option<ErrorKind> {
        match self {
            Self::Refused { exception, .. } => Some(*exception),
            _ => None,
        }
    }
}

/// What stands at an address.
fn named(address: u16) -> String {
    Register::at(address)
        .map_or_else(|| format!("register {address:#06x}"), |register| register.name.to_owned())
}

fn in_words(exception: ErrorKind) -> String {
    match exception {
        ErrorKind::IllegalFunction => "it does not know the function".to_owned(),
        ErrorKind::IllegalDataAddress => "it has no such register".to_owned(),
        ErrorKind::IllegalDataValue => "the value is outside its limits".to_owned(),
        ErrorKind::SlaveDeviceFailure => "it could not carry it out".to_owned(),
        ErrorKind::SlaveDeviceBusy => "not in its present state".to_owned(),
        other => other.to_string(),
    }
}

/// Where a board is, and how patient to be.
#[derive(Clone, Debug)]
pub struct Address {
    /// The port's path or name.
    pub port: PathBuf,
    /// How the bytes go over it.
    pub line: Line,
    /// The board's number on the bus, 1 to 247.
    pub unit: u8,
    /// Longest time for an answer.
    pub limit: Duration,
}

/// The least silence between two frames, however fast the line (Modbus over serial line 1.02,
/// 2.5.1.1).
const LEAST_SILENCE: Duration = Duration::from_micros(1750);
/// The same for slow lines, in bits: 3.5 characters.
const SILENCE_BITS: f64 = 3.5 * 11.0;

/// What a question does.
#[derive(Clone, Copy, Debug)]
enum Kind<'a> {
    /// Reads; it may carry the heartbeat.
    Reading,
    /// Writes these values from this address on, then reads.
    WritingFirst(u16, &'a [u16]),
    /// Writes.
    Writing,
}

/// What is asked.
struct Question<'a> {
    request: &'a ModbusRequest,
    frame: &'a [u8],
    kind: Kind<'a>,
    /// Length of the answer. Unit: byte.
    expected: usize,
    /// For a message.
    words: &'a dyn Fn() -> String,
}

/// A client of one board.
#[derive(Debug)]
pub struct Client {
    port: Port,
    address: Address,
    /// When the last frame ended.
    ended: Instant,
    heartbeat: Option<Heartbeat>,
}

/// The sign of life.
#[derive(Debug)]
struct Heartbeat {
    number: u16,
    each: Duration,
    /// When the last one was taken.
    taken: Instant,
}

impl Heartbeat {
    /// Another number.
    fn next(&mut self) -> u16 {
        self.number = self.number.wrapping_add(1);
        self.number
    }

    /// It was taken now.
    fn taken(&mut self) {
        self.taken = Instant::now();
    }
}

/// The number that all boards listen to.
const BROADCAST: u8 = 0;
/// A frame's checksum.
const CRC: Crc<u16> = Crc::<u16>::new(&CRC_16_MODBUS);
/// Functions that read, and that write and read.
const READING: u8 = 3;
const READ_WRITE: u8 = 23;

fn framed(content: Vec<u8>) -> Vec<u8> {
    let crc = CRC.checksum(&content).to_le_bytes();
    [content, crc.to_vec()].concat()
}

/// The frame of a reading as one that writes first: the registers to read, those to write, bytes
/// and content of these.
fn with_writing(reading: &[u8], address: u16, values: &[u16]) -> Vec<u8> {
    let [unit, _, registers @ .., _, _] = reading else { return reading.to_vec() };
    let write = [address, values.len() as u16].map(u16::to_be_bytes).concat();
    let content: Vec<u8> = values.iter().flat_map(|value| value.to_be_bytes()).collect();
    framed([&[*unit, READ_WRITE], registers, &write[..], &[content.len() as u8], &content[..]].concat())
}

/// The answer to such a frame as that to the reading alone; anything else as it is.
fn as_reading(answer: Vec<u8>) -> Vec<u8> {
    match &*answer {
        [unit, function, rest @ .., _, _]
            if function & !EXCEPTION == READ_WRITE
                && framed(answer[..answer.len() - 2].to_vec()) == answer =>
        {
            framed([&[*unit, READING | function & EXCEPTION], rest].concat())
        }
        _ => answer,
    }
}

/// Takes the whole answers of members out of what has come, and what is before them: noise.
fn members_answers(come: &mut Vec<u8>, members: &[Member]) -> Vec<Answer> {
    let mut answers = Vec::new();
    let mut place = 0;
    while let Some(frame) = come.get(place..place + ANSWER_BYTES) {
        let answer =
            Answer::of_frame(frame).filter(|answer| members.iter().any(|member| member.unit == answer.unit));
        place += answer.map_or(1, |_| ANSWER_BYTES);
        answers.extend(answer);
    }
    come.drain(..place);
    answers
}

impl Client {
    /// Opens the port.
    ///
    /// # Errors
    /// It cannot be used.
    pub fn open(address: Address) -> Result<Self, PortError> {
        let port = Port::open(&address.port, address.line)?;
        Ok(Self { port, address, ended: Instant::now(), heartbeat: None })
    }

    /// Asks the board of another number from now on.
    pub fn turn_to(&mut self, unit: u8) {
        self.address.unit = unit;
    }

    /// From now on says so often that this program lives; `None`: no more. `last`: the number that
    /// the board was told before.
    pub fn beat_each(&mut self, each: Option<Duration>, last: u16) {
        let now = Instant::now();
        self.heartbeat =
            each.map(|each| Heartbeat { number: last, each, taken: now.checked_sub(each).unwrap_or(now) });
    }

    /// Reads `count` registers, at most [`MOST_READ`].
    ///
    /// # Errors
    /// No answer, or a refusal.
    pub fn read(&mut self, address: u16, count: u16) -> Result<Vec<u16>, BusError> {
        self.read_in(address, count, TRIES)
    }

    /// The same, with so many tries.
    ///
    /// # Errors
    /// No answer, or a refusal.
    pub fn read_in(&mut self, address: u16, count: u16, tries: usize) -> Result<Vec<u16>, BusError> {
        self.get(Kind::Reading, address, count, tries)
    }

    fn get(&mut self, kind: Kind<'_>, address: u16, count: u16, tries: usize) -> Result<Vec<u16>, BusError> {
        let mut request = self.request();
        let mut frame = Vec::new();
        let made = request.generate_get_holdings(address, count, &mut frame);
        let question = || match kind {
            Kind::WritingFirst(to, _) => format!("write {} and read {}", named(to), named(address)),
            _ => format!("read {}", named(address)),
        };
        made.map_err(|exception| BusError::Refused { question: question(), exception })?;
        let expected = SHORTEST + 2 * usize::from(count);
        let question = Question { request: &request, frame: &frame, kind, expected, words: &question };
        let answer = self.ask(&question, tries, self.address.limit)?;
        let mut values = Vec::with_capacity(count.into());
        let damaged = |problem| self.damaged(problem);
        request.parse_u16(&answer, &mut values).map_err(damaged)?;
        Ok(values)
    }

    /// Writes values and then reads, in one exchange that is tried once (function 23).
    ///
    /// # Errors
    /// A refusal: then nothing was written; or no answer: then perhaps.
    pub fn write_and_read(
        &mut self,
        (to, values): (u16, &[u16]),
        address: u16,
        count: u16,
    ) -> Result<Vec<u16>, BusError> {
        self.get(Kind::WritingFirst(to, values), address, count, 1)
    }

    /// Writes values, at most [`MOST_WRITTEN`], that may be written twice.
    ///
    /// # Errors
    /// No answer, or a refusal: then nothing was written.
    pub fn write(&mut self, address: u16, values: &[u16]) -> Result<(), BusError> {
        self.write_in(address, values, TRIES)
    }

    /// The same, with so many tries.
    ///
    /// # Errors
    /// No answer, or a refusal: then nothing was written.
    pub fn write_in(&mut self, address: u16, values: &[u16], tries: usize) -> Result<(), BusError> {
        self.put(address, values, tries, self.address.limit)
    }

    /// The longest that an answer usually takes.
    pub fn limit(&self) -> Duration {
        self.address.limit
    }

    /// Writes values that must not be written twice; waits `patience` times as long for the answer
    /// as usual.
    ///
    /// # Errors
    /// A refusal: then nothing was written; or no answer: then perhaps.
    pub fn write_once(&mut self, address: u16, values: &[u16], patience: u32) -> Result<(), BusError> {
        self.put(address, values, 1, patience * self.address.limit)
    }

    fn put(&mut self, address: u16, values: &[u16], tries: usize, limit: Duration) -> Result<(), BusError> {
        let mut request = self.request();
        let mut frame = Vec::new();
        let made = request.generate_set_holdings_bulk(address, values, &mut frame);
        let question = || format!("write {}", named(address));
        made.map_err(|exception| BusError::Refused { question: question(), exception })?;
        let (kind, expected) = (Kind::Writing, WRITTEN);
        let question = Question { request: &request, frame: &frame, kind, expected, words: &question };
        self.ask(&question, tries, limit).map(drop)
    }

    /// Writes values for all boards on the line, none of which answers: whoever has to be sure
    /// writes them more than once.
    ///
    /// # Errors
    /// The port cannot be used.
    pub fn write_all(&mut self, address: u16, values: &[u16]) -> Result<(), PortError> {
        let mut frame = Vec::new();
        let mut request = ModbusRequest::new(BROADCAST, ModbusProto::Rtu);
        if request.generate_set_holdings_bulk(address, values, &mut frame).is_ok() {
            self.exchange(&frame, 0, self.address.limit)?;
        }
        Ok(())
    }

    /// Tells all members of an exchange in slots at once, and takes their answers, until the last
    /// slot is over and the limit behind it, or there are no more to come. Answers each with the
    /// time since the request was sent.
    ///
    /// # Errors
    /// The port cannot be used.
    pub fn exchange_in_slots(
        &mut self,
        sequence: u16,
        gap_us: u16,
        members: &[Member],
    ) -> Result<Vec<(Answer, Duration)>, PortError> {
        let Some(frame) = slots::request(sequence, gap_us, members) else { return Ok(Vec::new()) };
        let Line { baud, parity } = self.address.line;
        let slots =
            Slots::new(&BusParameters { baud, parity: parity.into(), ..BusParameters::STANDARD }, gap_us);
        let takes_us = slots.bytes_us(frame.len()) + slots.begin_us(members.len());
        self.settle();
        self.port.discard()?;
        let begin = Instant::now();
        let mut deadline = begin + Duration::from_micros(takes_us.into()) + self.address.limit;
        self.port.send(&frame, deadline)?;
        let (mut answers, mut come, mut buffer) = (Vec::new(), Vec::new(), [0; 256]);
        while answers.len() < members.len() {
            let count = self.port.receive(&mut buffer, deadline)?;
            if count == 0 {
                break;
            }
            come.extend_from_slice(&buffer[..count]);
            // What belongs to a request before has come too late.
            let of_request = |answer: &Answer| answer.sequence == sequence;
            for answer in members_answers(&mut come, members).into_iter().filter(of_request) {
                if members.last().is_some_and(|last| last.unit == answer.unit) {
                    // The other slots are over, too.
                    deadline = deadline.min(Instant::now() + OVER);
                }
                answers.push((answer, begin.elapsed()));
            }
        }
        self.ended = Instant::now();
        Ok(answers)
    }

    /// Waits for the silence behind the last frame: what is sent next goes out at once.
    pub fn settle(&self) {
        thread::sleep((self.ended + self.silence()).saturating_duration_since(Instant::now()));
    }

    /// How long so many values take from [`Client::write_all`] until the boards have them: the
    /// frame's bytes, and the silence by which they see its end.
    pub fn heard_in(&self, values: usize) -> Duration {
        let bits = 11 * (WRITTEN + 1 + 2 * values);
        Duration::from_secs_f64(bits as f64 / f64::from(self.address.line.baud)) + self.silence()
    }

    /// Between two frames.
    fn silence(&self) -> Duration {
        Duration::from_secs_f64(SILENCE_BITS / f64::from(self.address.line.baud)).max(LEAST_SILENCE)
    }

    fn request(&self) -> ModbusRequest {
        ModbusRequest::new(self.address.unit, ModbusProto::Rtu)
    }

    /// Asks until there is an answer of the expected length, or an exception.
    fn ask(&mut self, question: &Question<'_>, tries: usize, limit: Duration) -> Result<Vec<u8>, BusError> {
        let &Question { request, frame, kind, expected, words } = question;
        let mut damage = None;
        for attempt in 0..tries {
            let answer = match (kind, &mut self.heartbeat) {
                (Kind::WritingFirst(to, values), _) => {
                    as_reading(self.exchange(&with_writing(frame, to, values), expected, limit)?)
                }
                (Kind::Reading, Some(heartbeat)) => {
                    let beat = Id::Heartbeat.register().address;
                    let frame = with_writing(frame, beat, &[heartbeat.next()]);
                    let answer = as_reading(self.exchange(&frame, expected, limit)?);
                    let is_taken = request.parse_ok(&answer).is_ok();
                    self.heartbeat.iter_mut().filter(|_| is_taken).for_each(Heartbeat::taken);
                    answer
                }
                _ => {
                    self.beat()?;
                    self.exchange(frame, expected, limit)?
                }
            };
            if answer.is_empty() {
                continue;
            }
            match request.parse_ok(&answer) {
                Ok(()) if answer.len() == expected => {
                    if attempt > 0 {
                        self.forget()?;
                    }
                    return Ok(answer);
                }
                // What answers another function is no refusal: a late answer to a question before.
                Err(exception) if exception.is_modbus_error() && is_exception(&answer) => {
                    return Err(BusError::Refused { question: words(), exception });
                }
                Ok(()) => damage = Some(ErrorKind::FrameBroken),
                Err(problem) => damage = Some(problem),
            }
        }
        Err(match damage {
            Some(problem) => self.damaged(problem),
            None => self.silent(tries, limit),
        })
    }

    fn silent(&self, tries: usize, limit: Duration) -> BusError {
        let Address { port, line, unit, .. } = &self.address;
        let (port, unit, limit_s, baud) = (port.clone(), *unit, limit.as_secs_f64(), line.baud);
        BusError::Silent { port, unit, limit_s, tries, baud }
    }

    /// Writes the heartbeat, if it is due, once: one that was lost, or is refused by a board that
    /// has none, goes out again before the next question.
    fn beat(&mut self) -> Result<(), PortError> {
        let limit = self.address.limit;
        let mut request = self.request();
        let Some(heartbeat) = self.heartbeat.as_mut().filter(|beat| beat.taken.elapsed() >= beat.each) else {
            return Ok(());
        };
        let (register, number) = (Id::Heartbeat.register(), heartbeat.next());
        let mut frame = Vec::new();
        if request.generate_set_holdings_bulk(register.address, &[number], &mut frame).is_ok() {
            let answer = self.exchange(&frame, WRITTEN, limit)?;
            let is_taken = answer.len() == WRITTEN && request.parse_ok(&answer).is_ok();
            self.heartbeat.iter_mut().filter(|_| is_taken).for_each(Heartbeat::taken);
        }
        Ok(())
    }

    /// Sends a frame behind a silence, and takes what comes until the limit.
    fn exchange(&mut self, frame: &[u8], expected: usize, limit: Duration) -> Result<Vec<u8>, PortError> {
        self.settle();
        self.port.discard()?;
        let deadline = Instant::now() + limit;
        self.port.send(frame, deadline)?;
        let answer = self.answer(expected, deadline)?;
        self.ended = Instant::now();
        Ok(answer)
    }

    /// Takes what still comes behind an answer, as to a question that was asked more than once, for
    /// a while; how many bytes.
    ///
    /// # Errors
    /// The port cannot be used.
    pub fn forget(&mut self) -> Result<usize, PortError> {
        let (mut buffer, mut late, begin) = ([0; 256], 0, Instant::now());
        while begin.elapsed() < LATEST {
            match self.port.receive(&mut buffer, Instant::now() + LATE)? {
                0 => break,
                count => late += count,
            }
        }
        Ok(late)
    }

    /// What comes until an answer is whole: as long as expected, or an exception. What came until
    /// the deadline, if that is first.
    fn answer(&mut self, expected: usize, deadline: Instant) -> Result<Vec<u8>, PortError> {
        let mut answer = Vec::with_capacity(expected);
        let mut buffer = [0; 256];
        loop {
            let whole = if is_exception(&answer) { SHORTEST } else { expected };
            let missing = whole.saturating_sub(answer.len());
            if missing == 0 {
                return Ok(answer);
            }
            match self.port.receive(&mut buffer[..missing.min(256)], deadline)? {
                0 => return Ok(answer),
                count => answer.extend_from_slice(&buffer[..count]),
            }
        }
    }

    fn damaged(&self, problem: ErrorKind) -> BusError {
        BusError::Damaged { port: self.address.port.clone(), problem, baud: self.address.line.baud }
    }
}
