//! The residual over each axis: its mean in bins, with its uncertainty, and the share of the energy explained.
//!
//! # Design
//! Bins hold equally many rows, so that their means are equally sure. An axis that follows time (|correlation| above 0.9)
//! is judged as one that goes on and on (`progressing`), any other as one that recurs (`recurring`). What chance explains
//! as well at a level of 5 % is no share: it is 0.

use std::fmt;

use serde::Serialize;

use super::Residual;
use super::cells::Cells;
use super::motion::Motion;
use super::progressing;
use super::recurring::Shifts;
use identification::autocorrelation::inflation;

/// Bins of an axis, where it has as many values.
const BINS: usize = 16;
/// An axis with so high a correlation with time goes on and on.
const FOLLOWS_TIME: f64 = 0.9;
/// The level up to which a p-value is beyond chance.
pub const LEVEL: f64 = 0.05;

/// What a residual can be looked at against.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize)]
#[serde(rename_all = "snake_case")]
#[allow(missing_docs, reason = "`quantity` says what they are")]
pub enum Axis {
    Time,
    Input,
    Output,
    Direction,
    Rate,
    SinceChange,
    Travel,
    Cycle,
    Load,
    Temperature,
}

impl Axis {
    /// The quantity, in words.
    pub fn quantity(self) -> &'static str {
        match self {
            Self::Time => "time",
            Self::Input => "input",
            Self::Output => "output",
            Self::Direction => "direction of the input",
            Self::Rate => "rate of the input",
            Self::SinceChange => "time since the last change of the input",
            Self::Travel => "travel of the output",
            Self::Cycle => "number of the cycle",
            Self::Load => "load",
            Self::Temperature => "temperature",
        }
    }
}

impl fmt::Display for Axis {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.quantity())
    }
}

/// The mean residual over an axis.
#[derive(Clone, Debug, Serialize)]
pub struct AxisMean {
    /// The axis.
    pub axis: Axis,
    /// The share of the residual's energy (about its mean) that the axis explains beyond chance, from 0 to 1.
    pub share: f64,
    /// How often chance explains as much.
    pub p_value: f64,
    /// The means, from the lowest values of the axis to the highest; at least two.
    pub bins: Vec<Bin>,
}

/// The mean residual where an axis has neighbouring values.
#[derive(Clone, Copy, Debug, Serialize)]
pub struct Bin {
    /// The mean value of the axis. Unit: that of the axis.
    pub at: f64,
    /// The mean residual, less that of the whole recording. Output unit.
    pub mean: f64,
    /// Standard error of the mean, the likeness of neighbouring rows considered. Output unit.
    pub standard_error: f64,
    /// Rows in it.
    pub rows: usize,
}

/// Looks at a residual against every axis that varies.
pub fn axes(residual: &Residual<'_>, motion: &Motion, cells: &Cells, seed: u64) -> Vec<AxisMean> {
    let shifts = Shifts::new(cells.value.len(), seed);
    let time = cells.pick(residual.time_s);
    let columns = [
        (Axis::Time, Some(residual.time_s)),
        (Axis::Input, Some(residual.input)),
        (Axis::Output, Some(residual.output)),
        (Axis::Direction, Some(&motion.direction[..])),
        (Axis::Rate, Some(&motion.rate[..])),
        (Axis::SinceChange, Some(&motion.since_change_s[..])),
        (Axis::Travel, Some(&motion.travel[..])),
        (Axis::Cycle, Some(&motion.cycle[..])),
        (Axis::Load, residual.load),
        (Axis::Temperature, residual.temperature),
    ];
    let look = |(axis, column): (Axis, Option<&[f64]>)| {
        let values = cells.pick(column?);
        let binned = Binned::of(&values);
        if binned.count < 2 {
            return None;
        }
        let (share, p_value) = if follows_time(&time, &values) {
            progressing::judge(cells, &values)
        } else {
            shifts.judge(cells, &binned.bin, binned.count)
        };
        let share = if p_value <= LEVEL { share } else { 0.0 };
        Some(AxisMean { axis, share, p_value, bins: binned.means(cells, &values) })
    };
    columns.into_iter().filter_map(look).collect()
}

/// The bins of an axis.
struct Binned {
    /// The bin of each cell.
    bin: Vec<u8>,
    count: usize,
}

impl Binned {
    /// At most [`BINS`] bins of equally many cells; equal values are in one bin.
    fn of(values: &[f64]) -> Self {
        let mut sorted = values.to_vec();
        sorted.sort_by(f64::total_cmp);
        let mut edges: Vec<f64> = (1..BINS).map(|k| sorted[k * sorted.len() / BINS]).collect();
        edges.dedup();
        edges.retain(|edge| *edge > sorted[0]);
        let bin = values.iter().map(|value| edges.partition_point(|edge| edge <= value) as u8).collect();
        Self { bin, count: edges.len() + 1 }
    }

    fn means(&self, cells: &Cells, values: &[f64]) -> Vec<Bin> {
        let mut sums = vec![(0.0, 0.0, 0.0); self.count];
        let weighted = || cells.value.iter().zip(&cells.weight).zip(values).zip(&self.bin);
        for (((e, weight), value), &bin) in weighted() {
            let (weights, sum, at) = &mut sums[usize::from(bin)];
            *weights += weight;
            *sum += weight * e;
            *at += weight * value;
        }
        let mean = |bin: u8| sums[usize::from(bin)].1 / sums[usize::from(bin)].0;
        let rest: Vec<f64> = cells.value.iter().zip(&self.bin).map(|(e, &bin)| e - mean(bin)).collect();
        let mut squares = vec![0.0; self.count];
        let mut counts = vec![0.0; self.count];
        for (e, &bin) in rest.iter().zip(&self.bin) {
            squares[usize::from(bin)] += e * e;
            counts[usize::from(bin)] += 1.0;
        }
        let inflation = inflation(&rest);
        sums.iter()
            .zip(squares.iter().zip(&counts))
            .map(|(&(weights, sum, at), (square, count))| Bin {
                at: at / weights,
                mean: sum / weights,
                standard_error: (inflation * square).sqrt() / count,
                rows: weights as usize,
            })
            .collect()
    }
}

/// The correlation of two lists; 0 where one is constant.
fn correlation(a: &[f64], b: &[f64]) -> f64 {
    let count = a.len() as f64;
    let (mean_a, mean_b) = (a.iter().sum::<f64>() / count, b.iter().sum::<f64>() / count);
    let sum = |of: &dyn Fn(f64, f64) -> f64| -> f64 {
        a.iter().zip(b).map(|(a, b)| of(a - mean_a, b - mean_b)).sum()
    };
    let scale = (sum(&|a, _| a * a) * sum(&|_, b| b * b)).sqrt();
    if scale > 0.0 { sum(&|a, b| a * b) / scale } else { 0.0 }
}

/// Whether a column follows time so closely that no shift can tell the two apart.
pub fn follows_time(time_s: &[f64], column: &[f64]) -> bool {
    correlation(column, time_s).abs() > FOLLOWS_TIME
}
