//! Set points at equal intervals, played by the tick: what is tracked, or driven, does not depend
//! on the bus's timing.
//!
//! # Design
//! A bounded queue of points. Behind each tick the player says the set point of the next one, on
//! the straight line between the point that it comes from and the one that it goes to. Points carry
//! numbers, counted from 0 since the last
//! [`Player::clear`], so that a push which is sent twice changes nothing the second time. A player
//! may be told to begin in so many ticks: one frame to all boards of a line then starts them all in
//! the same tick, and one that was lost may be sent again with what is left.
//!
//! # Contract
//! [`Player::next`] takes constant time. Out of points it holds the last one and counts the ticks,
//! and goes on with the next point that comes; after [`StreamOrder::End`] it is done instead.

use heapless::Deque;
use wire::registers::{Exception, QUEUE_POINTS, StreamOrder, StreamState};

/// The queue and where it is played.
#[derive(Clone, Debug)]
pub struct Player {
    points: Deque<f32, { QUEUE_POINTS as usize }>,
    state: StreamState,
    /// Ticks from point to point, at least 1.
    interval_ticks: u16,
    /// Ticks since `from`; before the first point, so that it reaches the interval with it.
    step: i32,
    from: f32,
    to: f32,
    /// Change from tick to tick.
    slope: f32,
    /// Whether no more points come.
    is_ending: bool,
    pushed: u32,
    consumed: u32,
    underrun_ticks: u32,
    /// None before the first point was a set point.
    start_tick: Option<u32>,
}

/// What a host is told of it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct PlayerStatus {
    /// The last order.
    pub order: StreamOrder,
    /// What it does.
    pub state: StreamState,
    /// Ticks from point to point.
    pub interval_ticks: u16,
    /// Places of the queue.
    pub free: u16,
    /// Number of the next point to be pushed.
    pub pushed: u32,
    /// Points that were taken out.
    pub consumed: u32,
    /// Ticks without a point to go to.
    pub underrun_ticks: u32,
    /// The tick that had the first point as its set point; 0 before that.
    pub start_tick: u32,
    /// Ticks that are left until the first point; 0 where none are.
    pub play_in_ticks: u16,
}

impl Player {
    /// An empty queue, a point a tick.
    pub const fn new() -> Self {
        Self {
            points: Deque::new(),
            state: StreamState::Idle,
            interval_ticks: 1,
            step: 0,
            from: 0.0,
            to: 0.0,
            slope: 0.0,
            is_ending: false,
            pushed: 0,
            consumed: 0,
            underrun_ticks: 0,
            start_tick: None,
        }
    }

    /// Forgets all points; the interval stays.
    pub fn clear(&mut self) {
        self.points.clear();
        self.state = StreamState::Idle;
        self.is_ending = false;
        (self.pushed, self.consumed, self.underrun_ticks, self.start_tick) = (0, 0, 0, None);
    }

    /// Number of the next point to be pushed.
    pub const fn pushed(&self) -> u32 {
        self.pushed
    }

    /// Whether the set points are the player's.
    pub fn is_playing(&self) -> bool {
        matches!(self.state, StreamState::Playing | StreamState::Underrun)
    }

    /// What a host is told.
    pub fn status(&self) -> PlayerStatus {
        let order = match (self.state, self.is_ending) {
            (StreamState::Idle, _) => StreamOrder::Clear,
            (_, false) => StreamOrder::Play,
            (_, true) => StreamOrder::End,
        };
        PlayerStatus {
            order,
            state: self.state,
            interval_ticks: self.interval_ticks,
            free: QUEUE_POINTS - self.points.len() as u16,
            pushed: self.pushed,
            consumed: self.consumed,
            underrun_ticks: self.underrun_ticks,
            start_tick: self.start_tick.unwrap_or(0),
            play_in_ticks: if self.waits() { self.left_ticks() } else { 0 },
        }
    }

    /// Whether it plays, and has not come to the first point.
    fn waits(&self) -> bool {
        self.is_playing() && self.start_tick.is_none()
    }

    /// To the next point; fits, as what [`Player::play_in`] takes.
    fn left_ticks(&self) -> u16 {
        (i32::from(self.interval_ticks) - self.step) as u16
    }

    /// The points to be played, next first.
    pub fn waiting(&self) -> impl Iterator<Item = f32> {
        self.points.iter().copied()
    }

    /// Takes points, of which the first has this number; those that it has already are passed over.
    ///
    /// # Errors
    /// Points between them and the last are missing; the queue has no room; it was said that no
    /// more points come. Nothing is taken then.
    pub fn push(&mut self, number: u32, points: &[f32]) -> Result<(), Exception> {
        let known = self.pushed.checked_sub(number).ok_or(Exception::IllegalValue)?;
        let new = points.get(known as usize..).unwrap_or_default();
        if new.len() > usize::from(QUEUE_POINTS) - self.points.len() || self.is_ending && !new.is_empty() {
            return Err(Exception::DeviceBusy);
        }
        for &point in new {
            // There is room.
            let _ = self.points.push_back(point);
            self.pushed = self.pushed.wrapping_add(1);
        }
        Ok(())
    }

    /// Carries an order out, if there is one, at an interval (tick) if it is to be another one.
    ///
    /// # Errors
    /// There is nothing to play, or to end, or it plays already. Nothing changes then.
    pub fn order(&mut self, order: Option<StreamOrder>, interval: Option<u16>) -> Result<(), Exception> {
        let is_possible = match order {
            Some(StreamOrder::Clear) => true,
            Some(StreamOrder::Play) => self.state == StreamState::Idle && !self.points.is_empty(),
            Some(StreamOrder::End) => self.is_playing() && interval.is_none(),
            None => !self.is_playing(),
        };
        if !is_possible {
            return Err(Exception::DeviceBusy);
        }
        self.interval_ticks = interval.unwrap_or(self.interval_ticks).max(1);
        match order {
            Some(StreamOrder::Clear) => self.clear(),
            // `from` is for the ticks until then, of which there are none.
            Some(StreamOrder::Play) => self.begin(1, self.from),
            Some(StreamOrder::End) => self.is_ending = true,
            None => {}
        }
        Ok(())
    }

    /// Plays, so that the first point is the set point in so many ticks; until then it stays
    /// `held`. One that waits for its first point already begins its count again.
    ///
    /// # Errors
    /// There is nothing to play, or it plays already. Nothing changes then.
    pub fn play_in(&mut self, ticks: u16, held: f32) -> Result<(), Exception> {
        let is_ready = self.state == StreamState::Idle && !self.points.is_empty();
        if !is_ready && !self.waits() {
            return Err(Exception::DeviceBusy);
        }
        self.begin(ticks, held);
        Ok(())
    }

    fn begin(&mut self, ticks: u16, held: f32) {
        if self.state == StreamState::Idle {
            self.to = self.take().unwrap_or(self.to);
        }
        self.step = i32::from(self.interval_ticks) - i32::from(ticks);
        (self.from, self.slope) = (held, 0.0);
        self.state = StreamState::Playing;
    }

    /// The set point of the tick with this number, which is the next; `None` if it is not the
    /// player's.
    #[inline(always)]
    pub fn next(&mut self, tick: u32) -> Option<f32> {
        if self.is_playing() { Some(self.advance(tick)) } else { None }
    }

    fn advance(&mut self, tick: u32) -> f32 {
        self.step = self.step.saturating_add(1);
        if self.step < i32::from(self.interval_ticks) {
            return self.from + self.slope * self.step as f32;
        }
        self.start_tick.get_or_insert(tick);
        self.from = self.to;
        if let Some(point) = self.take() {
            // One that comes after an underrun is gone to from this tick on.
            self.step = 0;
            self.to = point;
            self.slope = (point - self.from) / f32::from(self.interval_ticks);
            self.state = StreamState::Playing;
        } else if self.is_ending {
            self.state = StreamState::Done;
        } else {
            self.underrun_ticks =
                self.underrun_ticks.wrapping_add(u32::from(self.state == StreamState::Underrun));
            self.state = StreamState::Underrun;
        }
        self.from
    }

    fn take(&mut self) -> Option<f32> {
        let point = self.points.pop_front()?;
        self.consumed = self.consumed.wrapping_add(1);
        Some(point)
    }
}

impl Default for Player {
    fn default() -> Self {
        Self::new()
    }
}
