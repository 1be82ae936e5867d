//! Chance on an axis that comes back to its values: how much of a residual's energy bins of the axis explain when they are
//! moved against each other in time.
//!
//! # Design
//! A circular shift keeps all of the residual's likeness and all of the axis's, and breaks only what they have to do with
//! each other. So the p-value is the rank of the observed share among shifted ones, exact but for the seam.
//!
//! The share beyond chance corrects the observed one by what is left over it: the rest (residual less bin means) is
//! shifted, and the share that the bins explain of it is what they explain of anything:
//! share = 1 - (1 - observed)/(1 - chance). For white rests that is the adjusted R².
//!
//! # Limits
//! An axis that never comes back explains a shifted residual as well as the one in its place (see `progressing`). Of a very
//! regular excitation some shifts fall on whole periods and explain as much; then the p-value, not the share, is too
//! large.

use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

use super::cells::Cells;

/// Number of random shifts.
const SHIFTS: usize = 199;

/// Random circular shifts of so many cells.
#[derive(Clone, Debug)]
pub struct Shifts(Vec<usize>);

impl Shifts {
    /// Shifts by at least one cell.
    pub fn new(cells: usize, seed: u64) -> Self {
        let mut random = ChaCha8Rng::seed_from_u64(seed);
        Self((0..SHIFTS).map(|_| random.random_range(1..cells.max(2))).collect())
    }

    /// The share of the energy that bins explain beyond chance, not below 0, and its p-value; `bin` has the bin of each
    /// cell, of `bins`.
    pub fn judge(&self, cells: &Cells, bin: &[u8], bins: usize) -> (f64, f64) {
        let weighted: Vec<f64> = cells.value.iter().zip(&cells.weight).map(|(e, w)| e * w).collect();
        let explained = |values: &[f64], shift: usize| explained(&cells.weight, values, bin, bins, shift);
        let observed = explained(&weighted, 0);
        let as_much = self.0.iter().filter(|&&shift| explained(&weighted, shift) >= observed).count();

        let rest = rest(cells, &weighted, bin, bins);
        let left = cells.energy - observed;
        let chance = self.0.iter().map(|&shift| explained(&rest, shift)).sum::<f64>() / SHIFTS as f64;
        // Of no rest, nothing is explained by chance.
        let share = if left > 1e-12 * cells.energy {
            1.0 - left / cells.energy / (1.0 - chance / left).max(f64::MIN_POSITIVE)
        } else {
            1.0
        };
        (share.max(0.0), (as_much + 1) as f64 / (SHIFTS + 1) as f64)
    }
}

/// Sum over the bins of (sum of weighted values)²/(sum of weights), the values moved by `shift` cells.
fn explained(weight: &[f64], weighted: &[f64], bin: &[u8], bins: usize, shift: usize) -> f64 {
    let mut sums = vec![(0.0, 0.0); bins];
    let shift = shift % weight.len().max(1);
    let moved = weighted[shift..].iter().zip(&weight[shift..]).chain(weighted.iter().zip(weight));
    for ((value, weight), &bin) in moved.zip(bin) {
        let (sum, weights) = &mut sums[usize::from(bin)];
        *sum += value;
        *weights += weight;
    }
    sums.iter().filter(|(_, weights)| *weights > 0.0).map(|(sum, weights)| sum * sum / weights).sum()
}

/// Weighted values less their bin's mean.
fn rest(cells: &Cells, weighted: &[f64], bin: &[u8], bins: usize) -> Vec<f64> {
    let mut sums = vec![(0.0, 0.0); bins];
    for ((value, weight), &bin) in weighted.iter().zip(&cells.weight).zip(bin) {
        let (sum, weights) = &mut sums[usize::from(bin)];
        *sum += value;
        *weights += weight;
    }
    let mean = |bin: u8| sums[usize::from(bin)].0 / sums[usize::from(bin)].1;
    let less = |((value, weight), &bin): ((&f64, &f64), &u8)| value - weight * mean(bin);
    weighted.iter().zip(&cells.weight).zip(bin).map(less).collect()
}
