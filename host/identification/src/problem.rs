//! The reduced least-squares problem: the nonlinear coordinates, the rest projected out.
//!
//! Variable projection (Golub and Pereyra 1973) with Kaufman's Jacobian (1975), whose gradient is
//! exact: the derivative of the model at fixed linear coefficients, less its part in the span of
//! the free linear columns. Coefficients that stand at their bound do not take part. At its end the
//! gradient by all unknowns together vanishes (a test): nothing is left for a joint polish.
//!
//! Levenberg-Marquardt needs of residuals r and Jacobian J only |r|, Jᵀr and JᵀJ. So a recording's
//! thousands of rows are summed up once (`sums`), and the kernel gets one row more than
//! coordinates, of the same norm and products: a square root of JᵀJ, and r turned the same way,
//! with all that lies across J in the last row.

use levenberg_marquardt::LeastSquaresProblem;
use nalgebra::{DMatrix, DVector, Dyn, Owned};

use super::coordinates::{bounded, unbounded};
use super::data::Data;
use super::inner::Inner;
use super::projection::{Grid, Linear};
use super::starts::Start;
use super::sums::{Line, Places, Sums, each};
use crate::progress::Part;

/// The least eigenvalue that JᵀJ of unit diagonal may have: the rounding of its sums.
pub const LEAST_EIGENVALUE: f64 = 1e-12;

/// The problem at a point.
pub struct Problem<'a, const K: usize> {
    data: &'a Data,
    evaluations: &'a Part<'a>,
    variables: DVector<f64>,
    point: Point<K>,
    residuals: DVector<f64>,
    jacobian: DMatrix<f64>,
}

/// The model at a point of the coordinates, and the sums over a recording that tell how good it is.
pub struct Point<const K: usize> {
    /// The coordinates, and whether the muscle is preconditioned.
    pub at: Start,
    /// Envelope and plays.
    pub inner: Inner,
    /// Where the segments of the memoryless stage lie.
    pub grid: Grid,
    /// The linear coefficients.
    pub linear: Linear,
    /// Sum of the squared residuals.
    pub cost: f64,
    sums: Sums<K>,
    /// ΦᵀΦ.
    gram: DMatrix<f64>,
    /// Φᵀr, model less measurement the residuals r.
    trace: DVector<f64>,
    /// The coefficients less those of the sums' reference.
    moved: DVector<f64>,
    /// Derivatives of the grid's origin and width by the coordinates.
    grid_by: [[f64; K]; 2],
}

/// Sums over the rows that count, with the derivatives of the model by the coordinates as the
/// columns of J.
struct Products {
    /// JᵀJ.
    own: DMatrix<f64>,
    /// ΦᵀJ, a column for each coordinate.
    mixed: DMatrix<f64>,
    /// Jᵀr.
    gradient: DVector<f64>,
}

/// The grid of the memoryless stage over all that u reaches on a cycle through the whole range, and
/// the derivatives of its origin and width by the coordinates. No knot lies at u = 0 but the
/// origin.
pub fn grid<const K: usize>(inner: &Inner, count: usize, coordinates: usize) -> (Grid, [[f64; K]; 2]) {
    let (lowest, highest) = inner.envelope.ends();
    let (first, back) = (inner.plays.loading(lowest), inner.plays.returning(lowest, highest));
    // With negative weights u comes back lower than it went.
    let ((low, low_by), (high, high_by)) =
        (if back.0 < first.0 { back } else { first }, inner.plays.loading(highest));
    let width = (high - low) / count as f64;
    // From the lowest u on; where u has both signs, half a segment to each side of 0.
    let segments_below = (low < 0.0 && high > 0.0).then(|| (-low / width - 0.5).round() + 0.5);
    let origin = segments_below.map_or(low, |segments| -segments * width);
    let mut by = [[0.0; K]; 2];
    for (i, c) in (coordinates - low_by.len()..coordinates).enumerate() {
        by[1][c] = (high_by[i] - low_by[i]) / count as f64;
        by[0][c] = segments_below.map_or(low_by[i], |segments| -segments * by[1][c]);
    }
    (Grid { count, origin, width }, by)
}

impl<const K: usize> Point<K> {
    /// Evaluates the model, the linear part at its best; `near` is nearly that, if anything is
    /// known.
    pub fn new(data: &Data, at: Start, near: Option<&Linear>) -> Self {
        let inner = Inner::new(&data.structure, &at.coordinates, data.span);
        let segments = data.structure.segments;
        let (grid, grid_by) = grid(&inner, segments, at.coordinates.len());
        let unknown = Linear::zero(segments, data.structure.added());
        let near = near.unwrap_or(&unknown);
        let sums = Sums::<K>::of((data, &at), &inner, (grid, near));
        let rest = sums.entry(Places::of(data).rest);
        let (gram, rest_moments) = (sums.gram(), sums.moments(&rest));
        let reference = DVector::from_vec(near.coefficients());
        let linear = Linear::fit(&gram, &(&rest_moments + &gram * &reference), segments, data.least_slope);
        let moved = DVector::from_vec(linear.coefficients()) - reference;
        let gram_moved = &gram * &moved;
        let cost = sums.product(&rest, &rest) + moved.dot(&gram_moved) - 2.0 * moved.dot(&rest_moments);
        let trace = gram_moved - rest_moments;
        Self { at, inner, grid, linear, cost: cost.max(0.0), sums, gram, trace, moved, grid_by }
    }

    /// Model less measurement for each row that counts. Output unit.
    pub fn residuals(&self, data: &Data) -> Vec<f64> {
        let rest = Places::of(data).rest;
        let mut residuals = Vec::with_capacity(data.count());
        let take = |_, entries: &[f64; K], _| residuals.push(-entries[rest]);
        each((data, &self.at), &self.inner, (self.grid, &self.linear), take);
        residuals
    }

    /// The model's derivatives by the coordinates at fixed linear coefficients.
    fn derivatives(&self) -> impl Iterator<Item = Line> {
        // y = offset + Σ_{j<i} sⱼ width + sᵢ (u - origin - i width) in segment i.
        let mut passed = 0.0;
        let by_width = |(i, slope): (usize, &f64)| {
            let this = passed - slope * i as f64;
            passed += slope;
            this
        };
        let slopes = &self.linear.slopes;
        let by_width: Vec<f64> = slopes.iter().enumerate().map(by_width).collect();
        let [origin_by, width_by] = &self.grid_by;
        (0..self.at.coordinates.len()).map(move |place| {
            let level =
                |(slope, by_width): (&f64, &f64)| by_width * width_by[place] - slope * origin_by[place];
            Line { place, slopes: slopes.clone(), levels: slopes.iter().zip(&by_width).map(level).collect() }
        })
    }

    /// The model's derivatives by all unknowns, the coordinates and then the linear coefficients.
    pub fn all_derivatives(&self) -> Vec<Line> {
        self.derivatives().chain(self.sums.columns()).collect()
    }

    /// Hands over the derivatives of each row that counts by the given ones of all unknowns along
    /// some directions, the columns of `turn`.
    pub fn derivatives_along(
        &self,
        data: &Data,
        unknowns: &[usize],
        turn: &DMatrix<f64>,
        mut take: impl FnMut(&[f64]),
    ) {
        let lines = self.all_derivatives();
        let one = self.sums.places().one;
        // In each segment, of each entry of a row.
        let of_entries = |segment: usize| {
            let mut by_entry = DMatrix::zeros(turn.ncols(), K);
            for (&unknown, turn) in unknowns.iter().zip(turn.row_iter()) {
                let Line { place, slopes, levels } = &lines[unknown];
                by_entry.column_mut(*place).axpy(slopes[segment], &turn.transpose(), 1.0);
                by_entry.column_mut(one).axpy(levels[segment], &turn.transpose(), 1.0);
            }
            by_entry
        };
        let by_entry: Vec<DMatrix<f64>> = (0..self.grid.count).map(of_entries).collect();
        let mut along = vec![0.0; turn.ncols()];
        let of_row = |segment: usize, entries: &[f64; K], _| {
            along.fill(0.0);
            for (entry, by) in entries.iter().zip(by_entry[segment].column_iter()) {
                along.iter_mut().zip(by.iter()).for_each(|(sum, by)| *sum += entry * by);
            }
            take(&along);
        };
        each((data, &self.at), &self.inner, (self.grid, &self.linear), of_row);
    }

    /// JᵀJ for the derivatives by all unknowns.
    pub fn information(&self) -> DMatrix<f64> {
        let lines = self.all_derivatives();
        DMatrix::from_fn(lines.len(), lines.len(), |i, j| self.sums.product(&lines[i], &lines[j]))
    }

    /// The sums of products of the model's derivatives by the coordinates, at fixed linear
    /// coefficients.
    fn products(&self) -> Products {
        let lines: Vec<Line> = self.derivatives().collect();
        let mixed: Vec<DVector<f64>> = lines.iter().map(|line| self.sums.moments(line)).collect();
        let rest = self.sums.entry(self.sums.places().rest);
        let gradient = |i: usize| mixed[i].dot(&self.moved) - self.sums.product(&lines[i], &rest);
        let upper = |i: usize, j: usize| if i <= j { self.sums.product(&lines[i], &lines[j]) } else { 0.0 };
        let mut own = DMatrix::from_fn(lines.len(), lines.len(), upper);
        own.fill_lower_triangle_with_upper_triangle();
        let gradient = DVector::from_fn(lines.len(), |i, _| gradient(i));
        Products { own, gradient, mixed: DMatrix::from_columns(&mixed) }
    }

    /// The few rows that stand for all: residuals and Jacobian, the free linear columns projected
    /// out.
    fn condense(&self) -> (DVector<f64>, DMatrix<f64>) {
        let Products { mut own, mixed, mut gradient } = self.products();
        let places: Vec<usize> = (0..self.linear.free.len()).filter(|&j| self.linear.free[j]).collect();
        let gram = self.gram.select_rows(&places).select_columns(&places);
        // Segments without a row make ΦᵀΦ singular; the pseudo-inverse leaves them out.
        if let Ok(inverse) = gram.pseudo_inverse(1e-12 * self.gram[(0, 0)]) {
            let projected = mixed.select_rows(&places).transpose() * inverse;
            own -= &projected * mixed.select_rows(&places);
            // The ridge leaves a trace of the linear columns in the residuals.
            gradient -= projected * self.trace.select_rows(&places);
        }
        // Unit diagonal first: the columns differ by orders of magnitude.
        let lengths = own.diagonal().map(|square| if square > 0.0 { square.sqrt() } else { 1.0 });
        let eigen = own.component_div(&(&lengths * lengths.transpose())).symmetric_eigen();
        // What is below the rounding of the sums is no direction at all.
        let roots = eigen.eigenvalues.map(|value| value.max(LEAST_EIGENVALUE).sqrt());
        let turned =
            (eigen.eigenvectors.transpose() * gradient.component_div(&lengths)).component_div(&roots);
        let factor = DMatrix::from_diagonal(&roots)
            * eigen.eigenvectors.transpose()
            * DMatrix::from_diagonal(&lengths);
        let across = (self.cost - turned.norm_squared()).max(0.0).sqrt();
        let count = lengths.len();
        (turned.push(across), factor.insert_row(count, 0.0))
    }
}

impl<'a, const K: usize> Problem<'a, K> {
    /// The problem at a start; each evaluation is a step of `evaluations`.
    pub fn new(data: &'a Data, start: &Start, evaluations: &'a Part<'a>) -> Self {
        let variables = unbounded(&data.coordinates, &start.coordinates);
        Self::at((data, evaluations), variables, start.preconditioned, None)
    }

    fn at(
        (data, evaluations): (&'a Data, &'a Part<'a>),
        variables: DVector<f64>,
        preconditioned: bool,
        near: Option<&Linear>,
    ) -> Self {
        let (coordinates, scales) = bounded(&data.coordinates, &variables);
        let point = Point::new(data, Start { coordinates, preconditioned }, near);
        let (residuals, factor) = point.condense();
        let jacobian = factor * DMatrix::from_diagonal(&DVector::from_vec(scales));
        evaluations.step();
        Self { data, evaluations, variables, point, residuals, jacobian }
    }

    /// The point where the problem stands.
    pub fn into_point(self) -> Point<K> {
        self.point
    }
}

impl<const K: usize> LeastSquaresProblem<f64, Dyn, Dyn> for Problem<'_, K> {
    type ResidualStorage = Owned<f64, Dyn>;
    type JacobianStorage = Owned<f64, Dyn, Dyn>;
    type ParameterStorage = Owned<f64, Dyn>;

    fn set_params(&mut self, variables: &DVector<f64>) {
        let Point { at, linear, .. } = &self.point;
        let context = (self.data, self.evaluations);
        *self = Self::at(context, variables.clone(), at.preconditioned, Some(linear));
    }

    fn params(&self) -> DVector<f64> {
        self.variables.clone()
    }

    fn residuals(&self) -> Option<DVector<f64>> {
        Some(self.residuals.clone())
    }

    fn jacobian(&self) -> Option<DMatrix<f64>> {
        Some(self.jacobian.clone())
    }
}
