//! How often a test of the anatomy raises an alarm, counted by Monte Carlo.

use rayon::prelude::*;

/// How many of `runs` seeded runs raise an alarm, as a share.
pub fn alarms(runs: u64, is_alarm: impl Fn(u64) -> bool + Sync) -> f64 {
    (0..runs).into_par_iter().filter(|&seed| is_alarm(seed)).count() as f64 / runs as f64
}
