//! A course of set points over time, as a client orders it, and the points at equal intervals that
//! are made of it for a board.
//!
//! # Method
//! Straight lines between the points that were ordered, from what the board was asked for before;
//! behind the last one it stays. Corners are as sharp as the interval of the board's stream.

use thiserror::Error;

use crate::lines::Limits;

/// The most points of a trajectory: some MB of JSON.
pub const MOST_POINTS: usize = 100_000;
/// The longest: what is longer is ordered in parts. Unit: s.
pub const LONGEST_S: f64 = 3_600.0;

/// What is wrong with a trajectory.
#[derive(Clone, Debug, Error, PartialEq)]
#[allow(missing_docs, reason = "the messages say what the variants and their fields are")]
pub enum Wrong {
    #[error("the trajectory has no points")]
    Empty,
    #[error("the trajectory has {points} points, {MOST_POINTS} are allowed")]
    Many { points: usize },
    #[error("point {number} of the trajectory: {time_s} s is no time behind {before_s} s")]
    Time { number: usize, time_s: f64, before_s: f64 },
    #[error("the trajectory takes {time_s} s, {LONGEST_S} s are allowed")]
    Long { time_s: f64 },
    #[error("point {number} of the trajectory: {mm} mm is not in {min} to {max} mm")]
    Travel { number: usize, mm: f64, min: f64, max: f64 },
    #[error("point {number} of the trajectory: {mm_per_s:.1} mm/s to it, {limit} mm/s are allowed")]
    Slew { number: usize, mm_per_s: f64, limit: f64 },
}

/// A trajectory whose points are possible: times (s, from its start on), each later than the one
/// before, and set points (mm).
#[derive(Clone, Debug, PartialEq)]
pub struct Trajectory(Vec<(f64, f64)>);

impl Trajectory {
    /// Of points (s, mm), for a board with these limits that was asked for `before_mm` last.
    ///
    /// # Errors
    /// What is wrong with them.
    pub fn of(points: Vec<(f64, f64)>, limits: &Limits, before_mm: f64) -> Result<Self, Wrong> {
        if points.len() > MOST_POINTS {
            return Err(Wrong::Many { points: points.len() });
        }
        let last = points.last().ok_or(Wrong::Empty)?;
        let mut before = None;
        for (place, &(time_s, mm)) in points.iter().enumerate() {
            let number = place + 1;
            let before_s = before.map_or(0.0, |(time_s, _)| time_s);
            let is_behind = time_s > before_s || before.is_none() && time_s == 0.0;
            if !is_behind || !time_s.is_finite() {
                return Err(Wrong::Time { number, time_s, before_s });
            }
            let [min, max] = limits.travel_mm;
            if !(min..=max).contains(&mm) {
                return Err(Wrong::Travel { number, mm, min, max });
            }
            // A first point at the start itself is a step.
            let (from_s, from_mm) = before.unwrap_or((0.0, before_mm));
            let mm_per_s = (mm - from_mm).abs() / (time_s - from_s);
            if let Some(limit) = limits.slew_mm_per_s.filter(|limit| mm_per_s > *limit) {
                return Err(Wrong::Slew { number, mm_per_s, limit });
            }
            before = Some((time_s, mm));
        }
        if last.0 > LONGEST_S {
            return Err(Wrong::Long { time_s: last.0 });
        }
        Ok(Self(points))
    }

    /// How long it takes. Unit: s.
    pub fn duration_s(&self) -> f64 {
        self.0.last().map_or(0.0, |(time_s, _)| *time_s)
    }

    /// The set point so long behind the start, for a board that was asked for `before_mm` until
    /// then. Unit: mm.
    pub fn at(&self, time_s: f64, before_mm: f64) -> f64 {
        let behind = self.0.partition_point(|(point_s, _)| *point_s <= time_s);
        let (from_s, from_mm) = match behind.checked_sub(1) {
            Some(before) => self.0[before],
            None => (0.0, before_mm),
        };
        match self.0.get(behind) {
            Some((to_s, to_mm)) if time_s > from_s => {
                from_mm + (time_s - from_s) / (to_s - from_s) * (to_mm - from_mm)
            }
            _ => from_mm,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const LIMITS: Limits = Limits { travel_mm: [0.0, 60.0], slew_mm_per_s: Some(100.0) };

    fn of(points: &[(f64, f64)]) -> Result<Trajectory, Wrong> {
        Trajectory::of(points.to_vec(), &LIMITS, 10.0)
    }

    #[test]
    fn it_is_the_straight_lines_from_what_was_asked_for_before() {
        let trajectory = of(&[(1.0, 30.0), (3.0, 20.0)]).expect("possible");
        for (time_s, mm) in
            [(-1.0, 10.0), (0.0, 10.0), (0.5, 20.0), (1.0, 30.0), (2.0, 25.0), (3.0, 20.0), (9.0, 20.0)]
        {
            assert_eq!(trajectory.at(time_s, 10.0), mm, "{time_s} s");
        }
        let step = Trajectory::of(vec![(0.0, 5.0)], &Limits::usual(), 10.0).expect("a step");
        assert_eq!((step.at(-0.1, 10.0), step.at(0.0, 10.0), step.duration_s()), (10.0, 5.0, 0.0));
    }

    #[test]
    fn what_is_beyond_limits_or_no_course_is_refused_by_point_value_and_limit() {
        for (points, said) in [
            (&[][..], "the trajectory has no points"),
            (&[(1.0, 61.0)], "point 1 of the trajectory: 61 mm is not in 0 to 60 mm"),
            (&[(1.0, 20.0), (2.0, -1.0)], "point 2 of the trajectory: -1 mm is not in 0 to 60 mm"),
            (&[(1.0, f64::NAN)], "point 1 of the trajectory: NaN mm is not in 0 to 60 mm"),
            (&[(1.0, 20.0), (1.0, 21.0)], "point 2 of the trajectory: 1 s is no time behind 1 s"),
            (&[(-1.0, 20.0)], "point 1 of the trajectory: -1 s is no time behind 0 s"),
            (&[(f64::NAN, 20.0)], "point 1 of the trajectory: NaN s is no time behind 0 s"),
            (&[(f64::INFINITY, 20.0)], "point 1 of the trajectory: inf s is no time behind 0 s"),
            (&[(4e3, 20.0)], "the trajectory takes 4000 s, 3600 s are allowed"),
            (&[(0.1, 30.0)], "point 1 of the trajectory: 200.0 mm/s to it, 100 mm/s are allowed"),
            (&[(0.0, 11.0)], "point 1 of the trajectory: inf mm/s to it, 100 mm/s are allowed"),
            (
                &[(1.0, 20.0), (1.1, 35.0)],
                "point 2 of the trajectory: 150.0 mm/s to it, 100 mm/s are allowed",
            ),
        ] {
            assert_eq!(of(points).expect_err(said).to_string(), said);
        }
        let many = vec![(1.0, 10.0); MOST_POINTS + 1];
        assert_eq!(of(&many), Err(Wrong::Many { points: MOST_POINTS + 1 }));
    }
}
