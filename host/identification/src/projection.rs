//! The linear part: offset, slopes of the memoryless stage, and added functions of the input, by
//! projection.
//!
//! For a given u the output is offset + Σ sⱼ φⱼ(u) + Σ δₖ Sₖ(x), where φⱼ(u) is the way that u has
//! gone inside segment j of equal width, and Sₖ are added functions, if the model has any. The
//! slopes are partial sums of the weights, and sⱼ ≥ s_min > 0 (and δₖ ≥ 0) makes every result
//! increasing.

use nalgebra::{DMatrix, DVector};

use super::nnls;

/// Ridge on the slopes, relative to the largest diagonal element of ΦᵀΦ: it decides only what no
/// row does.
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

impl Grid {
    /// Segment of u, and the way gone in it.
    #[inline(always)]
    pub fn place(&self, u: f64) -> (usize, f64) {
        let way = u - self.origin;
        let segment = ((way / self.width).max(0.0) as usize).min(self.count - 1);
        (segment, way - segment as f64 * self.width)
    }
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

impl Linear {
    /// All 0, for `segments` slopes and `added` functions.
    pub fn zero(segments: usize, added: usize) -> Self {
        Self::new(&vec![0.0; 1 + segments + added], segments, Vec::new())
    }

    /// The best coefficients from ΦᵀΦ and Φᵀy, no slope below `least_slope`, no factor of an added
    /// function below 0.
    pub fn fit(gram: &DMatrix<f64>, moment: &DVector<f64>, segments: usize, least_slope: f64) -> Self {
        // Counted from the least slope on, the slopes are non-negative.
        let count = moment.len();
        let least = |j: usize| if (1..=segments).contains(&j) { least_slope } else { 0.0 };
        let least = DVector::from_fn(count, |j, _| least(j));
        let ridge = DMatrix::identity(count, count) * (RIDGE * gram.diagonal().amax());
        let mut bounded = vec![true; count];
        bounded[0] = false;
        let nnls::Solution { values, free } =
            nnls::solve(&(gram + ridge), &(moment - gram * &least), &bounded);
        Self::new((values + least).as_slice(), segments, free)
    }

    /// The output, without added functions, where each segment of a width begins.
    pub fn at_knots(&self, width: f64) -> Vec<f64> {
        let mut next = self.offset;
        let begin = |slope: &f64| {
            let this = next;
            next += slope * width;
            this
        };
        self.slopes.iter().map(begin).collect()
    }

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
