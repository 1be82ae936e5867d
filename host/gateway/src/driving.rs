//! Who drives a board, and by which set point next.
//!
//! # Contract
//! A board is driven for one client at a time, who has a grant for it: a number that was drawn when
//! the board was started for it, and that each of its set points carries. A set point is taken in
//! the order of its sequence and while it is fresh; the newest takes the place of one that has not
//! been sent yet, so that nothing is ever sent late. Each set point that goes to the board is the
//! sign of life that the board waits for: where the client falls silent, the gateway dies or the
//! line is cut, no more of them come, and the board vents within its own patience
//! (`bus_silent_ticks`).

use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::time::{Duration, Instant};

use rand::RngExt;
use thiserror::Error;
use wire::registers::{Access, Id, Value};

/// How old a set point may be when it goes to the board, and how far ahead the clock of the client
/// may be: ten cycles at 50 Hz, and less than the 0.5 s for which a board usually bears silence. Unit: s.
pub const FRESH_S: f64 = 0.2;

/// Why a board is not started, or a set point not taken.
#[derive(Clone, Debug, Error, PartialEq)]
#[allow(missing_docs, reason = "the messages say what the variants and their fields are")]
pub enum Refused {
    #[error("there is no such board")]
    NoBoard,
    #[error("the board is not driven: start it first")]
    NotDriven,
    #[error("the board is driven for another client: it has to stop it, or fall silent, first")]
    Driven,
    #[error(
        "the grant {grant} is not that for which the board is driven: it was stopped or started meanwhile"
    )]
    OtherGrant { grant: u32 },
    #[error("sequence {sequence} comes behind {last}: set points are taken in order")]
    Sequence { sequence: u64, last: u64 },
    #[error("the set point is {age_s:.3} s old, {FRESH_S} s are allowed")]
    Old { age_s: f64 },
    #[error(
        "the set point is from the future, by {ahead_s:.3} s, {FRESH_S} s are allowed: compare the clocks"
    )]
    Ahead { ahead_s: f64 },
    #[error("{mm} mm is not in {min} to {max} mm")]
    Limits { mm: f64, min: f64, max: f64 },
    #[error("{0}")]
    Board(String),
    #[error("the line did not carry it out in time")]
    Late,
}

/// A set point, as a client sends it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SetPoint {
    /// For whom the board was started.
    pub grant: u32,
    /// Larger than that of the one before.
    pub sequence: u64,
    /// The reference. Unit: mm.
    pub mm: f64,
    /// Since it was made; negative if the client's clock is ahead. Unit: s.
    pub age_s: f64,
}

/// One that waits for its board's turn.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Waiting {
    mm: f64,
    /// When it is no longer fresh.
    until: Instant,
}

#[derive(Clone, Copy, Debug)]
struct Driver {
    grant: u32,
    /// The board has been started for it.
    is_started: bool,
    last: Option<u64>,
    waiting: Option<Waiting>,
}

/// The drivers of all boards, shared by the lines' threads and by those who take set points.
#[derive(Clone, Debug)]
pub struct Driving(Arc<Mutex<Vec<Option<Driver>>>>);

impl Driving {
    /// Of so many boards, none of which is driven.
    pub fn of(boards: usize) -> Self {
        Self(Arc::new(Mutex::new(vec![None; boards])))
    }

    /// Grants a board to a client.
    ///
    /// # Errors
    /// There is no such board, or another client has it.
    pub fn grant(&self, index: usize) -> Result<u32, Refused> {
        let mut drivers = self.lock();
        let place = drivers.get_mut(index).ok_or(Refused::NoBoard)?;
        if place.is_some() {
            return Err(Refused::Driven);
        }
        let grant = rand::rng().random();
        *place = Some(Driver { grant, is_started: false, last: None, waiting: None });
        Ok(grant)
    }

    /// The board has been started for whom it was granted to.
    pub fn started(&self, index: usize) {
        if let Some(Some(driver)) = self.lock().get_mut(index) {
            driver.is_started = true;
        }
    }

    /// The board is vented: a grant for which it had been started ends.
    pub fn vented(&self, index: usize) {
        if let Some(place) = self.lock().get_mut(index)
            && place.is_some_and(|driver| driver.is_started)
        {
            *place = None;
        }
    }

    /// Ends the grant of a board: whoever sends it set points from now on is told so.
    pub fn end(&self, index: usize) {
        if let Some(place) = self.lock().get_mut(index) {
            *place = None;
        }
    }

    /// Ends all grants.
    pub fn end_all(&self) {
        self.lock().fill(None);
    }

    /// Takes a set point for a board.
    ///
    /// # Errors
    /// Why not; then the ones before still hold.
    pub fn set(&self, index: usize, point: SetPoint) -> Result<(), Refused> {
        let mut drivers = self.lock();
        let place = drivers.get_mut(index).ok_or(Refused::NoBoard)?;
        let driver = place.as_mut().ok_or(Refused::NotDriven)?;
        if driver.grant != point.grant {
            return Err(Refused::OtherGrant { grant: point.grant });
        }
        if let Some(last) = driver.last.filter(|last| point.sequence <= *last) {
            return Err(Refused::Sequence { sequence: point.sequence, last });
        }
        // A sequence is used up by a set point that is refused, too: what comes behind it is newer.
        driver.last = Some(point.sequence);
        if point.age_s > FRESH_S {
            return Err(Refused::Old { age_s: point.age_s });
        }
        if point.age_s < -FRESH_S || point.age_s.is_nan() {
            return Err(Refused::Ahead { ahead_s: -point.age_s });
        }
        if let Access::Write(min, max) = Id::SetpointMm.register().access
            && !Id::SetpointMm.register().takes(Value::F32(point.mm as f32))
        {
            return Err(Refused::Limits { mm: point.mm, min, max });
        }
        let left = Duration::from_secs_f64((FRESH_S - point.age_s).min(FRESH_S));
        driver.waiting = Some(Waiting { mm: point.mm, until: Instant::now() + left });
        Ok(())
    }

    /// The set point that is sent to a board next, if there is one that is fresh. Unit: mm.
    pub fn take(&self, index: usize) -> Option<f64> {
        let waiting = self.lock().get_mut(index)?.as_mut()?.waiting.take()?;
        (Instant::now() <= waiting.until).then_some(waiting.mm)
    }

    fn lock(&self) -> MutexGuard<'_, Vec<Option<Driver>>> {
        // What a thread that panicked left is whole: each change is one assignment.
        self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn point(grant: u32, sequence: u64) -> SetPoint {
        SetPoint { grant, sequence, mm: 10.0, age_s: 0.0 }
    }

    #[test]
    fn the_newest_set_point_is_sent_once() {
        let driving = Driving::of(1);
        let grant = driving.grant(0).expect("free");
        driving.set(0, point(grant, 1)).expect("taken");
        driving.set(0, SetPoint { mm: 20.0, ..point(grant, 2) }).expect("taken");
        assert_eq!((driving.take(0), driving.take(0)), (Some(20.0), None));
    }

    #[test]
    fn what_is_old_is_refused_and_what_gets_old_while_it_waits_is_not_sent() {
        let driving = Driving::of(1);
        let grant = driving.grant(0).expect("free");
        let old = SetPoint { age_s: 0.3, ..point(grant, 1) };
        assert_eq!(driving.set(0, old), Err(Refused::Old { age_s: 0.3 }));
        let ahead = SetPoint { age_s: -0.3, ..point(grant, 2) };
        assert_eq!(driving.set(0, ahead), Err(Refused::Ahead { ahead_s: 0.3 }));
        let undated = SetPoint { age_s: f64::NAN, ..point(grant, 3) };
        assert!(matches!(driving.set(0, undated), Err(Refused::Ahead { .. })));
        driving.set(0, SetPoint { age_s: FRESH_S - 0.01, ..point(grant, 4) }).expect("taken");
        std::thread::sleep(Duration::from_millis(20));
        assert_eq!(driving.take(0), None);
    }

    #[test]
    fn set_points_are_taken_in_order_within_limits_and_by_the_one_grant() {
        let driving = Driving::of(2);
        assert_eq!(driving.set(0, point(1, 1)), Err(Refused::NotDriven));
        let grant = driving.grant(0).expect("free");
        assert_eq!(driving.grant(0), Err(Refused::Driven));
        assert_eq!(driving.grant(2), Err(Refused::NoBoard));
        driving.set(0, point(grant, 7)).expect("taken");
        assert_eq!(driving.set(0, point(grant, 7)), Err(Refused::Sequence { sequence: 7, last: 7 }));
        let other = grant.wrapping_add(1);
        assert_eq!(driving.set(0, point(other, 8)), Err(Refused::OtherGrant { grant: other }));
        for mm in [201.0, f64::NAN, f64::INFINITY] {
            let refused = driving.set(0, SetPoint { mm, ..point(grant, mm.to_bits()) });
            assert!(matches!(refused, Err(Refused::Limits { .. } | Refused::Sequence { .. })), "{refused:?}");
        }
        // Before it has started it is vented, of course.
        driving.vented(0);
        assert_eq!(driving.grant(0), Err(Refused::Driven));
        driving.started(0);
        driving.vented(0);
        assert_eq!(driving.set(0, point(grant, 9)), Err(Refused::NotDriven));
        assert_ne!(driving.grant(0).expect("free again"), grant);
        driving.end_all();
        driving.grant(0).expect("free again");
    }
}
