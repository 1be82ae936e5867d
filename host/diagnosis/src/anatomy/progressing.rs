//! Chance on an axis that goes on and on (time, travel, a temperature that only rises): how much slower a residual moves
//! along it than its own neighbouring frequencies let expect.
//!
//! # Design
//! No shift can break the tie of a residual with such an axis, but what moves with it is slow: the first two cosines over
//! the axis, cos(k π x), x from 0 to 1. Energy in them is compared with that in the next eight, orthogonalised one after the
//! other: an F-test, exact where the residual's spectrum is flat over them, which it is when its memory is short against
//! the recording (a fiftieth).
//!
//! # Limits
//! A residual with a longer memory raises false alarms; a step at some place is found, a short bump is not.

use std::f64::consts::PI;

use super::cells::Cells;
use super::distribution::f_tail;
use recording::numbers::range;

/// The most cosines, and how many of them to one that counts as slow.
const MOST: usize = 10;
const RATIO: usize = 5;
/// The fewest cosines that a test can be made of.
const LEAST: usize = 4;
/// What is left of a cosine after orthogonalisation must not be less than this share of it.
const NEW: f64 = 1e-6;

/// The share of the energy that slow movement along the axis explains beyond chance, not below 0, and its p-value; 0 and 1
/// where the axis has too few different values. `values` has the axis's value of each cell.
pub fn judge(cells: &Cells, values: &[f64]) -> (f64, f64) {
    let coefficients = coefficients(cells, values, MOST.min(different(values).saturating_sub(1)));
    if coefficients.len() < LEAST {
        return (0.0, 1.0);
    }
    let slow = (coefficients.len() / RATIO).max(1);
    let mean = |squares: &[f64]| squares.iter().sum::<f64>() / squares.len() as f64;
    let (low, high) = coefficients.split_at(slow);
    let (low_mean, high_mean) = (mean(low), mean(high).max(1e-12 * cells.energy).max(f64::MIN_POSITIVE));
    let share = (slow as f64 * (low_mean - high_mean) / cells.energy.max(f64::MIN_POSITIVE)).max(0.0);
    (share, f_tail(low_mean / high_mean, slow as f64, high.len() as f64))
}

/// Number of different values that come one after the other.
fn different(values: &[f64]) -> usize {
    values.windows(2).filter(|pair| pair[0] != pair[1]).count() + 1
}

/// The squares of the residual's coefficients on the cosines.
fn coefficients(cells: &Cells, values: &[f64], count: usize) -> Vec<f64> {
    let (low, high) = range(values);
    let root: Vec<f64> = cells.weight.iter().map(|weight| weight.sqrt()).collect();
    let target: Vec<f64> = cells.value.iter().zip(&root).map(|(e, root)| e * root).collect();
    let mut basis: Vec<Vec<f64>> = Vec::new();
    let mut squares = Vec::new();
    for k in 0..=count {
        let cosine =
            |(value, root): (&f64, &f64)| root * (k as f64 * PI * (value - low) / (high - low)).cos();
        let mut column: Vec<f64> = values.iter().zip(&root).map(cosine).collect();
        let before = dot(&column, &column);
        // Twice is enough (Kahan and Parlett).
        for _ in 0..2 {
            for other in &basis {
                let common = dot(&column, other);
                column.iter_mut().zip(other).for_each(|(c, o)| *c -= common * o);
            }
        }
        let after = dot(&column, &column);
        if after <= NEW * before {
            continue;
        }
        column.iter_mut().for_each(|c| *c /= after.sqrt());
        if k > 0 {
            squares.push(dot(&column, &target).powi(2));
        }
        basis.push(column);
    }
    squares
}

fn dot(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}
