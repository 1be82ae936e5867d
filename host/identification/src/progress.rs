//! How far a long work is, and how long it will still take.
//!
//! Work is planned in units that take about equally long. Each part of it counts as planned,
//! however short or long it turns out to be, so that the share that is done never falls. The time
//! left is what the work so far has taken, times what is left of it over what is done.

use std::fmt;
use std::sync::{Mutex, PoisonError};
use std::time::Duration;

/// Whom a work tells the share of it that is done, 0 … 1.
pub type Tell<'a> = &'a (dyn Fn(f64) + Sync);

/// Tells the share of a whole, of which this is the part from one share to another.
pub fn within(tell: Tell<'_>, [from, to]: [f64; 2]) -> impl Fn(f64) + Sync {
    move |share| tell(from + share * (to - from))
}

/// A work whose parts are planned.
///
/// ```
/// use identification::progress::Work;
///
/// let told = std::sync::Mutex::new(0.0);
/// let tell = |share: f64| *told.lock().unwrap() = share;
/// Work::new(4.0, &tell).add(1.0);
/// assert_eq!(*told.lock().unwrap(), 0.25);
/// ```
pub struct Work<'a> {
    planned: f64,
    done: Mutex<f64>,
    tell: Tell<'a>,
}

impl<'a> Work<'a> {
    /// A work of so many units.
    pub fn new(planned: f64, tell: Tell<'a>) -> Self {
        Self { planned, done: Mutex::new(0.0), tell }
    }

    /// Says that so many units more are done.
    pub fn add(&self, units: f64) {
        let mut done = self.done.lock().unwrap_or_else(PoisonError::into_inner);
        *done += units;
        (self.tell)((*done / self.planned).clamp(0.0, 1.0));
    }

    /// Begins the next part of the work.
    pub fn begin(&self, part: Planned) -> Part<'_> {
        Part { work: self, step: part.step, left: Mutex::new(part.steps) }
    }
}

/// A part of a work before it is begun.
#[derive(Clone, Copy, Debug, Default)]
pub struct Planned {
    /// Units of a step.
    pub step: f64,
    /// Steps that are expected.
    pub steps: usize,
}

impl Planned {
    /// All of it.
    pub fn units(&self) -> f64 {
        self.step * self.steps as f64
    }
}

/// A part of a work that is begun; all of it counts as done when it is dropped.
pub struct Part<'a> {
    work: &'a Work<'a>,
    /// Units.
    step: f64,
    /// Steps that are planned and not done.
    left: Mutex<usize>,
}

impl Part<'_> {
    /// Says that a step is done; more than planned count for nothing.
    pub fn step(&self) {
        let mut left = self.left.lock().unwrap_or_else(PoisonError::into_inner);
        if *left > 0 {
            *left -= 1;
            self.work.add(self.step);
        }
    }
}

impl Drop for Part<'_> {
    fn drop(&mut self) {
        let left = *self.left.lock().unwrap_or_else(PoisonError::into_inner);
        self.work.add(self.step * left as f64);
    }
}

/// How long a work will still take; None before there is anything to tell it from.
///
/// ```
/// use identification::progress::left;
/// use std::time::Duration;
///
/// let left = left(0.5, Duration::from_secs(30)).expect("half is enough to tell");
/// assert_eq!(left.0, Duration::from_secs(30));
/// ```
pub fn left(share: f64, elapsed: Duration) -> Option<Left> {
    /// The least share and time to judge by.
    const LEAST: (f64, Duration) = (0.02, Duration::from_millis(500));
    let known = share >= LEAST.0 && elapsed >= LEAST.1;
    known.then(|| Left(elapsed.mul_f64((1.0 - share) / share)))
}

/// A time that is left, told as exactly as it is known.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Left(pub Duration);

impl fmt::Display for Left {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self.0.as_secs_f64().round() as u64 {
            0 => write!(f, "less than 1 s left"),
            seconds @ 1..120 => write!(f, "{seconds} s left"),
            seconds @ 120..7200 => write!(f, "{} min left", (seconds + 30) / 60),
            seconds => write!(f, "{} h left", (seconds + 1800) / 3600),
        }
    }
}

#[cfg(test)]
mod tests {
    use std::sync::Mutex;

    use super::*;

    /// Does a work of searches by a clock that takes `unit_s` for a unit and finds that searches
    /// take `longer` times their plan; how many times too much or too little was told as left after
    /// a tenth of the time.
    fn error_after_a_tenth(parts: &[(f64, usize)], unit_s: f64, longer: f64) -> f64 {
        let told: Mutex<Vec<(f64, f64)>> = Mutex::new(Vec::new());
        let clock = Mutex::new(0.0);
        let tell = |share: f64| told.lock().expect("alone").push((*clock.lock().expect("alone"), share));
        let planned = parts.iter().map(|&(units, steps)| Planned { step: units / steps as f64, steps });
        let work = Work::new(planned.clone().map(|part| part.units()).sum(), &tell);
        for planned in planned {
            let part = work.begin(planned);
            for _ in 0..(planned.steps as f64 * longer) as usize {
                *clock.lock().expect("alone") += unit_s * planned.step;
                part.step();
            }
        }
        let told = told.lock().expect("alone");
        let end_s = *clock.lock().expect("alone");
        let &(now_s, share) = told.iter().find(|(now_s, _)| *now_s >= 0.1 * end_s).expect("told");
        let Left(left) = left(share, Duration::from_secs_f64(now_s)).expect("known by then");
        (left.as_secs_f64() / (end_s - now_s)).max((end_s - now_s) / left.as_secs_f64())
    }

    #[test]
    fn after_a_tenth_of_the_work_the_time_left_is_right_within_a_factor_of_two() {
        // Many short searches, then a few that each take as long as hundreds of them; the other way
        // round; equal ones.
        let screened = [(100.0, 480), (80.0, 100), (5000.0, 60)];
        let turned = [(5000.0, 60), (80.0, 100), (100.0, 480)];
        for parts in [screened, turned, [(10.0, 10); 3]] {
            let units: f64 = parts.iter().map(|(units, _)| units).sum();
            for planned_s in [12.0, 3600.0] {
                for longer in [0.6, 1.0, 1.6] {
                    let error = error_after_a_tenth(&parts, planned_s / units, longer);
                    assert!(error < 2.0, "{parts:?}, searches of {longer} times their plan: {error}");
                }
            }
        }
    }

    #[test]
    fn a_part_counts_as_planned_and_the_share_never_falls() {
        let told = Mutex::new(Vec::new());
        let tell = |share: f64| told.lock().expect("alone").push(share);
        let work = Work::new(10.0, &tell);
        for steps in [1, 12] {
            let part = work.begin(Planned { step: 1.25, steps: 4 });
            (0..steps).for_each(|_| part.step());
        }
        let told = told.lock().expect("alone");
        assert!(told.is_sorted() && told.contains(&0.5) && told.last() == Some(&1.0), "{told:?}");
    }

    #[test]
    fn what_is_left_is_told_in_plain_numbers() {
        let words = |seconds: f64| Left(Duration::from_secs_f64(seconds)).to_string();
        assert_eq!(words(0.2), "less than 1 s left");
        assert_eq!(words(12.345), "12 s left");
        assert_eq!(words(149.0), "2 min left");
        assert_eq!(words(1e4), "3 h left");
        assert_eq!(left(0.01, Duration::from_secs(9)), None);
    }
}
