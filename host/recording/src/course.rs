//! A command over time, drawn piece by piece within its limits.
//!
//! Levels are shares of the range, from 0 (lowest command) to 1 (highest). No piece is faster than
//! the slew limit: it then takes longer.

/// What a command must keep to.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Limits {
    /// Lowest command. Unit: bar.
    pub min_bar: f64,
    /// Highest command. Unit: bar.
    pub max_bar: f64,
    /// Fastest change, none for jumps. Unit: bar/s.
    pub slew_bar_per_s: Option<f64>,
}

/// A command over time: straight lines between waypoints. It begins and stays at the lowest command
/// until it is drawn.
///
/// ```
/// use recording::course::{Course, Limits};
///
/// let mut course = Course::new(Limits { min_bar: 0.0, max_bar: 6.0, slew_bar_per_s: Some(2.0) });
/// course.ramp(1.0, 0.5); // from 0 to 6 bar in 0.5 s is faster than the limit allows
/// assert_eq!(course.duration_s(), 3.0);
/// assert_eq!(course.samples([0.0, 1.5, 3.0].into_iter()).collect::<Vec<_>>(), [0.0, 3.0, 6.0]);
/// ```
#[derive(Clone, Debug)]
pub struct Course {
    limits: Limits,
    /// Time (s) and command (bar); of two at one time, the later holds from then on.
    waypoints: Vec<(f64, f64)>,
}

impl Course {
    /// A course that begins at the lowest command.
    pub fn new(limits: Limits) -> Self {
        Self { limits, waypoints: vec![(0.0, limits.min_bar)] }
    }

    /// Goes to a level in that time, or in what the slew limit needs.
    pub fn ramp(&mut self, level: f64, seconds: f64) {
        let Limits { min_bar, max_bar, slew_bar_per_s } = self.limits;
        let (from_s, from_bar) = self.last();
        let to_bar = min_bar + level * (max_bar - min_bar);
        let needed_s = slew_bar_per_s.map_or(0.0, |slew| (to_bar - from_bar).abs() / slew);
        self.waypoints.push((from_s + seconds.max(needed_s), to_bar));
    }

    /// Jumps to a level, or goes as fast as the slew limit allows, and stays for that time.
    pub fn jump(&mut self, level: f64, hold_s: f64) {
        self.ramp(level, 0.0);
        self.hold(hold_s);
    }

    /// Stays for that time.
    pub fn hold(&mut self, seconds: f64) {
        let (from_s, bar) = self.last();
        self.waypoints.push((from_s + seconds, bar));
    }

    /// Up to a level and back down, each in that time.
    pub fn swing(&mut self, low: f64, high: f64, half_s: f64) {
        self.ramp(high, half_s);
        self.ramp(low, half_s);
    }

    /// Time of the last waypoint. Unit: s.
    pub fn duration_s(&self) -> f64 {
        self.last().0
    }

    /// The command (bar) at times (s) that do not decrease.
    pub fn samples(&self, time_s: impl Iterator<Item = f64>) -> impl Iterator<Item = f64> {
        let mut next = 0;
        time_s.map(move |time_s| {
            while self.waypoints.get(next).is_some_and(|waypoint| waypoint.0 <= time_s) {
                next += 1;
            }
            let (from_s, from_bar) = self.waypoints[next.saturating_sub(1)];
            self.waypoints.get(next).map_or(from_bar, |(to_s, to_bar)| {
                from_bar + (to_bar - from_bar) * (time_s - from_s) / (to_s - from_s)
            })
        })
    }

    fn last(&self) -> (f64, f64) {
        self.waypoints[self.waypoints.len() - 1]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const LIMITS: Limits = Limits { min_bar: 1.0, max_bar: 5.0, slew_bar_per_s: None };

    #[test]
    fn levels_are_shares_of_the_range_and_a_jump_holds_from_its_time_on() {
        let mut course = Course::new(LIMITS);
        course.ramp(0.5, 2.0);
        course.jump(1.0, 3.0);
        let times = [0.0, 1.0, 1.9, 2.0, 5.0, 9.0];
        let found: Vec<f64> = course.samples(times.into_iter()).collect();
        assert_eq!(found, [1.0, 2.0, 2.9, 5.0, 5.0, 5.0]);
        assert_eq!(course.duration_s(), 5.0);
    }

    #[test]
    fn nothing_is_faster_than_the_slew_limit() {
        let mut course = Course::new(Limits { slew_bar_per_s: Some(2.0), ..LIMITS });
        course.jump(1.0, 1.0);
        course.ramp(0.0, 10.0);
        assert_eq!(course.duration_s(), 2.0 + 1.0 + 10.0);
        let samples: Vec<f64> = course.samples((0..1300).map(|row| f64::from(row) * 0.01)).collect();
        assert!(samples.windows(2).all(|pair| (pair[1] - pair[0]).abs() <= 0.02 + 1e-12));
    }
}
