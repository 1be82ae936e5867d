//! A low pass that shifts nothing in time: a Gaussian mean over past and future.
//!
//! Its gain falls as exp(-ln 2/2 (f/fc)²), to 1/√2 at fc: no ringing, and nothing left of noise far
//! above it. Beyond the ends of a signal its last value lasts.

use std::f64::consts::{LN_2, PI};

/// Standard deviations that the mean reaches over.
const REACH: f64 = 4.0;

/// What is left of a frequency behind a filter of this corner. Both: Hz.
pub fn gain(hz: f64, corner_hz: f64) -> f64 {
    (-0.5 * LN_2 * (hz / corner_hz).powi(2)).exp()
}

/// The signal, a value each period (s), behind a filter of this corner (Hz, above 0).
pub fn filtered(values: &[f64], period_s: f64, corner_hz: f64) -> Vec<f64> {
    let (Some(&first), Some(&last)) = (values.first(), values.last()) else { return Vec::new() };
    let width = LN_2.sqrt() / (2.0 * PI * corner_hz) / period_s;
    let reach = ((REACH * width).ceil() as usize).max(1);
    let weights: Vec<f64> = (0..=reach).map(|k| (-0.5 * (k as f64 / width).powi(2)).exp()).collect();
    let whole = weights[0] + 2.0 * weights[1..].iter().sum::<f64>();
    (0..values.len())
        .map(|at| {
            let sides = (1..=reach).map(|k| {
                let before = at.checked_sub(k).map_or(first, |row| values[row]);
                let after = values.get(at + k).copied().unwrap_or(last);
                weights[k] * (before + after)
            });
            (weights[0] * values[at] + sides.sum::<f64>()) / whole
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_sine_keeps_its_phase_and_loses_what_the_gain_says() {
        for (hz, corner_hz) in [(1.0, 5.0), (5.0, 5.0), (8.0, 5.0)] {
            let sine: Vec<f64> = (0..4000).map(|k| (2.0 * PI * hz * 1e-3 * f64::from(k)).sin()).collect();
            let passed = filtered(&sine, 1e-3, corner_hz);
            for at in 1000..3000 {
                let error = passed[at] - gain(hz, corner_hz) * sine[at];
                assert!(error.abs() < 1e-3, "{hz} Hz at {at}: {error}");
            }
        }
    }

    #[test]
    fn a_constant_passes_up_to_its_ends() {
        assert!(filtered(&[3.0; 100], 1e-3, 2.0).iter().all(|value| (value - 3.0).abs() < 1e-12));
        assert!(filtered(&[], 1e-3, 2.0).is_empty());
    }
}
