//! The noise floor of a measured signal, from the signal alone.
//!
//! # Design
//! How far each value lies from the straight line through its two neighbours, e = y1 - (a y0 + b
//! y2), a + b = 1: what moves steadily drops out, white noise of variance s² leaves s² (1 + a² +
//! b²). Only the slower half of the rows counts (holds and slow parts, told by their neighbours
//! five rows away, which share no noise with e), and what lies beyond three standard deviations
//! does not (steps, dropped samples), until that settles. A sensor's step of `quantum` makes an
//! error of quantum/√12 even where it shows no change.
//!
//! # Limits
//! Noise that neighbouring rows share is underestimated: by √(1 - (4 ρ1 - ρ2)/3), where ρ1, ρ2 are
//! its correlations over one and two rows (a filtered sensor). Curvature is overestimated as noise
//! where a row is long against the movement. A tone is noise when it has fewer than some six rows a
//! period.

use serde::Serialize;

use crate::numbers::{median, quantiles};

/// Values beyond so many standard deviations are no noise.
const CLIP: f64 = 3.0;
/// Variance that a normal distribution has left within three standard deviations.
const CLIPPED_VARIANCE: f64 = 0.9733;
/// How often the clipping is repeated, at most.
const REPEATS: usize = 20;
/// A row is slow by the way between its neighbours so many rows away.
const AWAY: usize = 5;

/// How noisy a signal is. Unit: that of the signal.
///
/// ```
/// use recording::noise;
///
/// let time_s: Vec<f64> = (0..500).map(|k| 0.01 * f64::from(k)).collect();
/// let smooth: Vec<f64> = time_s.iter().map(|t| 50.0 * t.sin()).collect();
/// assert!(noise::floor(&time_s, &smooth).deviation < 0.05); // mm: a smooth signal has next to no noise
/// ```
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct NoiseFloor {
    /// Standard deviation of the noise, quantisation included.
    pub deviation: f64,
    /// The smallest difference between two values: the sensor's step, or the file's last decimal.
    pub quantum: f64,
    /// Rows that it was estimated from.
    pub rows: usize,
}

/// The median of the steps of time, and the step above which there is a gap. Unit: s.
pub fn steps(time_s: &[f64]) -> (f64, f64) {
    /// A step of time that many times as long as all but a few is a gap: the muscle may have moved
    /// in it.
    const GAP_STEPS: f64 = 5.0;
    /// So few: where single rows are missing all over the recording, no step that leaves some out
    /// is a gap.
    const FEW: f64 = 0.05;
    let mut all: Vec<f64> = time_s.windows(2).map(|pair| pair[1] - pair[0]).collect();
    let (_, usual_s) = quantiles(&all, FEW);
    (median(&mut all), GAP_STEPS * usual_s)
}

/// The noise floor of a signal; 0 of fewer than three rows.
pub fn floor(time_s: &[f64], values: &[f64]) -> NoiseFloor {
    let (_, gap_s) = steps(time_s);
    let (mut slowness, mut errors) = (Vec::new(), Vec::new());
    for row in 1..values.len().saturating_sub(1) {
        let (before_s, after_s) = (time_s[row] - time_s[row - 1], time_s[row + 1] - time_s[row]);
        if before_s.max(after_s) > gap_s {
            continue;
        }
        let b = before_s / (before_s + after_s);
        let a = 1.0 - b;
        let error = values[row] - a * values[row - 1] - b * values[row + 1];
        errors.push((error / (1.0 + a * a + b * b).sqrt()).abs());
        let (from, to) = (row.saturating_sub(AWAY), (row + AWAY).min(values.len() - 1));
        slowness.push((values[to] - values[from]).abs());
    }
    let mut order = slowness.clone();
    order.sort_by(f64::total_cmp);
    let slow = order.get(order.len() / 2).copied().unwrap_or(0.0);
    let mut errors: Vec<f64> =
        errors.into_iter().zip(slowness).filter(|(_, way)| *way <= slow).map(|(error, _)| error).collect();
    errors.sort_by(f64::total_cmp);
    let quantum = quantum(values);
    NoiseFloor {
        deviation: clipped_deviation(&errors).max(quantum / 12.0_f64.sqrt()),
        quantum,
        rows: errors.len(),
    }
}

/// Root of the mean square of sorted sizes, without those that are no noise.
fn clipped_deviation(sizes: &[f64]) -> f64 {
    let mut kept = sizes;
    for _ in 0..REPEATS {
        let square = kept.iter().map(|e| e * e).sum::<f64>() / kept.len().max(1) as f64;
        let whole = kept.len() == sizes.len();
        let deviation = (square / if whole { 1.0 } else { CLIPPED_VARIANCE }).sqrt();
        let within = sizes.partition_point(|&size| size <= CLIP * deviation);
        if within == kept.len() || within == 0 {
            return deviation;
        }
        kept = &sizes[..within];
    }
    (kept.iter().map(|e| e * e).sum::<f64>() / kept.len() as f64 / CLIPPED_VARIANCE).sqrt()
}

/// The smallest difference between two values that differ.
fn quantum(values: &[f64]) -> f64 {
    let mut sorted = values.to_vec();
    sorted.sort_by(f64::total_cmp);
    let smallest = sorted.windows(2).map(|pair| pair[1] - pair[0]).filter(|step| *step > 0.0);
    let smallest = smallest.fold(f64::INFINITY, f64::min);
    if smallest.is_finite() { smallest } else { 0.0 }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::synthetic::{Noise, held_triangles, times, triangles};

    #[test]
    fn white_noise_on_triangles_and_holds_is_found_within_5_percent() {
        let time_s = times(12_000, 0.01);
        for seed in 0..20 {
            let mut noise = Noise::new(seed);
            let moving: Vec<f64> =
                time_s.iter().map(|&t| 20.0 * triangles(t, 20.0) + noise.white(0.03)).collect();
            let holding: Vec<f64> =
                time_s.iter().map(|&t| 20.0 * held_triangles(t, 2.0) + noise.white(0.03)).collect();
            for values in [moving, holding] {
                let found = floor(&time_s, &values).deviation;
                assert!((found / 0.03 - 1.0).abs() < 0.05, "seed {seed}: {found}");
            }
        }
    }

    #[test]
    fn steps_and_outliers_do_not_raise_it() {
        let time_s = times(6000, 0.01);
        let mut noise = Noise::new(3);
        let values: Vec<f64> = (0..6000)
            .map(|row| {
                let step = f64::from(row / 300 % 5);
                let outlier = if row % 97 == 0 { 10.0 } else { 0.0 };
                step + outlier + noise.white(0.03)
            })
            .collect();
        let found = floor(&time_s, &values).deviation;
        assert!((found / 0.03 - 1.0).abs() < 0.1, "{found}");
    }

    #[test]
    fn a_quantised_signal_has_the_noise_of_its_quantisation_too() {
        // From noise far below the quantum to noise above it.
        let time_s = times(12_000, 0.01);
        for (deviation, quantum) in [(0.002, 0.1), (0.01, 0.1), (0.05, 0.1), (0.1, 0.1), (0.1, 0.01)] {
            let mut noise = Noise::new(5);
            let values: Vec<f64> = time_s
                .iter()
                .map(|&t| {
                    let y = 5.0 * triangles(t, 60.0) + noise.white(deviation);
                    (y / quantum).round() * quantum
                })
                .collect();
            let expected = (deviation * deviation + quantum * quantum / 12.0_f64).sqrt();
            let found = floor(&time_s, &values).deviation;
            assert!((found / expected - 1.0).abs() < 0.15, "{deviation} {quantum}: {found}, not {expected}");
        }
    }

    #[test]
    fn unequal_steps_of_time_do_not_change_it() {
        let mut noise = Noise::new(7);
        let mut time_s = vec![0.0];
        for row in 0..6000 {
            time_s.push(time_s[row] + 0.01 * (1.0 + 0.6 * noise.white(0.5).clamp(-1.0, 1.0)));
        }
        let values: Vec<f64> =
            time_s.iter().map(|&t| 10.0 * triangles(t, 20.0) + noise.white(0.03)).collect();
        let found = floor(&time_s, &values).deviation;
        assert!((found / 0.03 - 1.0).abs() < 0.08, "{found}");
    }

    #[test]
    fn filtered_noise_is_underestimated_as_documented() {
        let time_s = times(12_000, 0.01);
        let like: f64 = 0.5;
        let found = floor(&time_s, &Noise::new(9).autoregressive(12_000, like)).deviation;
        let documented = (1.0 - (4.0 * like - like * like) / 3.0).sqrt();
        assert!((found / documented - 1.0).abs() < 0.06, "{found}, not {documented}");
    }

    #[test]
    fn a_constant_signal_has_none() {
        assert_eq!(floor(&times(200, 0.1), &[3.0; 200]).deviation, 0.0);
        assert_eq!(floor(&[], &[]).rows, 0);
    }
}
