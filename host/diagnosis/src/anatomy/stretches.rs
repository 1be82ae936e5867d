//! Where in a recording the residual is worst.
//!
//! # Design
//! The recording is cut into equally long windows of time; neighbouring windows that are clearly worse than the typical
//! one make a stretch. Beside each stands what the input does in it.

use serde::Serialize;

use super::Residual;
use super::motion::Motion;
use recording::numbers::{median, range, root_mean_square};

/// Windows of a recording.
const WINDOWS: f64 = 60.0;
/// A window is bad from that many times the median energy on (1.5² for the root mean square).
const BAD: f64 = 2.25;
/// The fewest rows of a window.
const LEAST_ROWS: usize = 10;
/// Stretches that are told.
const MOST: usize = 5;

/// A stretch in which the residual is large.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Stretch {
    /// Its begin. Unit: s.
    pub from_s: f64,
    /// Its end. Unit: s.
    pub to_s: f64,
    /// Root of the mean square residual in it. Output unit.
    pub rms: f64,
    /// Its share of the whole recording's energy.
    pub share: f64,
    /// The lowest input in it. Input unit.
    pub lowest_input: f64,
    /// The highest input in it. Input unit.
    pub highest_input: f64,
    /// The share of its rows in which the input is held.
    pub held_share: f64,
    /// The fastest rate of the input in it, up or down. Input unit/s.
    pub fastest_rate: f64,
}

/// The worst stretches, the one with most energy first; none where the residual is alike everywhere.
pub fn worst(residual: &Residual<'_>, motion: &Motion) -> Vec<Stretch> {
    let Residual { time_s, residual: values, input, .. } = *residual;
    let (Some(first_s), Some(last_s)) = (time_s.first(), time_s.last()) else { return Vec::new() };
    let window_s = (last_s - first_s) / WINDOWS;
    let window = |row: &usize| ((time_s[*row] - first_s) / window_s) as usize;
    let rows: Vec<usize> = (0..time_s.len()).collect();
    let energy = |rows: &[usize]| root_mean_square(&values[rows[0]..=rows[rows.len() - 1]]).powi(2);
    let windows: Vec<&[usize]> = rows
        .chunk_by(|one, other| window(one) == window(other))
        .filter(|rows| rows.len() >= LEAST_ROWS)
        .collect();
    let median = median(&mut windows.iter().map(|rows| energy(rows)).collect::<Vec<f64>>());
    let bad: Vec<&[usize]> = windows.into_iter().filter(|rows| energy(rows) > BAD * median).collect();
    let total: f64 = values.iter().map(|e| e * e).sum();
    let mut stretches: Vec<Stretch> = bad
        .chunk_by(|one, other| one[one.len() - 1] + 1 == other[0])
        .filter_map(|windows| {
            let (first, last) = (*windows.first()?.first()?, *windows.last()?.last()?);
            let rows = first..=last;
            let (lowest_input, highest_input) = range(&input[rows.clone()]);
            let rms = root_mean_square(&values[rows.clone()]);
            let count = (last - first + 1) as f64;
            let held = motion.direction[rows.clone()].iter().filter(|direction| **direction == 0.0).count();
            let rates = motion.rate[rows].iter().map(|rate| rate.abs());
            Some(Stretch {
                from_s: time_s[first],
                to_s: time_s[last],
                rms,
                share: rms * rms * count / total,
                lowest_input,
                highest_input,
                held_share: held as f64 / count,
                fastest_rate: rates.fold(0.0, f64::max),
            })
        })
        .collect();
    stretches.sort_by(|one, other| other.share.total_cmp(&one.share));
    stretches.truncate(MOST);
    stretches
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::synthetic::{Noise, times, triangles};

    #[test]
    fn the_loud_part_is_found_with_what_the_input_does_in_it() {
        let time_s = times(6000, 0.01);
        let mut noise = Noise::new(1);
        let input: Vec<f64> = time_s.iter().map(|&t| triangles(t, 20.0)).collect();
        let loud = |t: f64| if (24.0..27.0).contains(&t) { 0.5 } else { 0.05 };
        let values: Vec<f64> = time_s.iter().map(|&t| noise.white(loud(t))).collect();
        let residual = Residual {
            time_s: &time_s,
            residual: &values,
            input: &input,
            output: &input,
            load: None,
            temperature: None,
        };
        let found = worst(&residual, &Motion::of(&residual));
        let [Stretch { from_s, to_s, rms, share, lowest_input, highest_input, held_share, .. }] = found[..]
        else {
            panic!("{found:?}")
        };
        assert!((from_s - 24.0).abs() < 1.01 && (to_s - 27.0).abs() < 1.01, "{from_s} {to_s}");
        assert!((0.4..0.6).contains(&rms) && share > 0.8, "{rms} {share}");
        assert!((2.3..2.5).contains(&lowest_input) && (4.1..4.3).contains(&highest_input));
        assert_eq!(held_share, 0.0);
    }

    #[test]
    fn an_even_residual_has_no_worst_stretch() {
        let time_s = times(6000, 0.01);
        let values: Vec<f64> = Noise::new(2).autoregressive(6000, 0.0);
        let residual = Residual {
            time_s: &time_s,
            residual: &values,
            input: &time_s,
            output: &time_s,
            load: None,
            temperature: None,
        };
        assert_eq!(worst(&residual, &Motion::of(&residual)), []);
    }
}
