//! A trajectory on its way to a board: points at equal intervals into the board's own queue, a start
//! that is counted down by the board, and more points while it plays.
//!
//! # Method
//! The board interpolates between points that lie `POINT_S` apart by its own clock, so that neither
//! the line nor this machine shows in the movement. Where its clock gains or loses, later points are
//! taken from the trajectory at the host's time of their ticks.
//!
//! # Contract
//! Points are a sign of life to the board: a step is made only in a round in which the client has
//! said that it lives.

use board_client::bus::client::{BusError, Client};
use wire::registers::{Id, STREAM_POINTS, StreamOrder, StreamState, Value};

use crate::seen::Progress;
use crate::start::{Phase, Start};
use crate::trajectory::Trajectory;

/// From point to point: as fast as the bus keeps the queue full, slow enough for a straight line
/// between two (as `mgpi track` plays). Unit: s.
const POINT_S: f64 = 0.01;
/// How often an exchange is tried in a round: the line's other boards wait meanwhile.
const TRIES: usize = 2;
/// From one look at the board's queue to the next while it plays: a block of points is played in
/// 0.6 s, the queue holds 2.5 s. Unit: s.
const LOOK_S: f64 = 0.1;

/// A trajectory of a board.
#[derive(Debug)]
pub struct Stream {
    trajectory: Trajectory,
    start: Start,
    step: Step,
    /// What the board was asked for before. Unit: mm.
    before_mm: f64,
    /// Ticks from point to point.
    interval_ticks: u16,
    /// The next point's time in the trajectory. Unit: s.
    next_s: f64,
    pushed: u32,
    is_last_pushed: bool,
    /// When the board's queue was looked at last, since the gateway's start. Unit: s.
    looked_s: f64,
}

/// How far it has come.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Step {
    /// The board's queue is not its own so far.
    Clear,
    /// Points go into the queue.
    Fill,
    /// The board has its points; the other boards, or the start, are waited for.
    Wait,
    /// It has been counted down; whether the board has heard that is to be seen.
    Counted,
    /// The board plays.
    Play,
}

/// The board's time for a stream.
#[derive(Clone, Copy, Debug)]
pub struct Time {
    /// Now, since the gateway's start. Unit: s.
    pub now_s: f64,
    /// Of a tick of the board, by its own clock. Unit: s.
    pub period_s: f64,
    /// By which share the board's clock gains.
    pub drift: f64,
}

/// What the board tells of its queue.
struct Queue {
    state: Option<StreamState>,
    free: u16,
    underrun_ticks: u32,
    start_tick: u32,
    play_in_ticks: u16,
}

impl Queue {
    fn read(client: &mut Client) -> Result<Self, BusError> {
        let (first, last) = (Id::StreamState.register(), Id::StreamPlayIn.register());
        let words = client.read_in(first.address, last.end() - first.address, TRIES)?;
        let number = |id: Id| {
            let register = id.register();
            let from = usize::from(register.address - first.address);
            let value = words.get(from..).and_then(|words| Value::of_words(register.kind, words));
            value.map_or(0.0, Value::number)
        };
        Ok(Self {
            state: StreamState::of_number(number(Id::StreamState) as u16),
            free: number(Id::StreamFree) as u16,
            underrun_ticks: number(Id::StreamUnderrun) as u32,
            start_tick: number(Id::StreamStart) as u32,
            play_in_ticks: number(Id::StreamPlayIn) as u16,
        })
    }
}

impl Stream {
    /// A trajectory that shall begin with others.
    pub fn new(trajectory: Trajectory, start: Start) -> Self {
        Self {
            trajectory,
            start,
            step: Step::Clear,
            before_mm: 0.0,
            interval_ticks: 1,
            next_s: 0.0,
            pushed: 0,
            is_last_pushed: false,
            looked_s: f64::NEG_INFINITY,
        }
    }

    /// Its start.
    pub fn start(&self) -> &Start {
        &self.start
    }

    /// Whether it has not begun to play, as far as is known.
    pub fn waits(&self) -> bool {
        self.step != Step::Play
    }

    /// Whether the board has all points that its queue takes.
    pub fn is_filled(&self) -> bool {
        !matches!(self.step, Step::Clear | Step::Fill)
    }

    /// Whether a countdown is what it waits for.
    pub fn awaits_countdown(&self) -> bool {
        self.step == Step::Wait && self.start.phase() == Phase::Ready
    }

    /// A countdown has gone out.
    pub fn counted(&mut self) {
        if self.awaits_countdown() {
            (self.step, self.looked_s) = (Step::Counted, f64::NEG_INFINITY);
        }
    }

    /// Does what is next, in at most two exchanges; what is to be told of it.
    ///
    /// # Errors
    /// The board has not done it.
    pub fn step(&mut self, client: &mut Client, time: Time) -> Result<Option<Progress>, BusError> {
        match self.step {
            Step::Clear => {
                let setpoint = Id::SetpointMm.register();
                self.interval_ticks = (POINT_S / time.period_s).round().max(1.0) as u16;
                let clear = [StreamOrder::Clear.number(), self.interval_ticks];
                client.write_in(Id::StreamOrder.register().address, &clear, TRIES)?;
                let words = client.read_in(setpoint.address, setpoint.words(), TRIES)?;
                self.before_mm = Value::of_words(setpoint.kind, &words).map_or(0.0, Value::number);
                self.step = Step::Fill;
                Ok(None)
            }
            Step::Fill => {
                let free = Queue::read(client)?.free;
                if !self.is_last_pushed && free >= STREAM_POINTS {
                    self.push(client, time)?;
                    return Ok(None);
                }
                self.step = Step::Wait;
                self.start.prepared();
                Ok(Some(Progress::Ready { start_s: self.start.at_s }))
            }
            Step::Wait => Ok(None),
            Step::Counted | Step::Play if time.now_s < self.looked_s + LOOK_S => Ok(None),
            Step::Counted => {
                self.looked_s = time.now_s;
                let queue = Queue::read(client)?;
                if queue.state == Some(StreamState::Idle) {
                    // It has not heard the countdown: the next one.
                    self.step = Step::Wait;
                    return Ok(None);
                }
                if self.is_last_pushed {
                    self.end(client)?;
                }
                if queue.play_in_ticks > 0 {
                    return Ok(None);
                }
                self.step = Step::Play;
                self.looked_s = f64::NEG_INFINITY;
                Ok(Some(Progress::Playing { start_tick: queue.start_tick, start_s: 0.0, bound_s: 0.0 }))
            }
            Step::Play => {
                self.looked_s = time.now_s;
                let queue = Queue::read(client)?;
                match queue.state {
                    Some(StreamState::Done) => {
                        Ok(Some(Progress::Done { underrun_ticks: queue.underrun_ticks }))
                    }
                    Some(StreamState::Playing | StreamState::Underrun) => {
                        if !self.is_last_pushed && queue.free >= STREAM_POINTS {
                            self.push(client, time)?;
                        } else if self.is_last_pushed {
                            self.end(client)?;
                        }
                        Ok(None)
                    }
                    _ => Ok(Some(Progress::Ended { reason: "the board plays no longer".to_owned() })),
                }
            }
        }
    }

    /// Says that no more points come; it may be said again.
    fn end(&self, client: &mut Client) -> Result<(), BusError> {
        let end = client.write_in(Id::StreamOrder.register().address, &[StreamOrder::End.number()], TRIES);
        match end {
            // It has come to its end meanwhile.
            Err(refused) if refused.exception().is_some() => Ok(()),
            done => done,
        }
    }

    /// Pushes the next block of points, which may be repeated.
    fn push(&mut self, client: &mut Client, time: Time) -> Result<(), BusError> {
        let spacing_s = f64::from(self.interval_ticks) * time.period_s / (1.0 + time.drift);
        let (mut next_s, mut is_last) = (self.next_s, false);
        let mut words = Value::U32(self.pushed).words().collect::<Vec<u16>>();
        let mut count = 0;
        while count < u32::from(STREAM_POINTS) && !is_last {
            is_last = next_s >= self.trajectory.duration_s();
            words.extend(Value::F32(self.trajectory.at(next_s, self.before_mm) as f32).words());
            next_s += spacing_s;
            count += 1;
        }
        client.write_in(Id::PushNumber.register().address, &words, TRIES)?;
        self.pushed += count;
        (self.next_s, self.is_last_pushed) = (next_s, is_last);
        Ok(())
    }
}

/// Makes the board that the client is turned to forget its points; it stays where it is asked to be.
///
/// # Errors
/// It has not done so.
pub fn clear(client: &mut Client) -> Result<(), BusError> {
    client.write_in(Id::StreamOrder.register().address, &[StreamOrder::Clear.number()], TRIES)
}
