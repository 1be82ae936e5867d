//! References of the benchmark, each between two shares of the model's output range.
//!
//! A muscle that has contracted does not come back to where it began by itself: all of them stay
//! above a tenth.

use std::f64::consts::{PI, TAU};

use crate::PERIOD_S;

/// How long a reference takes from rest to where it begins, and its settling there. Unit: s. A
/// convention: what has not settled by then counts as error.
const APPROACH_S: f64 = 3.0;

/// What is to be tracked.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Course {
    /// Raised cosines of 20 s between 0.08 and falling peaks, as in the paper's Fig. 11.
    Paper,
    /// Raised cosines of this frequency (Hz) over this share of the stroke.
    Cosines(f64, f64),
    /// Triangles of this frequency (Hz) over 0.6 of the stroke.
    Triangles(f64),
    /// Jumps of a tenth to a third of the stroke, each held for 3 s.
    Steps,
    /// Eight tones from 0.05 to 2 Hz.
    Multisine,
    /// Held in the middle, while a load comes and goes.
    Held,
}

impl Course {
    /// Its name in the table.
    pub fn name(self) -> String {
        match self {
            Self::Paper => "paper's, 20 s".to_owned(),
            Self::Cosines(hz, share) => format!("{hz} Hz, {:.0} %", 100.0 * share),
            Self::Triangles(hz) => format!("triangles {hz} Hz"),
            Self::Steps => "steps".to_owned(),
            Self::Multisine => "0.05 to 2 Hz".to_owned(),
            Self::Held => "load step".to_owned(),
        }
    }

    /// The highest frequency in it. Unit: Hz.
    pub fn highest_hz(self) -> f64 {
        match self {
            Self::Paper => 0.05,
            Self::Cosines(hz, _) | Self::Triangles(hz) => hz,
            Self::Multisine => 2.0,
            Self::Steps | Self::Held => 0.0,
        }
    }

    /// How long it takes behind the approach. Unit: s.
    fn duration_s(self) -> f64 {
        match self {
            Self::Paper => 60.0,
            Self::Cosines(hz, _) => (3.0 / hz).max(6.0),
            Self::Triangles(hz) => 3.0 / hz,
            Self::Steps => 24.0,
            Self::Multisine => 40.0,
            Self::Held => 12.0,
        }
    }

    /// The share of the stroke at a time after the approach (s).
    fn share(self, time_s: f64) -> f64 {
        let rise = |turns: f64| 0.5 * (1.0 - (TAU * turns).cos());
        match self {
            Self::Paper => {
                let (cycle, peaks) = ((time_s / 20.0) as usize, [0.88, 0.64, 0.4]);
                0.1 + peaks[cycle.min(2)] * rise(time_s / 20.0) - 0.02 * rise(time_s / 20.0)
            }
            Self::Cosines(hz, share) => 0.5 - 0.5 * share + share * rise(hz * time_s),
            Self::Triangles(hz) => 0.2 + 0.6 * (1.0 - (2.0 * (hz * time_s).fract() - 1.0).abs()),
            Self::Steps => {
                let levels = [0.4, 0.5, 0.75, 0.65, 0.35, 0.5, 0.8, 0.5];
                levels[(time_s / 3.0) as usize % levels.len()]
            }
            Self::Multisine => {
                let tones = [0.05, 0.09, 0.15, 0.26, 0.43, 0.72, 1.2, 2.0];
                let sum: f64 = tones
                    .iter()
                    .enumerate()
                    // Schroeder's phases: no peak. Less of what is fast.
                    .map(|(k, hz)| (TAU * hz * time_s + PI * (k * k) as f64 / 8.0).sin() / (1.0 + 2.0 * hz))
                    .sum();
                0.5 + 0.09 * sum
            }
            Self::Held => 0.5,
        }
    }

    /// A value a tick, between the model's outputs. Unit: that of the range.
    pub fn points(self, (low, high): (f64, f64)) -> Vec<f64> {
        let ticks = |s: f64| (s / PERIOD_S).round() as usize;
        let at = |share: f64| low + share * (high - low);
        let (begin, approach) = (self.share(0.0), ticks(APPROACH_S));
        let up = (0..approach).map(|tick| {
            let way = (1.5 * tick as f64 / approach as f64).min(1.0);
            at(begin * 0.5 * (1.0 - (PI * way).cos()))
        });
        let course = (0..ticks(self.duration_s())).map(|tick| at(self.share(tick as f64 * PERIOD_S)));
        up.chain(course).collect()
    }

    /// From which tick on it is scored.
    pub fn from_tick() -> usize {
        (APPROACH_S / PERIOD_S).round() as usize
    }

    /// The load that is put on at a tick, as a share of the blocked force.
    pub fn load_share(self, tick: usize) -> f64 {
        let time_s = tick as f64 * PERIOD_S - APPROACH_S;
        if self == Self::Held && (2.0..7.0).contains(&time_s) { 0.2 } else { 0.0 }
    }
}
