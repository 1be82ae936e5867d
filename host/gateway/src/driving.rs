//! Who drives a board, and by which set point next.
//!
//! # Trajectories
//! While a trajectory waits for its start or plays, the set points are the board's own. Its client
//! goes on to say that it lives, by words without a set point, in the same sequence.
//!
//! # Contract
//! A board is driven for one client at a time, who has a grant for it: a number that was drawn when
//! the board was started for it, and that each of its set points carries. A set point is taken in
//! the order of its sequence and while it is fresh; the newest takes the place of one that has not
//! been sent yet, so that nothing is ever sent late. Each set point that goes to the board is the
//! sign of life that the board waits for: where the client falls silent, the gateway dies or the
//! line is cut, no more of them come, and the board vents within its own patience
//! (`bus_silent_ticks`).
//!
//! One exception: several boards are started one behind the other, and their client does not know
//! its grant before the last one has been. Until then, as long as an order may take at most, the
//! gateway says for it that it lives ([`Driving::vouch`]).

use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::time::{Duration, Instant};

use rand::RngExt;
use thiserror::Error;

use crate::lines::Limits;
use crate::trajectory::Wrong;

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
    #[error(
        "a trajectory waits or plays: its client says that it lives, without set points, until it is done"
    )]
    Plays,
    #[error("the board tracks nothing so far")]
    NotTracking,
    #[error("the start was {by_s:.3} s ago")]
    Past { by_s: f64 },
    #[error("the start is in {in_s:.3} s: until all boards have their points {lead_s} s may pass")]
    Soon { in_s: f64, lead_s: f64 },
    #[error("the start is in {in_s:.3} s, {most_s} s are allowed: compare the clocks")]
    Far { in_s: f64, most_s: f64 },
    #[error("the board is there twice")]
    Twice,
    #[error("a trajectory on the board's line waits for its start")]
    LineWaits,
    #[error("{0}")]
    Trajectory(#[from] Wrong),
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
    /// The reference; none: a sign of life alone. Unit: mm.
    pub mm: Option<f64>,
    /// Since it was made; negative if the client's clock is ahead. Unit: s.
    pub age_s: f64,
}

/// One that waits for its board's turn.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Waiting {
    mm: Option<f64>,
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
    /// A trajectory waits or plays.
    plays: bool,
    /// Until when the gateway says for the client that it lives.
    vouched: Option<Instant>,
}

/// A board's limits, and who drives it.
#[derive(Clone, Copy, Debug)]
struct Place {
    limits: Limits,
    driver: Option<Driver>,
}

/// What a client says last, while that is fresh.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Said {
    /// It lives.
    Lives,
    /// It lives, and this is the set point. Unit: mm.
    SetPoint(f64),
}

/// The drivers of all boards, shared by the lines' threads and by those who take set points.
#[derive(Clone, Debug, Default)]
pub struct Driving(Arc<Mutex<Vec<Place>>>);

impl Driver {
    fn is_of(&self, grant: u32) -> Result<(), Refused> {
        if self.grant == grant { Ok(()) } else { Err(Refused::OtherGrant { grant }) }
    }
}

impl Driving {
    /// The boards have these limits, each at its place; who is driven stays so.
    pub fn limit(&self, limits: impl IntoIterator<Item = Limits>) {
        let mut places = self.lock();
        for (index, limits) in limits.into_iter().enumerate() {
            match places.get_mut(index) {
                Some(place) => place.limits = limits,
                None => places.push(Place { limits, driver: None }),
            }
        }
    }

    /// Grants a board to a client.
    ///
    /// # Errors
    /// There is no such board, or another client has it.
    pub fn grant(&self, index: usize) -> Result<u32, Refused> {
        self.grant_all(&[index])
    }

    /// Grants several boards to a client, by one grant.
    ///
    /// # Errors
    /// There is no such board, or another client has one of them: then none is granted.
    pub fn grant_all(&self, indices: &[usize]) -> Result<u32, Refused> {
        let mut places = self.lock();
        for &index in indices {
            if places.get(index).ok_or(Refused::NoBoard)?.driver.is_some() {
                return Err(Refused::Driven);
            }
        }
        let grant = rand::rng().random();
        let driver =
            Driver { grant, is_started: false, last: None, waiting: None, plays: false, vouched: None };
        for &index in indices {
            if let Some(place) = places.get_mut(index) {
                place.driver = Some(driver);
            }
        }
        Ok(grant)
    }

    /// Says for the client of these boards that it lives, once they are started, until then; none:
    /// from now on it has to say so itself.
    pub fn vouch(&self, indices: &[usize], until: Option<Instant>) {
        indices.iter().for_each(|index| self.change(*index, |driver| driver.vouched = until));
    }

    /// Whether a board is granted by this grant.
    pub fn holds(&self, index: usize, grant: u32) -> bool {
        let places = self.lock();
        let driver = places.get(index).and_then(|place| place.driver.as_ref());
        driver.is_some_and(|driver| driver.is_of(grant).is_ok())
    }

    /// The board has been started for whom it was granted to.
    pub fn started(&self, index: usize) {
        self.change(index, |driver| driver.is_started = true);
    }

    /// The board is vented: a grant for which it had been started ends.
    pub fn vented(&self, index: usize) {
        if let Some(place) = self.lock().get_mut(index) {
            place.driver = place.driver.filter(|driver| !driver.is_started);
        }
    }

    /// Ends the grant of a board: whoever sends it set points from now on is told so.
    pub fn end(&self, index: usize) {
        if let Some(place) = self.lock().get_mut(index) {
            place.driver = None;
        }
    }

    /// Ends all grants.
    pub fn end_all(&self) {
        self.lock().iter_mut().for_each(|place| place.driver = None);
    }

    /// Whether a client has this board.
    pub fn is_driven(&self, index: usize) -> bool {
        self.lock().get(index).is_some_and(|place| place.driver.is_some())
    }

    /// The limits of a board that this grant may give a trajectory to now.
    ///
    /// # Errors
    /// Why it may not.
    pub fn may_play(&self, index: usize, grant: u32) -> Result<Limits, Refused> {
        let places = self.lock();
        let place = places.get(index).ok_or(Refused::NoBoard)?;
        let driver = place.driver.as_ref().ok_or(Refused::NotDriven)?;
        driver.is_of(grant)?;
        if driver.plays { Err(Refused::Plays) } else { Ok(place.limits) }
    }

    /// A trajectory waits or plays on a board; or no longer. What waits to be sent is not sent.
    pub fn plays(&self, index: usize, plays: bool) {
        self.change(index, |driver| (driver.plays, driver.waiting) = (plays, None));
    }

    fn change(&self, index: usize, change: impl FnOnce(&mut Driver)) {
        if let Some(driver) = self.lock().get_mut(index).and_then(|place| place.driver.as_mut()) {
            change(driver);
        }
    }

    /// Takes a set point for a board.
    ///
    /// # Errors
    /// Why not; then the ones before still hold.
    pub fn set(&self, index: usize, point: SetPoint) -> Result<(), Refused> {
        let mut places = self.lock();
        let place = places.get_mut(index).ok_or(Refused::NoBoard)?;
        let [min, max] = place.limits.travel_mm;
        let driver = place.driver.as_mut().ok_or(Refused::NotDriven)?;
        driver.is_of(point.grant)?;
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
        if let Some(mm) = point.mm.filter(|mm| !(min..=max).contains(mm)) {
            return Err(Refused::Limits { mm, min, max });
        }
        if driver.plays && point.mm.is_some() {
            return Err(Refused::Plays);
        }
        let left = Duration::from_secs_f64((FRESH_S - point.age_s).min(FRESH_S));
        driver.waiting = Some(Waiting { mm: point.mm, until: Instant::now() + left });
        Ok(())
    }

    /// What a board's client has said last, once, if that is fresh.
    pub fn take(&self, index: usize) -> Option<Said> {
        self.take_fresh(index).map(|(said, _)| said)
    }

    /// The same, and how long it is still fresh.
    pub fn take_fresh(&self, index: usize) -> Option<(Said, Duration)> {
        let mut places = self.lock();
        let driver = places.get_mut(index)?.driver.as_mut()?;
        let now = Instant::now();
        let fresh = |until: Instant| until.checked_duration_since(now);
        if let Some(waiting) = driver.waiting.take()
            && let Some(left) = fresh(waiting.until)
        {
            return Some((waiting.mm.map_or(Said::Lives, Said::SetPoint), left));
        }
        let left = driver.vouched.filter(|_| driver.is_started).and_then(fresh)?;
        Some((Said::Lives, left.min(Duration::from_secs_f64(FRESH_S))))
    }

    /// What the clients of all of these boards have said alike, if each has, and it is fresh; then it
    /// is taken for each.
    pub fn take_common(&self, indices: &[usize]) -> Option<Said> {
        let mut places = self.lock();
        let waiting = |index: &usize| places.get(*index)?.driver.as_ref()?.waiting;
        let first = waiting(indices.first()?)?;
        let now = Instant::now();
        let is_common =
            |index: &usize| waiting(index).is_some_and(|other| other.mm == first.mm && now <= other.until);
        if !indices.iter().all(is_common) {
            return None;
        }
        for &index in indices {
            if let Some(driver) = places.get_mut(index).and_then(|place| place.driver.as_mut()) {
                driver.waiting = None;
            }
        }
        Some(first.mm.map_or(Said::Lives, Said::SetPoint))
    }

    fn lock(&self) -> MutexGuard<'_, Vec<Place>> {
        // What a thread that panicked left is whole: each change is one assignment.
        self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn point(grant: u32, sequence: u64) -> SetPoint {
        SetPoint { grant, sequence, mm: Some(10.0), age_s: 0.0 }
    }

    fn driving(boards: usize) -> Driving {
        let driving = Driving::default();
        driving.limit(vec![Limits::usual(); boards]);
        driving
    }

    #[test]
    fn the_newest_set_point_is_sent_once() {
        let driving = driving(1);
        let grant = driving.grant(0).expect("free");
        driving.set(0, point(grant, 1)).expect("taken");
        driving.set(0, SetPoint { mm: Some(20.0), ..point(grant, 2) }).expect("taken");
        assert_eq!((driving.take(0), driving.take(0)), (Some(Said::SetPoint(20.0)), None));
    }

    #[test]
    fn while_a_trajectory_plays_its_client_says_that_it_lives_and_gives_no_set_points() {
        let driving = driving(2);
        let grant = driving.grant_all(&[0, 1]).expect("free");
        driving.set(0, point(grant, 1)).expect("taken");
        assert_eq!(
            driving.may_play(0, grant.wrapping_add(1)),
            Err(Refused::OtherGrant { grant: grant.wrapping_add(1) })
        );
        assert_eq!(driving.may_play(2, grant), Err(Refused::NoBoard));
        driving.may_play(0, grant).expect("its own");
        driving.plays(0, true);
        assert_eq!(driving.take(0), None, "the trajectory begins where the muscle is asked to be");
        assert_eq!(driving.may_play(0, grant), Err(Refused::Plays));
        assert_eq!(driving.set(0, point(grant, 2)), Err(Refused::Plays));
        driving.set(0, SetPoint { mm: None, ..point(grant, 3) }).expect("a sign of life");
        assert_eq!(driving.take(0), Some(Said::Lives));
        driving.set(1, point(grant, 2)).expect("the other board plays nothing");
        driving.plays(0, false);
        driving.set(0, point(grant, 4)).expect("it is done");
    }

    #[test]
    fn what_all_are_told_alike_is_taken_at_once_and_what_differs_is_not() {
        let driving = driving(3);
        let grant = driving.grant_all(&[0, 1, 2]).expect("free");
        for index in 0..2 {
            driving.set(index, point(grant, 1)).expect("taken");
        }
        assert_eq!(driving.take_common(&[0, 1, 2]), None, "one has said nothing");
        assert_eq!(driving.take_common(&[0, 1]), Some(Said::SetPoint(10.0)));
        assert_eq!((driving.take(0), driving.take(1)), (None, None), "it has been taken");
        driving.set(0, point(grant, 2)).expect("taken");
        driving.set(1, SetPoint { mm: Some(11.0), ..point(grant, 2) }).expect("taken");
        assert_eq!(driving.take_common(&[0, 1]), None);
        assert_eq!(driving.take(1), Some(Said::SetPoint(11.0)));
    }

    #[test]
    fn several_boards_are_granted_by_one_grant_or_none_of_them() {
        let driving = driving(3);
        driving.grant(1).expect("free");
        assert_eq!(driving.grant_all(&[0, 1, 2]), Err(Refused::Driven));
        assert_eq!(driving.grant_all(&[0, 3]), Err(Refused::NoBoard));
        let grant = driving.grant_all(&[0, 2]).expect("both are free");
        driving.set(0, point(grant, 1)).expect("taken");
        driving.set(2, point(grant, 1)).expect("taken");
    }

    #[test]
    fn who_waits_for_the_start_of_others_is_said_to_live_and_no_longer() {
        let driving = driving(2);
        let grant = driving.grant_all(&[0, 1]).expect("free");
        driving.vouch(&[0, 1], Some(Instant::now() + Duration::from_secs(1)));
        assert_eq!(driving.take(0), None, "it is not started");
        driving.started(0);
        assert_eq!((driving.take(0), driving.take(0)), (Some(Said::Lives), Some(Said::Lives)));
        driving.set(0, point(grant, 1)).expect("taken");
        assert_eq!(driving.take(0), Some(Said::SetPoint(10.0)), "the client's own word goes first");
        driving.vouch(&[0, 1], None);
        assert_eq!(driving.take(0), None, "the client knows its grant");
        driving.vouch(&[0], Some(Instant::now() + Duration::from_millis(10)));
        std::thread::sleep(Duration::from_millis(20));
        assert_eq!(driving.take(0), None, "an order takes no longer");
        assert!(driving.holds(0, grant) && !driving.holds(0, grant.wrapping_add(1)));
        driving.end(0);
        assert!(!driving.holds(0, grant));
    }

    #[test]
    fn what_is_old_is_refused_and_what_gets_old_while_it_waits_is_not_sent() {
        let driving = driving(1);
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
        let driving = driving(2);
        assert_eq!(driving.set(0, point(1, 1)), Err(Refused::NotDriven));
        let grant = driving.grant(0).expect("free");
        assert_eq!(driving.grant(0), Err(Refused::Driven));
        assert_eq!(driving.grant(2), Err(Refused::NoBoard));
        driving.set(0, point(grant, 7)).expect("taken");
        assert_eq!(driving.set(0, point(grant, 7)), Err(Refused::Sequence { sequence: 7, last: 7 }));
        let other = grant.wrapping_add(1);
        assert_eq!(driving.set(0, point(other, 8)), Err(Refused::OtherGrant { grant: other }));
        for mm in [201.0, f64::NAN, f64::INFINITY] {
            let refused = driving.set(0, SetPoint { mm: Some(mm), ..point(grant, mm.to_bits()) });
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
