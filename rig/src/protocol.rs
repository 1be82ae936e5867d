//! Command waveforms of the recordings, all piecewise linear: waypoints of time and command.
//!
//! Two waypoints at one time are a jump; the later one holds from that time on. Each protocol
//! starts at 0 s.

use crate::draw::{Draw, Stream};
use crate::parameters::VALVE_RANGE_BAR;

/// Time of the last of 12,000 instants at 100 Hz, s.
const RICH_S: f64 = 119.99;

/// A command over time.
#[derive(Debug, Clone)]
pub struct Protocol {
    waypoints: Vec<(f64, f64)>,
}

impl Protocol {
    /// Triangles of 20 s with amplitudes of 6, 5, 4, 3, 2 and 1 bar, as in the paper's Fig. 8.
    pub fn decreasing_triangles() -> Self {
        (1..=6).rev().fold(Self::vented(), |protocol, amplitude| {
            protocol.ramp(f64::from(amplitude), 10.0).ramp(0.0, 10.0)
        })
    }

    /// Two triangles over the whole range at each of the periods 40, 20, 10, 5, 2, 1 and 0.5 s.
    pub fn rates() -> Self {
        [40.0, 20.0, 10.0, 5.0, 2.0, 1.0, 0.5].iter().fold(Self::vented(), |protocol, period_s| {
            (0..2).fold(protocol, |protocol, _| {
                protocol.ramp(VALVE_RANGE_BAR, period_s / 2.0).ramp(0.0, period_s / 2.0)
            })
        })
    }

    /// Jumps with holds of 10 s: up and down the range in steps of 1 bar, then ever larger jumps
    /// around 3 bar.
    pub fn holds() -> Self {
        [0, 1, 2, 3, 4, 5, 6, 5, 4, 3, 2, 1, 0, 3, 4, 2, 5, 1, 6, 0]
            .iter()
            .fold(Self::vented(), |protocol, &level| protocol.ramp(f64::from(level), 0.0).hold(10.0))
    }

    /// Sixty ramps to random pressures of the whole range, each of a random duration of 0.5 to 4 s.
    pub fn random_ramps(seed: u64) -> Self {
        let mut draw = Draw::new(seed, Stream::Protocol);
        (0..60).fold(Self::vented(), |protocol, _| {
            protocol.ramp(draw.uniform(0.0, VALVE_RANGE_BAR), draw.uniform(0.5, 4.0))
        })
    }

    /// A recording to diagnose from, 12,000 rows at 100 Hz: slow triangles of falling height, jumps
    /// with holds of 3 to 12 s at all levels, faster triangles at all levels, random ramps, more
    /// holds, and the first triangle again. Levels, their order and the ramps are by the seed.
    pub fn rich(seed: u64) -> Self {
        let mut draw = Draw::new(seed, Stream::Protocol);
        let near = |draw: &mut Draw, bar: f64| (bar * draw.uniform(0.9, 1.1)).min(VALVE_RANGE_BAR);
        let mut holds = [
            (0.7, 12.0),
            (1.3, 3.5),
            (1.9, 4.0),
            (2.4, 10.0),
            (2.9, 3.5),
            (3.6, 4.0),
            (4.5, 3.5),
            (5.6, 3.5),
        ];
        let levels_s = holds.map(|hold| hold.1);
        draw.shuffle(&mut holds);
        let mut durations_s = levels_s;
        draw.shuffle(&mut durations_s);
        let held = |protocol: Self, draw: &mut Draw, from: usize| {
            (from..from + 4).fold(protocol, |protocol, index| {
                protocol.ramp(near(draw, holds[index].0), 0.0).hold(durations_s[index])
            })
        };

        let slow = [(6.0, 6.0), (4.3, 5.0), (2.7, 4.0)];
        let mut protocol = slow.iter().fold(Self::vented(), |protocol, &(peak_bar, half_s)| {
            protocol.ramp(peak_bar, half_s).ramp(0.0, half_s)
        });
        protocol = held(protocol, &mut draw, 0);
        for (low_bar, high_bar, half_s) in
            [(0.2, 6.0, 1.5), (0.5, 2.2, 0.75), (1.5, 3.8, 0.75), (3.0, 6.0, 0.75), (0.2, 6.0, 0.5)]
        {
            let (low_bar, high_bar) = (near(&mut draw, low_bar), near(&mut draw, high_bar));
            for _ in 0..2 {
                protocol = protocol.ramp(high_bar, half_s).ramp(low_bar, half_s);
            }
        }
        for _ in 0..12 {
            protocol = protocol.ramp(draw.uniform(0.0, VALVE_RANGE_BAR), draw.uniform(0.4, 2.2));
        }
        protocol = held(protocol, &mut draw, 4);
        let repeat_s = RICH_S - protocol.duration_s() - 0.5;
        protocol.ramp(0.0, 0.5).ramp(VALVE_RANGE_BAR, 0.5 * repeat_s).ramp(0.0, 0.5 * repeat_s)
    }

    /// Time of the last waypoint, s.
    pub fn duration_s(&self) -> f64 {
        self.last().0
    }

    /// The command at `time_s`, bar. Before the first and after the last waypoint it is theirs.
    pub fn command_bar(&self, time_s: f64) -> f64 {
        self.at(time_s)
    }

    /// The same of a course that is not one of a pressure.
    pub(crate) fn at(&self, time_s: f64) -> f64 {
        let next = self.waypoints.partition_point(|waypoint| waypoint.0 <= time_s);
        if next == 0 {
            return self.waypoints[0].1;
        }
        let (start_s, start_bar) = self.waypoints[next - 1];
        self.waypoints.get(next).map_or(start_bar, |(end_s, end_bar)| {
            start_bar + (end_bar - start_bar) * (time_s - start_s) / (end_s - start_s)
        })
    }

    pub(crate) fn vented() -> Self {
        Self { waypoints: vec![(0.0, 0.0)] }
    }

    pub(crate) fn ramp(mut self, command_bar: f64, duration_s: f64) -> Self {
        self.waypoints.push((self.duration_s() + duration_s, command_bar));
        self
    }

    pub(crate) fn hold(self, duration_s: f64) -> Self {
        let (_, command_bar) = self.last();
        self.ramp(command_bar, duration_s)
    }

    /// The same course, stretched in time by this factor.
    pub(crate) fn stretched(mut self, factor: f64) -> Self {
        self.waypoints.iter_mut().for_each(|waypoint| waypoint.0 *= factor);
        self
    }

    fn last(&self) -> (f64, f64) {
        self.waypoints[self.waypoints.len() - 1]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn triangles_peak_at_ten_seconds_and_return_to_zero() {
        let protocol = Protocol::decreasing_triangles();
        assert_eq!(protocol.duration_s(), 120.0);
        for (time_s, command_bar) in
            [(0.0, 0.0), (5.0, 3.0), (10.0, 6.0), (20.0, 0.0), (30.0, 5.0), (110.0, 1.0), (120.0, 0.0)]
        {
            assert!((protocol.command_bar(time_s) - command_bar).abs() < 1e-12, "at {time_s} s");
        }
    }

    #[test]
    fn jump_holds_from_its_time_on() {
        let protocol = Protocol::holds();
        assert_eq!(protocol.command_bar(9.999), 0.0);
        assert_eq!(protocol.command_bar(10.0), 1.0);
        assert_eq!(protocol.command_bar(19.999), 1.0);
        assert_eq!(protocol.command_bar(1e6), 0.0);
    }

    #[test]
    fn every_protocol_stays_in_the_range_and_random_ramps_depend_on_the_seed() {
        let ramps = |seed| Protocol::random_ramps(seed);
        assert_eq!(ramps(1).waypoints, ramps(1).waypoints);
        assert_ne!(ramps(1).waypoints, ramps(2).waypoints);
        for protocol in [Protocol::decreasing_triangles(), Protocol::rates(), Protocol::holds(), ramps(3)] {
            assert!(protocol.waypoints.iter().all(|w| (0.0..=VALVE_RANGE_BAR).contains(&w.1)));
            assert!(protocol.waypoints.is_sorted_by_key(|w| w.0));
        }
    }

    #[test]
    fn rich_recordings_have_holds_fast_and_slow_parts_and_a_repeat_whatever_the_seed() {
        for seed in 0..200 {
            let legs = Protocol::rich(seed).waypoints;
            assert!(legs.iter().all(|leg| (0.0..=VALVE_RANGE_BAR).contains(&leg.1)));
            assert!(legs.is_sorted_by_key(|leg| leg.0) && (legs[legs.len() - 1].0 - RICH_S).abs() < 1e-9);
            let legs: Vec<_> =
                legs.windows(2).map(|leg| (leg[1].0 - leg[0].0, leg[1].1 - leg[0].1)).collect();
            let held_s =
                |at_least_s: f64| legs.iter().filter(|leg| leg.1 == 0.0 && leg.0 >= at_least_s).count();
            assert!(held_s(3.0) == 8 && held_s(10.0) == 2);
            let rates =
                || legs.iter().filter(|leg| leg.0 > 0.0 && leg.1 != 0.0).map(|leg| leg.1.abs() / leg.0);
            assert!(rates().any(|rate| rate < 1.0) && rates().any(|rate| rate > 8.0));
            assert!(legs[legs.len() - 1].0 > 1.0, "the repeat of seed {seed} is cut short");
        }
    }
}
