//! The linear part: offset, slopes of the memoryless stage, and added functions of the input, by projection.
//!
//! For a given u the output is offset + Σ sⱼ φⱼ(u) + Σ δₖ Sₖ(x), where φⱼ(u) is the way that u has gone inside
//! segment j of equal width, and Sₖ are added functions, if the model has any. The slopes are partial sums of the
//! weights, and sⱼ ≥ s_min > 0 (and δₖ ≥ 0) makes every result increasing. A row touches its own segment and all
//! before it fully, so that the segments' part of ΦᵀΦ and Φᵀb needs only a few sums per segment: one pass over the
//! rows, whatever their number is.

use std::cmp::Ordering;

use nalgebra::{Const, DMatrix, DVector, Dyn, OMatrix};

use super::nnls;

/// Ridge on the slopes, relative to the largest diagonal element of ΦᵀΦ: it decides only what no row does.
const RIDGE: f64 = 1e-10;

/// Where the segments lie along u.
#[derive(Clone, Copy, Debug)]
pub struct Grid {
    /// Number of segments.
    pub count: usize,
    /// Where the first one begins; it goes on below.
    pub origin: f64,
    /// Their length.
    pub width: f64,
}

/// The columns Φ at the rows that count.
pub struct Columns<'a> {
    /// Where the segments lie.
    pub grid: Grid,
    /// Segment of each row, and the way gone in it.
    places: Vec<(usize, f64)>,
    /// The added functions: a value a row each.
    added: &'a [Vec<f64>],
    /// ΦᵀΦ.
    pub gram: DMatrix<f64>,
}

/// The linear coefficients.
pub struct Linear {
    /// Output where the grid begins.
    pub offset: f64,
    /// Slope of each segment.
    pub slopes: Vec<f64>,
    /// Factors of the added functions.
    pub rises: Vec<f64>,
    /// Whether each of offset, slopes and factors is free (not held at its bound).
    pub free: Vec<bool>,
}

impl<'a> Columns<'a> {
    /// The columns for u at the rows that count.
    pub fn new(u: impl Iterator<Item = f64>, grid: Grid, added: &'a [Vec<f64>]) -> Self {
        let place = |u: f64| {
            let way = u - grid.origin;
            let segment = ((way / grid.width).max(0.0) as usize).min(grid.count - 1);
            (segment, way - segment as f64 * grid.width)
        };
        let gram = DMatrix::zeros(0, 0);
        let mut columns = Self { grid, places: u.map(place).collect(), added, gram };
        columns.gram = columns.products();
        columns
    }

    /// Segment of each row, and the way gone in it.
    pub fn places(&self) -> &[(usize, f64)] {
        &self.places
    }

    /// The value of a column at a row.
    pub fn value(&self, row: usize, column: usize) -> f64 {
        let (place, way) = self.places[row];
        match column {
            0 => 1.0,
            _ if column > self.grid.count => self.added[column - self.grid.count - 1][row],
            // The way gone in a segment: all of those before the row's own.
            _ => match (column - 1).cmp(&place) {
                Ordering::Less => self.grid.width,
                Ordering::Equal => way,
                Ordering::Greater => 0.0,
            },
        }
    }

    fn count(&self) -> usize {
        1 + self.grid.count + self.added.len()
    }

    /// ΦᵀB: the moments of the columns of B, given row by row.
    pub fn moments<const N: usize>(
        &self,
        rows: impl Iterator<Item = [f64; N]> + Clone,
    ) -> OMatrix<f64, Dyn, Const<N>> {
        let mut sums = vec![[[0.0; 2]; N]; self.grid.count];
        for (&(segment, way), row) in self.places.iter().zip(rows.clone()) {
            for ([plain, by_way], b) in sums[segment].iter_mut().zip(row) {
                *plain += b;
                *by_way += way * b;
            }
        }
        let mut moments = OMatrix::<f64, Dyn, Const<N>>::zeros(self.count());
        for c in 0..N {
            let mut beyond = 0.0;
            for (j, columns) in sums.iter().enumerate().rev() {
                let [plain, by_way] = columns[c];
                moments[(j + 1, c)] = by_way + self.grid.width * beyond;
                beyond += plain;
            }
            moments[(0, c)] = beyond;
        }
        for (k, column) in self.added.iter().enumerate() {
            for (value, row) in column.iter().zip(rows.clone()) {
                for (c, b) in row.into_iter().enumerate() {
                    moments[(1 + self.grid.count + k, c)] += value * b;
                }
            }
        }
        moments
    }

    fn products(&self) -> DMatrix<f64> {
        let Grid { count, width, .. } = self.grid;
        let mut sums = vec![[0.0; 3]; count];
        for &(segment, way) in &self.places {
            sums[segment][0] += 1.0;
            sums[segment][1] += way;
            sums[segment][2] += way * way;
        }
        let mut gram = DMatrix::zeros(self.count(), self.count());
        let mut beyond = 0.0;
        for (j, [rows, way, way_squared]) in sums.iter().enumerate().rev() {
            // A row of this segment or beyond has gone all of the segments before.
            let shared = way + width * beyond;
            gram[(0, j + 1)] = shared;
            gram[(j + 1, j + 1)] = way_squared + width * width * beyond;
            for i in 0..j {
                gram[(i + 1, j + 1)] = width * shared;
            }
            beyond += rows;
        }
        gram[(0, 0)] = beyond;
        for (k, column) in self.added.iter().enumerate() {
            let moments = self.moments(column.iter().map(|&value| [value]));
            gram.set_column(1 + count + k, &moments.column(0));
        }
        gram.fill_lower_triangle_with_upper_triangle();
        gram
    }

    /// The best coefficients, no slope below `least_slope`, no factor of an added function below 0.
    pub fn fit(&self, outputs: &[f64], least_slope: f64) -> Linear {
        // Counted from the least slope on, the slopes are non-negative.
        let slopes = 1..=self.grid.count;
        let least =
            DVector::from_fn(self.count(), |j, _| if slopes.contains(&j) { least_slope } else { 0.0 });
        let moment = self.moments(outputs.iter().map(|&y| [y])).column(0) - &self.gram * &least;
        let ridge = DMatrix::identity(self.count(), self.count()) * (RIDGE * self.gram.diagonal().amax());
        let mut bounded = vec![true; self.count()];
        bounded[0] = false;
        let nnls::Solution { values, free } = nnls::solve(&(&self.gram + ridge), &moment, &bounded);
        Linear::new((values + least).as_slice(), self.grid.count, free)
    }

    /// offset + Σ sⱼ φⱼ(u) + Σ δₖ Sₖ for every row.
    pub fn evaluate(&self, linear: &Linear) -> Vec<f64> {
        let mut start = linear.offset;
        let starts: Vec<f64> = linear
            .slopes
            .iter()
            .map(|slope| {
                let this = start;
                start += slope * self.grid.width;
                this
            })
            .collect();
        let stage = |&(segment, way): &(usize, f64)| starts[segment] + linear.slopes[segment] * way;
        let mut outputs: Vec<f64> = self.places.iter().map(stage).collect();
        for (rise, column) in linear.rises.iter().zip(self.added) {
            for (output, value) in outputs.iter_mut().zip(column) {
                *output += rise * value;
            }
        }
        outputs
    }
}

impl Linear {
    /// The coefficients of a list: offset, slopes of `segments`, factors of the added functions.
    pub fn new(list: &[f64], segments: usize, free: Vec<bool>) -> Self {
        let (slopes, rises) = list[1..].split_at(segments);
        Self { offset: list[0], slopes: slopes.to_vec(), rises: rises.to_vec(), free }
    }

    /// All in one list.
    pub fn coefficients(&self) -> Vec<f64> {
        std::iter::once(self.offset).chain(self.slopes.iter().chain(&self.rises).copied()).collect()
    }
}
