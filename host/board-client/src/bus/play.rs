//! Plays set points and records what becomes of them, to the end, a stop or a fault. However it
//! ends, the valve is vented.
//!
//! # How time is kept
//! By the board: set points are pushed ahead into its queue, and played at equal intervals of its
//! ticks; every recorded tick carries its number. So neither the bus's timing nor this program's
//! shows in a recording.

use std::thread;
use std::time::{Duration, Instant};

use model_core::Mode;
use wire::registers::{
    Access, CAPTURE_SAMPLES, Command, Id, SAMPLE_REGISTERS, STREAM_POINTS, StreamOrder, StreamState, Value,
    mode_number, unpack_sample,
};
use wire::{CaptureSample, State};

use super::Board;
use super::board::{Block, Identity};
use super::client::BusError;
use super::error::BoardError;
use crate::stop::Stop;

/// Set points a second. Slow enough for the bus to keep the queue full, fast enough for a straight
/// line between two.
pub const POINTS_PER_S: f64 = 100.0;
/// How long the muscle is held at the first reference before it moves on.
const APPROACH: Duration = Duration::from_secs(1);
/// A pause where the bus has nothing to do.
const PAUSE: Duration = Duration::from_millis(5);
/// A rest of time for whatever else goes over the bus, as a share of what the recording takes.
const SPARE: f64 = 1.5;

/// What the set points drive.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Drive {
    /// The valve, without a controller. Unit of the points: bar.
    Valve,
    /// The controller, in this mode. Unit of the points: mm.
    Controller(Mode),
}

/// What is given the recorded ticks as they come, and may look at the board meanwhile.
pub type Heard<'a> = dyn FnMut(&mut Board, &[Tick]) -> Result<(), BoardError> + 'a;

/// What is to be played, and how it is recorded.
#[derive(Clone, Debug)]
pub struct Piece {
    /// What the points drive.
    pub drive: Drive,
    /// [`POINTS_PER_S`] of them a second; at least one.
    pub points: Vec<f32>,
    /// Every Nth tick is recorded; none: as many as the bus carries.
    pub every: Option<u16>,
}

/// A recorded tick.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Tick {
    /// Since the first point. Unit: s.
    pub time_s: f64,
    /// Measured. Unit: bar.
    pub pressure_bar: f64,
    /// Measured. Unit: mm.
    pub contraction_mm: f64,
    /// What was put out to the valve. Unit: bar.
    pub command_bar: f64,
    /// The feedback's part of it. Unit: bar.
    pub feedback_bar: f64,
}

/// What was played.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Played {
    /// Recorded ticks.
    pub rows: usize,
    /// Ticks from row to row.
    pub every: u16,
    /// Rows that the bus was too slow for.
    pub lost_rows: usize,
    /// Ticks that found the one before unfinished, during the run.
    pub overruns: u32,
}

/// Plays a piece; `heard` is given the recorded ticks as they come.
///
/// # Errors
/// The board is in no state for it, trips, does not answer, has run out of points; a stop; `heard`
/// has failed.
pub fn play(
    board: &mut Board,
    piece: &Piece,
    stop: &Stop,
    heard: &mut Heard<'_>,
) -> Result<Played, BoardError> {
    check_points(piece)?;
    check(board, piece)?;
    let started = start(board, piece).and_then(|()| Player::prepare(board, piece));
    let played = started.and_then(|mut player| player.run(board, stop, heard));
    let vented = board.stop();
    let played = played?;
    vented?;
    Ok(played)
}

/// Whether the board takes every point.
fn check_points(piece: &Piece) -> Result<(), BoardError> {
    let register = match piece.drive {
        Drive::Valve => Id::SetpointBar.register(),
        Drive::Controller(_) => Id::SetpointMm.register(),
    };
    let refused = |point: &f32| !register.takes(Value::F32(*point));
    let (Some(place), Access::Write(min, max)) = (piece.points.iter().position(refused), register.access)
    else {
        return Ok(());
    };
    let (time_s, value) = (place as f64 / POINTS_PER_S, piece.points[place]);
    Err(BoardError::Point { time_s, value, unit: register.unit, min, max })
}

/// Whether the board is in a state from which the points may drive it.
fn check(board: &mut Board, piece: &Piece) -> Result<(), BoardError> {
    let state = board.settled()?;
    let needed = match (piece.drive, state) {
        (_, State::Ready) | (Drive::Valve, State::Off) => return Ok(()),
        (_, state) if state.is_driven() => "somebody else drives it: mgpi status --stop ends that",
        (Drive::Controller(_), State::Off) => "without a model: mgpi deploy brings it one",
        _ => "and does not get ready",
    };
    Err(BoardError::State { state, needed })
}

/// Brings the board into the state in which the points drive it.
fn start(board: &mut Board, piece: &Piece) -> Result<(), BoardError> {
    match piece.drive {
        Drive::Valve => board.drive(Command::Service, State::Service),
        Drive::Controller(mode) => {
            let first = Value::F32(piece.points.first().copied().unwrap_or_default());
            let mode: Vec<u16> = std::iter::once(mode_number(mode)).chain(first.words()).collect();
            board.write(Id::Mode, &mode)?;
            board.drive(Command::Start, State::Tracking)
        }
    }
}

/// The piece while it is played.
struct Player<'a> {
    piece: &'a Piece,
    identity: Identity,
    interval: u16,
    every: u16,
    pushed: usize,
    is_playing: bool,
    is_ended: bool,
    /// The tick of the first point, once it has been played.
    start_tick: Option<u32>,
    /// Number of the next sample to read.
    next: u32,
    overruns: u32,
    played: Played,
}

impl<'a> Player<'a> {
    /// Fills the queue and begins to record.
    fn prepare(board: &mut Board, piece: &'a Piece) -> Result<Self, BoardError> {
        let identity = board.identity().clone();
        let interval = (1.0 / (POINTS_PER_S * identity.period_s)).round().max(1.0) as u16;
        board.write(Id::StreamOrder, &[StreamOrder::Clear.number(), interval])?;
        let every = match piece.every {
            Some(every) => every,
            None => carried(board, identity.period_s)?,
        };
        let overruns = board.read(Id::Overruns, Id::Overruns)?.whole(Id::Overruns);
        let played = Played { every, ..Played::default() };
        let mut player = Self {
            piece,
            identity,
            interval,
            every,
            pushed: 0,
            is_playing: false,
            is_ended: false,
            start_tick: None,
            next: 0,
            overruns,
            played,
        };
        let free = stream(board)?.whole(Id::StreamFree);
        player.push(board, free)?;
        if matches!(piece.drive, Drive::Controller(_)) {
            // The board vents where its host is silent.
            let arrived = Instant::now() + APPROACH;
            while Instant::now() < arrived {
                stream(board)?;
                thread::sleep(PAUSE);
            }
        }
        board.write(Id::CaptureEvery, &[every])?;
        order(board, StreamOrder::Play)?;
        player.is_playing = true;
        player.push(board, 0)?;
        Ok(player)
    }

    fn run(&mut self, board: &mut Board, stop: &Stop, heard: &mut Heard<'_>) -> Result<Played, BoardError> {
        loop {
            if stop.is_requested() {
                return Err(BoardError::Stopped);
            }
            let now = stream(board)?;
            match StreamState::of_number(now.whole(Id::StreamState) as u16) {
                Some(StreamState::Playing | StreamState::Done) => {}
                // Behind the last point it takes a tick to notice the end.
                Some(StreamState::Underrun) if self.is_ended => {}
                Some(StreamState::Underrun) => return Err(BoardError::Underrun),
                _ => return Err(self.tripped(board)?),
            }
            // The first point is taken at the order to play, and played when the second is taken.
            let is_done = now.whole(Id::StreamState) == u32::from(StreamState::Done.number());
            if self.start_tick.is_none() && (now.whole(Id::StreamConsumed) > 1 || is_done) {
                self.start_tick = Some(now.whole(Id::StreamStart));
            }
            self.push(board, now.whole(Id::StreamFree))?;
            let Some(start_tick) = self.start_tick else { continue };
            if self.record(board, start_tick, heard)? {
                let overruns = board.read(Id::Overruns, Id::Overruns)?.whole(Id::Overruns);
                self.played.overruns = overruns.wrapping_sub(self.overruns);
                return Ok(self.played);
            }
        }
    }

    /// Pushes as many points as there are places; behind the last one of a piece that plays, says
    /// so.
    fn push(&mut self, board: &mut Board, mut free: u32) -> Result<(), BoardError> {
        while self.pushed < self.piece.points.len() {
            let left = &self.piece.points[self.pushed..];
            let count = left.len().min(STREAM_POINTS.into());
            if (free as usize) < count {
                return Ok(());
            }
            let number = Value::U32(self.pushed as u32);
            let points = left[..count].iter().map(|&point| Value::F32(point));
            let words: Vec<u16> = std::iter::once(number).chain(points).flat_map(Value::words).collect();
            // May be repeated: the board passes over what it has.
            board.write(Id::PushNumber, &words)?;
            self.pushed += count;
            free -= count as u32;
        }
        if self.is_playing && !self.is_ended {
            order(board, StreamOrder::End)?;
            self.is_ended = true;
        }
        Ok(())
    }

    /// Reads a window of recorded ticks; answers whether that of the last point was among them.
    fn record(
        &mut self,
        board: &mut Board,
        start_tick: u32,
        heard: &mut Heard<'_>,
    ) -> Result<bool, BoardError> {
        board.set(Id::CaptureFrom, self.next.into())?;
        let window = board.read(Id::CaptureFirst, Id::CaptureWindow)?;
        let (first, first_tick) = (window.whole(Id::CaptureFirst), window.whole(Id::CaptureFirstTick));
        let last_tick = (self.piece.points.len() as i64 - 1) * i64::from(self.interval);
        let mut ticks = Vec::with_capacity(CAPTURE_SAMPLES.into());
        let mut is_last = false;
        let samples = window.words(Id::CaptureWindow).chunks_exact(SAMPLE_REGISTERS.into());
        let count = window.whole(Id::CaptureCount);
        for (place, words) in (0..count).zip(samples) {
            let tick = first_tick.wrapping_add(place * u32::from(self.every));
            // Negative before the first point.
            let since = i64::from(tick.wrapping_sub(start_tick).cast_signed());
            is_last |= since + i64::from(self.every) > last_tick;
            if let Ok(words) = words.try_into()
                && (0..=last_tick).contains(&since)
            {
                ticks.push(self.tick(since, &unpack_sample(words)));
            }
        }
        if count > 0 {
            // Those before the first point are nobody's loss.
            let lost = first.wrapping_sub(self.next);
            self.played.lost_rows += if self.played.rows > 0 { lost as usize } else { 0 };
            self.next = first.wrapping_add(count);
        }
        self.played.rows += ticks.len();
        heard(board, &ticks)?;
        if count < u32::from(CAPTURE_SAMPLES) {
            thread::sleep(PAUSE);
        }
        Ok(is_last)
    }

    fn tick(&self, since: i64, sample: &CaptureSample) -> Tick {
        let Identity { pressure, contraction, command, period_s, .. } = &self.identity;
        // Six digits of a second: a tick's number times its period leaves noise behind them.
        let time_s = (since as f64 * period_s * 1e6).round() / 1e6;
        let rounded = |value: f32| (f64::from(value) * 1e4).round() / 1e4;
        Tick {
            time_s,
            pressure_bar: rounded(pressure.value(sample.pressure_code)),
            contraction_mm: rounded(contraction.value(sample.contraction_code)),
            command_bar: rounded(command.value(sample.dac_code)),
            feedback_bar: rounded(f32::from(sample.feedback_4096th_bar) / 4096.0),
        }
    }

    /// Why the board plays no longer.
    fn tripped(&self, board: &mut Board) -> Result<BoardError, BoardError> {
        let (state, fault) = board.state()?;
        Ok(if state == State::Fault { BoardError::Fault(fault) } else { BoardError::Vented(state) })
    }
}

/// Gives the player an order, which it takes once. One whose answer was lost is looked up.
fn order(board: &mut Board, order: StreamOrder) -> Result<(), BusError> {
    match board.write_once(Id::StreamOrder, &[order.number()], 1) {
        Err(error) if error.is_lost() => {
            let taken = board.read(Id::StreamOrder, Id::StreamOrder)?.whole(Id::StreamOrder);
            if taken == u32::from(order.number()) {
                return Ok(());
            }
            board.write_once(Id::StreamOrder, &[order.number()], 1)
        }
        done => done,
    }
}

fn stream(board: &mut Board) -> Result<Block, BoardError> {
    Ok(board.read(Id::StreamState, Id::StreamStart)?)
}

/// The smallest spacing of recorded ticks that the bus can carry, from the measured time to read
/// a window.
fn carried(board: &mut Board, period_s: f64) -> Result<u16, BoardError> {
    let begin = Instant::now();
    board.set(Id::CaptureFrom, 0.0)?;
    board.read(Id::CaptureFirst, Id::CaptureWindow)?;
    stream(board)?;
    let window_s = begin.elapsed().as_secs_f64();
    Ok((SPARE * window_s / (f64::from(CAPTURE_SAMPLES) * period_s)).ceil().clamp(1.0, 1000.0) as u16)
}
