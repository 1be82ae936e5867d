//! The strongest tones of a residual.

use std::f64::consts::TAU;

use super::signals::{Signals, median};

/// Frequencies a resolution of the record.
const OVERSAMPLING: f64 = 2.0;
/// Neighbours on either side that make the local level.
const NEIGHBOURS: usize = 40;
/// A peak's power, as a multiple of the local median.
const ABOVE: f64 = 12.0;

/// Frequencies of the tones that stand out of their neighbourhood, the strongest first. Unit: Hz.
pub fn tones(signals: &Signals, residual: &[f64], most: usize) -> Vec<f64> {
    let duration_s = signals.duration_s();
    let rows = residual.len();
    if rows < 64 {
        return Vec::new();
    }
    let spacing_hz = 1.0 / (OVERSAMPLING * duration_s);
    let highest_hz = 0.4 * rows as f64 / duration_s;
    let first = (3.0 * OVERSAMPLING) as usize;
    let count = (highest_hz / spacing_hz) as usize;
    let powers: Vec<f64> = (first..count).map(|i| power(signals, residual, i as f64 * spacing_hz)).collect();
    let mut peaks: Vec<(f64, f64)> = Vec::new();
    for (i, &here) in powers.iter().enumerate() {
        let before = i.checked_sub(1).map_or(0.0, |j| powers[j]);
        let after = powers.get(i + 1).copied().unwrap_or(0.0);
        if here < before || here <= after {
            continue;
        }
        let mut around = powers[i.saturating_sub(NEIGHBOURS)..(i + NEIGHBOURS).min(powers.len())].to_vec();
        if here > ABOVE * median(&mut around) {
            peaks.push((here, (first + i) as f64 * spacing_hz));
        }
    }
    peaks.sort_by(|one, other| other.0.total_cmp(&one.0));
    peaks.iter().take(most).map(|peak| peak.1).collect()
}

/// Squared size of the Fourier sum at a frequency.
fn power(signals: &Signals, residual: &[f64], frequency_hz: f64) -> f64 {
    let turn = |step_s: f64| (TAU * frequency_hz * step_s).sin_cos();
    let (mut sine, mut cosine) = (0.0, 1.0);
    let (mut real, mut imaginary) = (0.0, 0.0);
    let mut last_s = signals.rows.first().map_or(0.0, |row| signals.time_s[row.at]);
    let mut known = (0.0, (0.0, 1.0));
    for (row, value) in signals.rows.iter().zip(residual) {
        let step_s = signals.time_s[row.at] - last_s;
        last_s += step_s;
        if (step_s - known.0).abs() > 1e-9 {
            known = (step_s, turn(step_s));
        }
        let (s, c) = known.1;
        (sine, cosine) = (sine * c + cosine * s, cosine * c - sine * s);
        real += value * cosine;
        imaginary += value * sine;
    }
    real * real + imaginary * imaginary
}
