//! The output over the input, by direction.
//!
//! The input's range is cut in equal parts; in each, the output of rising and of falling samples
//! has a mean. Hysteresis of any width is a loop of two such curves, and what goes with them is
//! what a model without rate, load or time can follow at best.

use crate::numbers::range;
use crate::turning::rising;
use crate::turning::turning_points;

/// Parts of the input's range: 5 % of it each, so that a loop of a few hundred samples has several
/// in each.
const PARTS: usize = 20;
/// A curve turns where it comes back by more than this share of its own range. Above the means'
/// scatter in recordings of a few cycles; a hill or a valley that is lower leaves an error of less
/// than a tenth of the stroke anyway.
const TURN: f64 = 0.1;

/// The output over the input. Output unit.
pub struct Shape {
    /// Mean of both directions in each part that has samples, from low to high input.
    middle: Vec<f64>,
    /// Mean of falling less rising samples, over the parts that have both; 0 where none has.
    pub opening: f64,
    /// Root mean square of half of that, part by part.
    pub half_width: f64,
    /// Share of the output's variance that goes with the two curves.
    pub explained: f64,
    /// Root mean square, over the samples, of the loop's middle less the rising curve that is
    /// nearest to it.
    pub not_rising: f64,
}

impl Shape {
    /// That of samples; `scored` are those that count.
    pub fn of(input: &[f64], output: &[f64], scored: &[bool]) -> Self {
        let samples: Vec<(usize, f64)> = {
            let of_scored: Vec<f64> =
                input.iter().zip(scored).filter(|(_, scored)| **scored).map(|(x, _)| *x).collect();
            let (low, high) = range(&of_scored);
            let part = |x: f64| ((x - low) / (high - low) * PARTS as f64) as usize;
            let directions = rising(input);
            let place = |row: usize| 2 * part(input[row]).min(PARTS - 1) + usize::from(directions[row]);
            (0..input.len()).filter(|&row| scored[row]).map(|row| (place(row), output[row])).collect()
        };
        let mut sums = [(0.0, 0.0); 2 * PARTS];
        for &(place, y) in &samples {
            sums[place].0 += 1.0;
            sums[place].1 += y;
        }
        let means = sums.map(|(count, sum)| (count > 0.0).then(|| sum / count));
        let pairs = || means.chunks_exact(2).map(|pair| (pair[0], pair[1]));
        let openings: Vec<f64> = pairs().filter_map(|(falling, rising)| Some(falling? - rising?)).collect();
        let middle: Vec<f64> = pairs()
            .filter_map(|pair| match pair {
                (Some(falling), Some(rising)) => Some(0.5 * (falling + rising)),
                (one, other) => one.or(other),
            })
            .collect();
        let counts = sums.chunks_exact(2).map(|pair| pair[0].0 + pair[1].0).filter(|count| *count > 0.0);
        let weighted: Vec<(f64, f64)> = counts.zip(middle.iter().copied()).collect();
        let count = samples.len() as f64;
        let mean = samples.iter().map(|(_, y)| y).sum::<f64>() / count;
        let (left, all) = samples.iter().fold((0.0, 0.0), |(left, all), &(place, y)| {
            (left + (y - means[place].unwrap_or(mean)).powi(2), all + (y - mean).powi(2))
        });
        let parts = openings.len().max(1) as f64;
        Self {
            not_rising: (distance_to_rising(&weighted) / count).sqrt(),
            middle,
            opening: openings.iter().sum::<f64>() / parts,
            half_width: 0.5 * (openings.iter().map(|opening| opening * opening).sum::<f64>() / parts).sqrt(),
            explained: 1.0 - left / all,
        }
    }

    /// Whether the middle of the loop falls from one end to the other.
    pub fn falls(&self) -> bool {
        self.turns().is_empty() && self.middle.last() < self.middle.first()
    }

    /// Whether the middle of the loop turns within the input's range: at a peak, or else at a
    /// trough first.
    pub fn turns_at_a_peak(&self) -> Option<bool> {
        self.turns().first().copied()
    }

    /// The turning points within the range, whether each is a peak.
    fn turns(&self) -> Vec<bool> {
        let (low, high) = range(&self.middle);
        let height = TURN * (high - low);
        let first = self.middle.first().copied().unwrap_or(0.0);
        // A curve that falls from its first part on has its first peak there, which is no turn.
        let is_within = |row: usize| (self.middle[row] - first).abs() > height;
        turning_points(&self.middle, height)
            .into_iter()
            .filter(|turn| is_within(turn.row))
            .map(|turn| turn.is_peak)
            .collect()
    }
}

/// The least sum of weighted squares between values and ones that never fall, for values with their
/// weights before them. By pooling neighbours that fall (Ayer et al. 1955).
fn distance_to_rising(values: &[(f64, f64)]) -> f64 {
    /// Neighbours with one value.
    struct Pool {
        weight: f64,
        mean: f64,
        squares: f64,
    }
    let mut pools: Vec<Pool> = Vec::new();
    for &(weight, mean) in values {
        let mut last = Pool { weight, mean, squares: 0.0 };
        while let Some(before) = pools.pop_if(|before| before.mean > last.mean) {
            let weight = before.weight + last.weight;
            let between = before.weight * last.weight / weight * (before.mean - last.mean).powi(2);
            let mean = (before.weight * before.mean + last.weight * last.mean) / weight;
            last = Pool { weight, mean, squares: before.squares + last.squares + between };
        }
        pools.push(last);
    }
    pools.iter().map(|pool| pool.squares).sum()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_rising_values_nearest_to_a_fall_are_its_mean() {
        let weighted = |values: &[f64]| -> Vec<(f64, f64)> { values.iter().map(|y| (1.0, *y)).collect() };
        assert_eq!(distance_to_rising(&weighted(&[1.0, 2.0, 2.0, 5.0])), 0.0);
        // 3, 2 and 1 become 2 each.
        assert!((distance_to_rising(&weighted(&[0.0, 3.0, 2.0, 1.0, 4.0])) - 2.0).abs() < 1e-12);
        // Twice a 3 and a 0 become 2 each.
        assert!((distance_to_rising(&[(2.0, 3.0), (1.0, 0.0)]) - 6.0).abs() < 1e-12);
    }
}
