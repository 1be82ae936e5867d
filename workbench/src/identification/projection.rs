//! The linear part: dead-zone slopes and offset, by projection.
//!
//! For a given u the output is offset + Σ sⱼ φⱼ(u), where φⱼ(u) is the way that u has gone inside segment j
//! (from dⱼ = j u_max/m to dⱼ₊₁). The slopes sⱼ are the partial sums of the weights, and sⱼ ≥ s_min > 0 makes every
//! result invertible. A row touches its own segment and all before it fully, so that ΦᵀΦ and Φᵀb need
//! only a few sums per segment: one pass over the rows, whatever m is.

use nalgebra::{DMatrix, DVector};

use super::nnls;

/// Ridge on the slopes, relative to the largest diagonal element of ΦᵀΦ: it decides only what no row does.
const RIDGE: f64 = 1e-10;

/// Where the rows lie in the segments.
pub struct Segments {
    /// Number of segments.
    count: usize,
    /// Length of a segment along u.
    width: f64,
    /// Segment of each row, and the way gone in it.
    places: Vec<(usize, f64)>,
}

/// The offset and the slopes of the segments.
pub struct Linear {
    /// Output at u = 0.
    pub offset: f64,
    /// Slope of each segment.
    pub slopes: Vec<f64>,
    /// Whether each of offset and slopes is free (not held at its bound).
    pub free: Vec<bool>,
}

impl Segments {
    /// The places of `u` among `count` segments from 0 to `u_max`.
    pub fn new(u: impl Iterator<Item = f64>, u_max: f64, count: usize) -> Self {
        let width = u_max / count as f64;
        let place = |u: f64| {
            let segment = ((u / width).max(0.0) as usize).min(count - 1);
            (segment, u - segment as f64 * width)
        };
        Self { count, width, places: u.map(place).collect() }
    }

    /// Segment of each row, and the way gone in it.
    pub fn places(&self) -> &[(usize, f64)] {
        &self.places
    }

    /// Segments and their common width along u.
    pub fn width(&self) -> f64 {
        self.width
    }

    /// Φᵀb: the moments of a column over the rows with offset (first) and slopes.
    pub fn moments(&self, column: impl Iterator<Item = f64>) -> DVector<f64> {
        let mut sums = vec![[0.0; 2]; self.count];
        for (&(segment, way), b) in self.places.iter().zip(column) {
            sums[segment][0] += b;
            sums[segment][1] += way * b;
        }
        let mut moments = DVector::zeros(self.count + 1);
        let mut beyond = 0.0;
        for (j, [plain, by_way]) in sums.iter().enumerate().rev() {
            moments[j + 1] = by_way + self.width * beyond;
            beyond += plain;
        }
        moments[0] = beyond;
        moments
    }

    /// ΦᵀΦ over offset and slopes.
    pub fn gram(&self) -> DMatrix<f64> {
        let mut sums = vec![[0.0; 3]; self.count];
        for &(segment, way) in &self.places {
            sums[segment][0] += 1.0;
            sums[segment][1] += way;
            sums[segment][2] += way * way;
        }
        let mut gram = DMatrix::zeros(self.count + 1, self.count + 1);
        let mut beyond = 0.0;
        for (j, [rows, way, way_squared]) in sums.iter().enumerate().rev() {
            // A row of this segment or beyond has gone all of the segments before.
            let shared = way + self.width * beyond;
            gram[(0, j + 1)] = shared;
            gram[(j + 1, j + 1)] = way_squared + self.width * self.width * beyond;
            for i in 0..j {
                gram[(i + 1, j + 1)] = self.width * shared;
            }
            beyond += rows;
        }
        gram[(0, 0)] = beyond;
        gram.fill_lower_triangle_with_upper_triangle();
        gram
    }

    /// The best offset and slopes, none below `least_slope`.
    pub fn fit(&self, outputs: &[f64], least_slope: f64) -> Linear {
        let mut gram = self.gram();
        let ridge = RIDGE * gram.diagonal().amax();
        // Counted from the least slope on, the slopes are non-negative.
        let mut least = DVector::from_element(self.count + 1, least_slope);
        least[0] = 0.0;
        let moment = self.moments(outputs.iter().copied()) - &gram * &least;
        for j in 0..=self.count {
            gram[(j, j)] += ridge;
        }
        let mut bounded = vec![true; self.count + 1];
        bounded[0] = false;
        let nnls::Solution { values, free } = nnls::solve(&gram, &moment, &bounded);
        let values = values + least;
        Linear { offset: values[0], slopes: values.as_slice()[1..].to_vec(), free }
    }

    /// offset + Σ sⱼ φⱼ(u) for every row.
    pub fn evaluate<'a>(&'a self, coefficients: &'a [f64]) -> impl Iterator<Item = f64> + 'a {
        let (offset, slopes) = (coefficients[0], &coefficients[1..]);
        let mut start = offset;
        let starts: Vec<f64> = slopes
            .iter()
            .map(|slope| {
                let this = start;
                start += slope * self.width;
                this
            })
            .collect();
        self.places.iter().map(move |&(segment, way)| starts[segment] + slopes[segment] * way)
    }
}

impl Linear {
    /// Offset and slopes in one list.
    pub fn coefficients(&self) -> Vec<f64> {
        std::iter::once(self.offset).chain(self.slopes.iter().copied()).collect()
    }

    /// The weights w of equation (14): the steps of the slopes.
    pub fn weights(&self) -> Vec<f64> {
        let mut before = 0.0;
        let step = |&slope: &f64| {
            let weight = slope - before;
            before = slope;
            weight
        };
        self.slopes.iter().map(step).collect()
    }
}
