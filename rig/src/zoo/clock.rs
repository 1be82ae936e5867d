//! When rows are recorded.

use crate::draw::Draw;

/// Rates of rows, the usual ones twice, Hz.
const RATES_HZ: [f64; 8] = [20.0, 50.0, 100.0, 100.0, 200.0, 200.0, 500.0, 1000.0];

/// Shortest and longest recording, s.
const DURATIONS_S: (f64, f64) = (60.0, 600.0);

/// Most rows of a recording that is longer than the shortest. It bounds the time of a game (about 4
/// s of one core), since hundreds are played.
const MOST_ROWS: f64 = 24_000.0;

/// A logger's clock.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Clock {
    /// Rows a second, Hz.
    pub rate_hz: f64,
    /// Length of the recording, s.
    pub duration_s: f64,
    /// Standard deviation of the instants, as a share of the step.
    pub jitter: f64,
    /// Share of rows that are lost one by one.
    pub lost: f64,
    /// Gaps of up to a second.
    pub gaps: usize,
}

impl Clock {
    pub(crate) fn drawn(draw: &mut Draw) -> Self {
        let (shortest_s, longest_s) = DURATIONS_S;
        let rate_hz = RATES_HZ[draw.index(RATES_HZ.len())];
        let duration_s = draw.log_uniform(shortest_s, longest_s).min(shortest_s.max(MOST_ROWS / rate_hz));
        let jitter = [0.0, draw.uniform(0.02, 0.15)][draw.index(2)];
        let (lost, gaps) = [(0.0, 0), (draw.uniform(0.0005, 0.01), draw.index(4))][draw.index(2)];
        Self { rate_hz, duration_s, jitter, lost, gaps }
    }

    /// The instants of the rows, ascending, s.
    pub(crate) fn instants_s(&self, draw: &mut Draw) -> Vec<f64> {
        let step_s = 1.0 / self.rate_hz;
        let gaps: Vec<_> = (0..self.gaps)
            .map(|_| (draw.uniform(0.1, 0.9) * self.duration_s, draw.uniform(0.1, 1.0)))
            .collect();
        let count = (self.duration_s * self.rate_hz) as usize;
        let mut instants_s = Vec::with_capacity(count + 1);
        for index in 0..=count {
            let shift = (self.jitter * draw.normal()).clamp(-0.4, 0.4);
            let is_lost = draw.uniform(0.0, 1.0) < self.lost;
            let time_s = step_s * (index as f64 + if index == 0 { 0.0 } else { shift });
            let in_gap = gaps.iter().any(|(from_s, length_s)| time_s > *from_s && time_s < from_s + length_s);
            if index == 0 || !(is_lost || in_gap) {
                instants_s.push(time_s);
            }
        }
        instants_s
    }
}
