//! Two random courses over time: a smooth slow wave, and a staircase.

use std::f64::consts::TAU;

use crate::draw::Draw;

/// A smooth course around 0: three sines of random periods and phases, with a root mean square near
/// 1.
#[derive(Debug, Clone)]
pub(crate) struct Wave([(f64, f64); 3]);

impl Wave {
    /// A wave with periods between the two bounds, s.
    pub(crate) fn new(draw: &mut Draw, shortest_s: f64, longest_s: f64) -> Self {
        Self([(); 3].map(|()| (TAU / draw.log_uniform(shortest_s, longest_s), draw.uniform(0.0, TAU))))
    }

    /// Its value at `time_s`.
    pub(crate) fn at(&self, time_s: f64) -> f64 {
        let sum: f64 = self.0.iter().map(|(rate, phase)| (rate * time_s + phase).sin()).sum();
        sum * (2.0f64 / 3.0).sqrt()
    }
}

/// Levels from 0 to 1, each held for a random time; 0 at first.
#[derive(Debug, Clone)]
pub(crate) struct Staircase {
    draw: Draw,
    shortest_s: f64,
    longest_s: f64,
    next_s: f64,
    level: f64,
}

impl Staircase {
    /// A staircase with holds between the two bounds, s.
    pub(crate) fn new(mut draw: Draw, shortest_s: f64, longest_s: f64) -> Self {
        let next_s = draw.uniform(shortest_s, longest_s);
        Self { draw, shortest_s, longest_s, next_s, level: 0.0 }
    }

    /// The level at `time_s`, which never goes back.
    pub(crate) fn at(&mut self, time_s: f64) -> f64 {
        while time_s >= self.next_s {
            self.level = self.draw.uniform(0.0, 1.0);
            self.next_s += self.draw.uniform(self.shortest_s, self.longest_s);
        }
        self.level
    }
}
