//! A reading of the contraction that sticks and jumps while the muscle moves: a rod, a string or a slider that catches.
//!
//! In a short window of steady motion a sensor's errors change from sample to sample as much one way as the other. One that sticks falls
//! behind a little at each sample and makes up for it at once: the changes along the motion are skewed. A sawtooth with a jump every m
//! samples has the skewness (m - 2)/sqrt(m - 1), noise has none.
//!
//! # Limits
//! Jumps at every other sample or so do not show, nor those of a few steps of the sensor's resolution. A muscle that itself sticks and slips
//! looks the same. Where the input moves in jumps (a valve's dead band) the muscle follows them.

use super::chance::{FOUND, standard_errors};
use super::signals::Signals;
use recording::noise::steps;

/// Windows are so long, or of so many samples: a choice, so short that most motions are steady, and long enough for some jumps. Unit: s;
/// samples.
const WINDOW_S: f64 = 0.25;
const SAMPLES: usize = 8;
/// A window is left out, because rows are missing in it, if it lasts longer than this many times its usual length: a choice. Unit: 1.
const LONGEST: f64 = 1.5;
/// Windows that tell a mean.
const WINDOWS: usize = 20;
/// A window counts only if some change exceeds so many steps of the sensor's resolution: rounding alone makes changes of one step, and noise
/// adds one at either end. Unit: steps.
const QUANTA: f64 = 3.0;
/// The reading sticks if its skewness exceeds the input's by more than this: about that of a sawtooth with a jump at every fourth sample,
/// 2/sqrt(3). A choice; the level of errors is that of the standard error beside it. Unit: 1.
const SKEWED: f64 = 1.0;

/// A reading that sticks and jumps.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Slips {
    /// What it jumps by, in the middle of all windows. Output unit.
    pub jump: f64,
    /// The skewness of its changes along the motion.
    pub skewness: f64,
}

/// That of a recording; None where the reading does not stick, or there is too little motion to tell.
pub fn slips(signals: &Signals) -> Option<Slips> {
    let all = &signals.recorded;
    let reading = Changes::of(&all.scored_s, &all.scored, signals.noise_floor.quantum)?;
    let input = Changes::of(&all.time_s, &all.input, 0.0).map_or(0.0, |input| input.skewness.max(0.0));
    let is_by_chance = reading.skewness <= standard_errors(FOUND, 1, 1) * reading.error;
    (reading.skewness - input > SKEWED && !is_by_chance)
        .then_some(Slips { jump: reading.largest, skewness: reading.skewness })
}

/// How the errors of a signal change along its motion.
struct Changes {
    /// The mean skewness of windows.
    skewness: f64,
    /// Its standard error.
    error: f64,
    /// The median of the largest change of a window. Unit of the signal.
    largest: f64,
}

impl Changes {
    /// Of a signal with this resolution; None where too few windows have steady motion.
    fn of(time_s: &[f64], values: &[f64], quantum: f64) -> Option<Self> {
        let step_s = steps(time_s).0;
        let samples = ((WINDOW_S / step_s.max(1e-9)) as usize).max(SAMPLES);
        let longest_s = LONGEST * samples as f64 * step_s;
        let windows = time_s.chunks_exact(samples).zip(values.chunks_exact(samples));
        let windows = windows.filter(|(time_s, _)| time_s[samples - 1] - time_s[0] <= longest_s);
        let of_window = |(time_s, values): (&[f64], &[f64])| along_motion(time_s, values);
        let is_seen = |changes: &Vec<f64>| changes.iter().any(|change| change.abs() > QUANTA * quantum);
        let all: Vec<(f64, f64)> =
            windows.filter_map(of_window).filter(is_seen).map(|changes| skewness(&changes)).collect();
        if all.len() < WINDOWS {
            return None;
        }
        let count = all.len() as f64;
        let mean = all.iter().map(|(skewness, _)| skewness).sum::<f64>() / count;
        let squares: f64 = all.iter().map(|(skewness, _)| (skewness - mean).powi(2)).sum();
        let mut largest: Vec<f64> = all.iter().map(|(_, largest)| *largest).collect();
        largest.sort_by(f64::total_cmp);
        Some(Self {
            skewness: mean,
            error: (squares / (count * (count - 1.0))).sqrt(),
            largest: largest[largest.len() / 2],
        })
    }
}

/// The changes from sample to sample of what a parabola leaves of a window, forward in the direction of its motion; None where that is not
/// steady: from the middle to an end the rate changes by more than itself.
fn along_motion(time_s: &[f64], values: &[f64]) -> Option<Vec<f64>> {
    let mean = |values: &[f64]| values.iter().sum::<f64>() / values.len() as f64;
    let dot = |one: &[f64], other: &[f64]| one.iter().zip(other).map(|(a, b)| a * b).sum::<f64>();
    let centred = |values: &[f64]| {
        let mean = mean(values);
        values.iter().map(|value| value - mean).collect::<Vec<_>>()
    };
    // Without what the line has of them: of each of the two then its own share.
    let less = |values: &[f64], line: &[f64]| {
        let share = dot(values, line) / dot(line, line);
        (values.iter().zip(line).map(|(value, line)| value - share * line).collect::<Vec<_>>(), share)
    };
    let line = centred(time_s);
    let (parabola, _) = less(&centred(&line.iter().map(|t| t * t).collect::<Vec<_>>()), &line);
    let (left, rate) = less(&centred(values), &line);
    let (left, bend) = less(&left, &parabola);
    let half_s = 0.5 * (time_s.last()? - time_s.first()?);
    let is_steady = 2.0 * bend.abs() * half_s <= rate.abs() && rate != 0.0;
    is_steady.then(|| left.windows(2).map(|pair| (pair[1] - pair[0]) * rate.signum()).collect())
}

/// The skewness of changes about 0, and the largest.
fn skewness(changes: &[f64]) -> (f64, f64) {
    let mean =
        |power: i32| changes.iter().map(|change| change.powi(power)).sum::<f64>() / changes.len() as f64;
    let largest = changes.iter().copied().fold(f64::NEG_INFINITY, f64::max);
    (mean(3) / mean(2).max(f64::MIN_POSITIVE).powf(1.5), largest)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::synthetic::Noise;

    /// Swings of 30 mm, 100 samples a second.
    fn swings() -> (Vec<f64>, Vec<f64>) {
        let time_s: Vec<f64> = (0..6000).map(|row| 0.01 * f64::from(row)).collect();
        let swings = time_s.iter().map(|t| 30.0 * (1.0 - (2.0 * (0.2 * t).fract() - 1.0).abs())).collect();
        (time_s, swings)
    }

    /// Read by a rod that follows once it is so far off.
    fn sticking(values: &[f64], distance: f64) -> Vec<f64> {
        let mut held = values[0];
        let read = |value: &f64| {
            if (value - held).abs() >= distance {
                held = *value;
            }
            held
        };
        values.iter().map(read).collect()
    }

    #[test]
    fn a_rod_that_sticks_skews_what_a_reading_changes_by_and_noise_does_not() {
        let (time_s, swings) = swings();
        let noisy = |values: &[f64]| {
            let mut noise = Noise::new(1);
            values.iter().map(|value| value + noise.white(0.02)).collect::<Vec<_>>()
        };
        let sound = Changes::of(&time_s, &noisy(&swings), 0.0).expect("motion");
        assert!(sound.skewness.abs() < 0.1, "{}", sound.skewness);
        let sticks = Changes::of(&time_s, &noisy(&sticking(&swings, 0.8)), 0.0).expect("motion");
        assert!(sticks.skewness > 1.2 && sticks.skewness > 10.0 * sticks.error, "{}", sticks.skewness);
        assert!((0.6..1.0).contains(&sticks.largest), "{}", sticks.largest);
    }

    #[test]
    fn the_steps_of_a_resolution_are_no_jumps() {
        let (time_s, swings) = swings();
        let slow: Vec<f64> = swings.iter().map(|value| 0.1 * value).collect();
        let coarse: Vec<f64> = slow.iter().map(|value| (value / 0.05).round() * 0.05).collect();
        assert!(Changes::of(&time_s, &coarse, 0.05).is_none());
        assert!(Changes::of(&time_s, &coarse, 0.0).is_some_and(|changes| changes.skewness > SKEWED));
    }

    #[test]
    fn what_is_not_steady_is_not_looked_at() {
        let (time_s, _) = swings();
        let still = vec![3.0; time_s.len()];
        assert!(Changes::of(&time_s, &still, 0.0).is_none());
        let fast: Vec<f64> = time_s.iter().map(|t| (25.0 * t).sin()).collect();
        let seen = |changes: Option<Vec<f64>>| usize::from(changes.is_some());
        let windows = time_s.chunks_exact(25).zip(fast.chunks_exact(25));
        let steady: usize = windows.map(|(time_s, values)| seen(along_motion(time_s, values))).sum();
        assert!(steady < 120, "{steady} of 240");
    }
}
