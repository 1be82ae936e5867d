//! The residual by frequency, and peaks that stand above their neighbourhood.
//!
//! # Design
//! One periodogram of the whole recording on a grid of equal steps (means of rows; empty cells and gaps count as nothing,
//! which the window's norm considers), under a Hann window: the finest resolution there is. The local level is the median
//! in bands of frequency, interpolated, so that a red residual raises no alarm; a peak is a line that white noise of the
//! local level would make somewhere in the spectrum in fewer than 1 of 100 recordings.
//!
//! # Limits
//! Lines nearer to each other, or to 0, than some four lines of the grid (4/duration) are not told apart. The lines of a
//! periodic excitation are marked ([`Peak::in_input`]); a disturbance exactly on one of them cannot be told from it.

use std::f64::consts::{LN_2, TAU};

use rustfft::FftPlanner;
use rustfft::num_complex::Complex;
use serde::Serialize;

use recording::noise::steps;
use recording::numbers::{median, range};

/// Periods of a tone: what comes back less often is as well a drift, a warm-up or the order of an experiment.
pub const LEAST_PERIODS: f64 = 5.0;
/// The most steps of the grid.
const MOST_STEPS: f64 = 65_536.0;
/// The main lobe of the window, to either side. Unit: lines.
const LOBE: usize = 3;
/// The fewest lines of a band, and the ratio of a band's highest to its lowest frequency otherwise.
const BAND_LINES: usize = 24;
const BAND_RATIO: f64 = 1.3;
/// How often a peak may be chance, in a whole spectrum.
const LEVEL: f64 = 0.01;
/// A line of the input from this share of its span on is strong; it drives so many multiples of itself; and a tone within so many lines
/// of the grid is not told from one, which is where the window has them.
const STRONG: f64 = 0.05;
const MULTIPLES: f64 = 5.0;
const NEAR: f64 = 2.0;
/// Points of the drawn density.
const POINTS: f64 = 120.0;
/// The most peaks.
const MOST_PEAKS: usize = 10;

/// A residual by frequency.
#[derive(Clone, Debug, Serialize)]
pub struct Spectrum {
    /// Power density, from low frequencies to high.
    pub density: Vec<Density>,
    /// Peaks above the local level, the largest amplitude first.
    pub peaks: Vec<Peak>,
}

/// Power density at a frequency.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Density {
    /// Unit: Hz.
    pub frequency_hz: f64,
    /// One-sided, the mean over neighbouring lines. Unit: output unit²/Hz.
    pub power: f64,
}

/// A tone in the residual.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Peak {
    /// Unit: Hz.
    pub frequency_hz: f64,
    /// Output unit.
    pub amplitude: f64,
    /// Power above the local level.
    pub above_level: f64,
    /// Whether the input has a peak there as well: then it may be the input's.
    pub in_input: bool,
}

impl Spectrum {
    /// The spectrum of a residual, beside that of its input.
    pub fn of(time_s: &[f64], residual: &[f64], input: &[f64]) -> Self {
        let grid = Grid::of(time_s);
        let lines = grid.lines(residual);
        let of_input = peak_lines(&grid.lines(input));
        Self { density: grid.density(&lines), peaks: grid.peaks(&lines, &of_input) }
    }
}

/// Frequencies of the strongest tones of a residual that are seen for [`LEAST_PERIODS`], `most` of them at most, the strongest
/// first. Unit: Hz.
pub fn tones(time_s: &[f64], residual: &[f64], most: usize) -> Vec<f64> {
    let grid = Grid::of(time_s);
    let peaks = grid.peaks(&grid.lines(residual), &[]);
    let is_seen = |frequency_hz: &f64| *frequency_hz >= LEAST_PERIODS * grid.line_hz;
    peaks.iter().map(|peak| peak.frequency_hz).filter(is_seen).take(most).collect()
}

/// The strong lines of a periodic input. What they drive has its tones there and at their multiples, whatever is wrong with it.
#[derive(Clone, Debug, Default)]
pub struct InputLines {
    /// Unit: Hz.
    frequencies_hz: Vec<f64>,
    /// What is no farther from one is not told from it. Unit: Hz.
    near_hz: f64,
}

impl InputLines {
    /// Those of an input.
    pub fn of(time_s: &[f64], input: &[f64]) -> Self {
        let grid = Grid::of(time_s);
        let (low, high) = range(input);
        let is_strong = |peak: &Peak| peak.amplitude >= STRONG * (high - low);
        let peaks = grid.peaks(&grid.lines(input), &[]).into_iter().filter(is_strong);
        Self { frequencies_hz: peaks.map(|peak| peak.frequency_hz).collect(), near_hz: NEAR * grid.line_hz }
    }

    /// Whether a tone of this frequency may be the input's.
    pub fn have(&self, frequency_hz: f64) -> bool {
        self.frequencies_hz.iter().any(|line_hz| {
            let multiple = (frequency_hz / line_hz).round().clamp(1.0, MULTIPLES);
            (frequency_hz - multiple * line_hz).abs() <= self.near_hz
        })
    }
}

/// Amplitude of a tone of this frequency, which may be faster than the rows. Unit of the values.
pub fn amplitude(time_s: &[f64], values: &[f64], frequency_hz: f64) -> f64 {
    let (Some(first_s), Some(last_s)) = (time_s.first(), time_s.last()) else { return 0.0 };
    let (mut sum, mut windows) = (Complex::new(0.0, 0.0), 0.0);
    for (time_s, value) in time_s.iter().zip(values) {
        let window = 0.5 - 0.5 * (TAU * (time_s - first_s) / (last_s - first_s)).cos();
        sum += Complex::from_polar(window * value, -TAU * frequency_hz * (time_s - first_s));
        windows += window;
    }
    2.0 * sum.norm() / windows
}

/// Equal steps of time.
struct Grid {
    /// The step of each row.
    place: Vec<usize>,
    /// The window, 0 where a step has no row.
    window: Vec<f64>,
    /// Distance of the lines. Unit: Hz.
    line_hz: f64,
    /// Amplitude of a tone over the root of its line's power.
    amplitude: f64,
    /// Power density over power.
    density: f64,
}

impl Grid {
    fn of(time_s: &[f64]) -> Self {
        let (median_s, _) = steps(time_s);
        let duration_s = time_s[time_s.len() - 1] - time_s[0];
        let step_s = median_s.max(duration_s / MOST_STEPS);
        let place: Vec<usize> =
            time_s.iter().map(|time| ((time - time_s[0]) / step_s).round() as usize).collect();
        let count = place[place.len() - 1] + 1;
        let mut window = vec![0.0; count];
        for &place in &place {
            window[place] = 0.5 - 0.5 * (TAU * (place as f64 + 0.5) / count as f64).cos();
        }
        let sum: f64 = window.iter().sum();
        let squares: f64 = window.iter().map(|w| w * w).sum();
        Self {
            place,
            window,
            line_hz: 1.0 / (count as f64 * step_s),
            amplitude: 2.0 / sum,
            density: 2.0 * step_s / squares,
        }
    }

    /// The squared size of the transform, from frequency 0 to half the rate.
    fn lines(&self, values: &[f64]) -> Vec<f64> {
        let mut cells = vec![(0.0, 0.0); self.window.len()];
        for (&place, value) in self.place.iter().zip(values) {
            cells[place].0 += value;
            cells[place].1 += 1.0;
        }
        let sum: f64 = self.window.iter().sum();
        let means: Vec<f64> =
            cells.iter().map(|(sum, count)| if *count > 0.0 { sum / count } else { 0.0 }).collect();
        let mean = means.iter().zip(&self.window).map(|(mean, w)| mean * w).sum::<f64>() / sum;
        let mut buffer: Vec<Complex<f64>> =
            means.iter().zip(&self.window).map(|(value, w)| Complex::new((value - mean) * w, 0.0)).collect();
        FftPlanner::new().plan_fft_forward(buffer.len()).process(&mut buffer);
        buffer[..=buffer.len() / 2].iter().map(Complex::norm_sqr).collect()
    }

    /// The peaks above the local level, the largest amplitude first.
    fn peaks(&self, lines: &[f64], of_input: &[(usize, f64)]) -> Vec<Peak> {
        let peak = |(line, above_level): (usize, f64)| {
            let (offset, power) = summit(lines, line);
            Peak {
                frequency_hz: (line as f64 + offset) * self.line_hz,
                amplitude: power.sqrt() * self.amplitude,
                above_level,
                in_input: of_input.iter().any(|(peak, _)| peak.abs_diff(line) <= LOBE),
            }
        };
        let mut peaks: Vec<Peak> = peak_lines(lines).into_iter().map(peak).collect();
        peaks.sort_by(|one, other| other.amplitude.total_cmp(&one.amplitude));
        peaks.truncate(MOST_PEAKS);
        peaks
    }

    /// The mean density over neighbouring lines, in equal steps of the logarithm.
    fn density(&self, lines: &[f64]) -> Vec<Density> {
        let last = lines.len() as f64;
        let point = |line: &usize| ((*line as f64).ln() / last.ln() * POINTS) as usize;
        let rows: Vec<usize> = (1..lines.len()).collect();
        rows.chunk_by(|one, other| point(one) == point(other))
            .map(|rows| {
                let count = rows.len() as f64;
                let power = rows.iter().map(|&row| lines[row]).sum::<f64>() / count;
                let centre = (rows[0] + rows[rows.len() - 1]) as f64 / 2.0;
                Density { frequency_hz: centre * self.line_hz, power: power * self.density }
            })
            .collect()
    }
}

/// The lines that stand above the local level, and how far.
fn peak_lines(lines: &[f64]) -> Vec<(usize, f64)> {
    let levels = Levels::of(lines);
    let count = lines.len() as f64;
    (LOBE + 1..lines.len().saturating_sub(1))
        .filter(|&line| lines[line] >= lines[line - 1] && lines[line] > lines[line + 1])
        .filter_map(|line| {
            let (level, freedom) = levels.at(line)?;
            let ratio = lines[line] / level;
            // A line over a level that was estimated from others is F-distributed with 2 and 2 `freedom` degrees.
            let chance = count * (-freedom * (ratio / freedom).ln_1p()).exp();
            (chance < LEVEL).then_some((line, ratio))
        })
        .collect()
}

/// The local level of a spectrum.
struct Levels {
    /// Centre of a band as the logarithm of its line, logarithm of the level, number of independent lines.
    bands: Vec<(f64, f64, f64)>,
}

impl Levels {
    fn of(lines: &[f64]) -> Self {
        let mut bands = Vec::new();
        let mut first = LOBE + 1;
        while first + BAND_LINES / 2 <= lines.len() {
            let end = (first + BAND_LINES).max((first as f64 * BAND_RATIO) as usize).min(lines.len());
            let level = median(&mut lines[first..end].to_vec()) / LN_2;
            if level > 0.0 {
                let centre = (first as f64 * (end - 1) as f64).sqrt().ln();
                // Neighbouring lines share most of a Hann window.
                bands.push((centre, level.ln(), (end - first) as f64 / 2.0));
            }
            first = end;
        }
        Self { bands }
    }

    /// Level at a line, and the number of independent lines that it was estimated from; None where there is none.
    fn at(&self, line: usize) -> Option<(f64, f64)> {
        let place = (line as f64).ln();
        let next = self.bands.partition_point(|band| band.0 < place);
        let after = self.bands.get(next).or(self.bands.last())?;
        let before = self.bands.get(next.saturating_sub(1))?;
        let way = after.0 - before.0;
        let share = if way > 0.0 { ((place - before.0) / way).clamp(0.0, 1.0) } else { 0.0 };
        let level = before.1 + share * (after.1 - before.1);
        Some((level.exp(), before.2.min(after.2)))
    }
}

/// The place of a peak between the lines, as an offset from its line, and its power: by a parabola through the logarithms.
fn summit(lines: &[f64], line: usize) -> (f64, f64) {
    let [a, b, c] =
        [lines[line - 1], lines[line], lines[line + 1]].map(|power| power.max(f64::MIN_POSITIVE).ln());
    let bend = a - 2.0 * b + c;
    let offset = if bend < 0.0 { (0.5 * (a - c) / bend).clamp(-0.5, 0.5) } else { 0.0 };
    (offset, (b - 0.25 * (a - c) * offset).exp())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::anatomy::alarms::alarms;
    use crate::synthetic::{Noise, times, triangles};

    fn no_input(rows: usize) -> Vec<f64> {
        (0..rows).map(|row| row as f64).collect()
    }

    #[test]
    fn a_tone_in_noise_is_found_with_frequency_and_amplitude_also_with_gaps_and_jitter() {
        let mut noise = Noise::new(1);
        let mut time_s: Vec<f64> = times(12_000, 0.01);
        time_s.retain(|t| !(40.0..55.0).contains(t));
        time_s.iter_mut().for_each(|t| *t += 0.002 * noise.white(1.0).clamp(-1.5, 1.5));
        let (frequency, amplitude) = (2.137, 0.05);
        let red = noise.autoregressive(time_s.len(), 0.95);
        let values: Vec<f64> =
            time_s.iter().zip(red).map(|(t, e)| amplitude * (TAU * frequency * t).sin() + 0.1 * e).collect();
        let input: Vec<f64> = time_s.iter().map(|&t| triangles(t, 20.0)).collect();
        let spectrum = Spectrum::of(&time_s, &values, &input);
        let peak = spectrum.peaks.first().expect("a peak");
        assert!((peak.frequency_hz - frequency).abs() < 1e-3, "{peak:?}");
        assert!((peak.amplitude / amplitude - 1.0).abs() < 0.15, "{peak:?}");
        assert!(!peak.in_input);
    }

    #[test]
    fn what_comes_back_less_than_five_times_is_no_tone() {
        let time_s = times(6000, 0.01);
        let mut noise = Noise::new(3);
        let wave = |periods: f64, noise: &mut Noise| -> Vec<f64> {
            time_s.iter().map(|t| (TAU * periods * t / 60.0).sin() + noise.white(0.05)).collect()
        };
        assert!(tones(&time_s, &wave(4.0, &mut noise), 2).iter().all(|hz| *hz >= 5.0 / 60.0));
        let seen = tones(&time_s, &wave(7.0, &mut noise), 1);
        assert!((seen[0] - 7.0 / 60.0).abs() < 2e-3, "{seen:?}");
    }

    #[test]
    fn a_line_of_the_excitation_is_marked() {
        let time_s = times(12_000, 0.01);
        let mut noise = Noise::new(2);
        let input: Vec<f64> = time_s.iter().map(|&t| triangles(t, 5.0)).collect();
        let values: Vec<f64> = input.iter().map(|u| 0.1 * u + noise.white(0.05)).collect();
        let spectrum = Spectrum::of(&time_s, &values, &input);
        assert!((spectrum.peaks[0].frequency_hz - 0.2).abs() < 1e-3);
        assert!(spectrum.peaks[0].in_input);
    }

    #[test]
    fn a_periodic_input_may_drive_its_lines_and_their_multiples_and_no_others() {
        let time_s = times(12_000, 0.01);
        let falling = |&t: &f64| (1.0 - t / 150.0) * (TAU * t / 6.0).sin();
        let lines = InputLines::of(&time_s, &time_s.iter().map(falling).collect::<Vec<f64>>());
        assert!(lines.have(1.0 / 6.0) && lines.have(0.51) && !lines.have(0.25) && !lines.have(0.41));
        // A swing now and then is none.
        let seldom = |&t: &f64| if t < 6.0 { triangles(t, 2.0) } else { 0.0 };
        let lines = InputLines::of(&time_s, &time_s.iter().map(seldom).collect::<Vec<f64>>());
        assert!((1..200).all(|i| !lines.have(0.05 * f64::from(i))), "{lines:?}");
    }

    #[test]
    fn residuals_without_a_tone_raise_an_alarm_in_at_most_3_of_100_runs_white_or_red() {
        for like in [0.0, 0.5, 0.9, 0.99] {
            let time_s = times(6000, 0.01);
            let share = alarms(300, |seed| {
                let values = Noise::new(seed).autoregressive(6000, like);
                !Spectrum::of(&time_s, &values, &no_input(6000)).peaks.is_empty()
            });
            assert!(share <= 0.03, "{like}: {share}");
        }
    }

    #[test]
    fn the_density_integrates_to_the_variance() {
        let time_s = times(8000, 0.02);
        let values = Noise::new(3).autoregressive(8000, 0.0);
        let spectrum = Spectrum::of(&time_s, &values, &no_input(8000));
        // White: the same everywhere, over 25 Hz.
        let high: Vec<f64> = spectrum
            .density
            .iter()
            .filter(|point| point.frequency_hz > 5.0)
            .map(|point| point.power * 25.0)
            .collect();
        let mean = high.iter().sum::<f64>() / high.len() as f64;
        assert!((mean - 1.0).abs() < 0.08, "{mean}");
    }
}
