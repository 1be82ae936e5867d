//! Chance on an axis that comes back to its values: how much of a residual's energy bins of the axis explain when they are
//! moved against each other in time.
//!
//! # Design
//! A circular shift keeps all of the residual's likeness and all of the axis's, and breaks only what they have to do with
//! each other. So the p-value is the rank of the observed share among those of shifted residuals, exact but for the seams.
//! A shift by whole periods of a regular excitation would break nothing: so each quarter of the shifted residual is shifted
//! in itself as well.
//!
//! The share beyond chance corrects the observed one by what is left over it: the rest (residual less bin means) is
//! shifted, and the share that the bins explain of it is what they explain of anything:
//! share = 1 - (1 - observed)/(1 - chance). For white rests that is the adjusted R².
//!
//! # Limits
//! An axis that never comes back explains a shifted residual as well as the one in its place (see `progressing`).

use std::ops::Range;

use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

use super::cells::Cells;

/// Number of random shifts.
const SHIFTS: usize = 99;
/// Parts that are shifted in themselves.
const PARTS: usize = 4;

/// Random circular shifts of a list of cells.
#[derive(Clone, Debug)]
pub struct Shifts(Vec<Shift>);

/// Runs of cells, one after the other the shifted list.
type Shift = Vec<Range<usize>>;

impl Shifts {
    /// Shifts of so many cells.
    pub fn new(cells: usize, seed: u64) -> Self {
        let mut random = ChaCha8Rng::seed_from_u64(seed);
        let mut below = |cells: usize| random.random_range(0..cells.max(1));
        let mut shift = || {
            let whole = rotated(0..cells, below(cells));
            let quarter = |part: usize| (part * cells / PARTS)..((part + 1) * cells / PARTS);
            let parts = (0..PARTS).flat_map(|part| {
                let part = quarter(part);
                let by = below(part.len());
                rotated(part, by)
            });
            parts.flat_map(|part| taken(&whole, part)).collect()
        };
        Self((0..SHIFTS).map(|_| shift()).collect())
    }

    /// The share of the energy that bins explain beyond chance, not below 0, and its p-value; `bin` has the bin of each
    /// cell, of `bins`.
    pub fn judge(&self, cells: &Cells, bin: &[u8], bins: usize) -> (f64, f64) {
        let weighted: Vec<f64> = cells.value.iter().zip(&cells.weight).map(|(e, w)| e * w).collect();
        let explained = |values: &[f64], shift: &Shift| explained(&cells.weight, values, bin, bins, shift);
        let observed = explained(&weighted, &rotated(0..bin.len(), 0));
        let as_much = self.0.iter().filter(|shift| explained(&weighted, shift) >= observed).count();

        let rest = rest(cells, &weighted, bin, bins);
        let left = cells.energy - observed;
        let chance = self.0.iter().map(|shift| explained(&rest, shift)).sum::<f64>() / SHIFTS as f64;
        // Of no rest, nothing is explained by chance.
        let share = if left > 1e-12 * cells.energy {
            1.0 - left / cells.energy / (1.0 - chance / left).max(f64::MIN_POSITIVE)
        } else {
            1.0
        };
        (share.max(0.0), (as_much + 1) as f64 / (SHIFTS + 1) as f64)
    }
}

/// A run of cells that begins `by` cells later, with its begin at its end.
fn rotated(run: Range<usize>, by: usize) -> Shift {
    let middle = run.start + by;
    vec![middle..run.end, run.start..middle]
}

/// Of the list that `runs` make, the cells at the places `at`.
fn taken(runs: &[Range<usize>], at: Range<usize>) -> Shift {
    let mut before = 0;
    let part = |run: &Range<usize>| {
        let (from, to) = (at.start.max(before), at.end.min(before + run.len()));
        let start = run.start + from.saturating_sub(before);
        before += run.len();
        (from < to).then(|| start..start + to - from)
    };
    runs.iter().filter_map(part).collect()
}

/// Sum over the bins of (sum of weighted values)²/(sum of weights), the values shifted.
fn explained(weight: &[f64], weighted: &[f64], bin: &[u8], bins: usize, shift: &Shift) -> f64 {
    let mut sums = vec![(0.0, 0.0); bins];
    let mut rest = bin;
    for run in shift {
        let (here, later) = rest.split_at(run.len());
        gather(&mut sums, &weight[run.clone()], &weighted[run.clone()], here);
        rest = later;
    }
    sums.iter().filter(|(_, weights)| *weights > 0.0).map(|(sum, weights)| sum * sum / weights).sum()
}

/// Adds weighted values and weights to the sums of their bins.
fn gather(sums: &mut [(f64, f64)], weight: &[f64], weighted: &[f64], bin: &[u8]) {
    for ((value, weight), &bin) in weighted.iter().zip(weight).zip(bin) {
        let (sum, weights) = &mut sums[usize::from(bin)];
        *sum += value;
        *weights += weight;
    }
}

/// Weighted values less their bin's mean.
fn rest(cells: &Cells, weighted: &[f64], bin: &[u8], bins: usize) -> Vec<f64> {
    let mut sums = vec![(0.0, 0.0); bins];
    gather(&mut sums, &cells.weight, weighted, bin);
    let mean = |bin: u8| sums[usize::from(bin)].0 / sums[usize::from(bin)].1;
    let less = |((value, weight), &bin): ((&f64, &f64), &u8)| value - weight * mean(bin);
    weighted.iter().zip(&cells.weight).zip(bin).map(less).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_shift_has_every_cell_once() {
        for cells in [1, 3, 4, 7, 100] {
            for shift in Shifts::new(cells, 1).0 {
                let mut moved: Vec<usize> = shift.into_iter().flatten().collect();
                moved.sort_unstable();
                assert_eq!(moved, (0..cells).collect::<Vec<_>>());
            }
        }
    }
}
