//! The reduced least-squares problem: the nonlinear coordinates, the rest projected out.
//!
//! Variable projection (Golub and Pereyra 1973) with Kaufman's Jacobian (1975), whose gradient is exact: the
//! derivative of the model at fixed linear coefficients, less its part in the span of the free linear
//! columns. Coefficients that stand at their bound do not take part. At its end the gradient by all unknowns together
//! vanishes (a test): nothing is left for a joint polish.
//!
//! Levenberg-Marquardt needs of residuals r and Jacobian J only |r|, Jᵀr and JᵀJ. So a recording's thousands
//! of rows are summed up once, and the kernel gets one row more than coordinates, of the same norm and products: a
//! square root of JᵀJ, and r turned the same way, with all that lies across J in the last row.
//!
//! `K` is the capacity for coordinates: a few sizes are compiled, and loops over rows have fixed lengths.

use levenberg_marquardt::LeastSquaresProblem;
use nalgebra::{DMatrix, DVector, Dyn, Owned};

use super::coordinates::{bounded, unbounded};
use super::data::Data;
use super::inner::{Inner, Sample};
use super::projection::{Columns, Grid, Linear};
use super::starts::Start;

/// The least eigenvalue that JᵀJ of unit diagonal may have: the rounding of its sums.
pub const LEAST_EIGENVALUE: f64 = 1e-12;

/// The problem at a point.
pub struct Problem<'a, const K: usize> {
    data: &'a Data,
    variables: DVector<f64>,
    point: Point<'a, K>,
    residuals: DVector<f64>,
    jacobian: DMatrix<f64>,
}

/// The model and its residuals at a point of the coordinates.
pub struct Point<'a, const K: usize> {
    /// The coordinates, and whether the muscle is preconditioned.
    pub at: Start,
    /// Envelope and plays.
    pub inner: Inner,
    /// u at the rows that count, and its derivatives.
    samples: Vec<Sample<K>>,
    /// The linear columns.
    pub columns: Columns<'a>,
    /// Their coefficients.
    pub linear: Linear,
    /// Model less measurement for each row that counts. Output unit.
    pub residuals: Vec<f64>,
    /// Derivatives of the grid's origin and width by the coordinates.
    grid_by: [[f64; K]; 2],
}

/// Sums over the rows that count, with the derivatives of the model by the coordinates as the columns of J.
struct Products {
    /// JᵀJ.
    own: DMatrix<f64>,
    /// ΦᵀJ, a row for each linear column.
    mixed: DMatrix<f64>,
    /// Jᵀr.
    gradient: DVector<f64>,
}

/// The grid of the memoryless stage over all that u reaches on a cycle through the whole range, and the derivatives of
/// its origin and width by the coordinates. No knot lies at u = 0 but the origin.
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

impl<'a, const K: usize> Point<'a, K> {
    /// Evaluates the model, the linear part at its best.
    pub fn new(data: &'a Data, at: Start) -> Self {
        let inner = Inner::new(&data.structure, &at.coordinates, data.span);
        let all = inner.simulate(&data.drive, at.preconditioned);
        let samples: Vec<Sample<K>> = data.rows.iter().map(|&row| all[row]).collect();
        let (grid, grid_by) = grid(&inner, data.structure.segments, at.coordinates.len());
        let columns = Columns::new(samples.iter().map(|sample| sample.u), grid, &data.added);
        let linear = columns.fit(&data.outputs, data.least_slope);
        let model = columns.evaluate(&linear);
        let residuals = model.iter().zip(&data.outputs).map(|(model, measured)| model - measured).collect();
        Self { at, inner, samples, columns, linear, residuals, grid_by }
    }

    /// Sum of the squared residuals.
    pub fn cost(&self) -> f64 {
        self.residuals.iter().map(|residual| residual * residual).sum()
    }

    /// The model's derivatives by the coordinates at fixed linear coefficients, for each row that counts.
    fn derivatives(&self) -> impl Iterator<Item = [f64; K]> + Clone {
        // y = offset + Σ_{j<i} sⱼ width + sᵢ (u - origin - i width) in segment i.
        let mut passed = 0.0;
        let by_width = |(i, slope): (usize, &f64)| {
            let this = passed - slope * i as f64;
            passed += slope;
            this
        };
        let by_width: Vec<f64> = self.linear.slopes.iter().enumerate().map(by_width).collect();
        self.samples.iter().zip(self.columns.places()).map(move |(sample, &(segment, _))| {
            let (slope, by_width) = (self.linear.slopes[segment], by_width[segment]);
            let [origin_by, width_by] = &self.grid_by;
            std::array::from_fn(|c| slope * (sample.by[c] - origin_by[c]) + by_width * width_by[c])
        })
    }

    /// The Jacobian at all unknowns, the coordinates and then the linear coefficients, a row each; a column for each
    /// row of the recording that counts.
    pub fn jacobian(&self) -> DMatrix<f64> {
        let (count, linear) = (self.at.coordinates.len(), self.linear.free.len());
        let mut jacobian = DMatrix::zeros(count + linear, self.residuals.len());
        for (row, derivatives) in self.derivatives().enumerate() {
            let derivatives = derivatives[..count].iter().copied();
            let columns = (0..linear).map(|column| self.columns.value(row, column));
            jacobian.column_mut(row).copy_from_slice(&derivatives.chain(columns).collect::<Vec<f64>>());
        }
        jacobian
    }

    /// The sums of products of the model's derivatives by the coordinates, at fixed linear coefficients.
    fn products(&self) -> Products {
        let derivatives = self.derivatives();
        let mixed = self.columns.moments(derivatives.clone());
        let mut own = [[0.0; K]; K];
        let mut gradient = [0.0; K];
        for (derivatives, residual) in derivatives.zip(&self.residuals) {
            for (c, derivative) in derivatives.iter().enumerate() {
                gradient[c] += derivative * residual;
                for (sum, other) in own[c].iter_mut().zip(&derivatives) {
                    *sum += derivative * other;
                }
            }
        }
        let count = self.at.coordinates.len();
        Products {
            own: DMatrix::from_fn(count, count, |i, j| own[i][j]),
            mixed: DMatrix::from_fn(mixed.nrows(), count, |i, j| mixed[(i, j)]),
            gradient: DVector::from_fn(count, |i, _| gradient[i]),
        }
    }

    /// The few rows that stand for all: residuals and Jacobian, the free linear columns projected out.
    fn condense(&self) -> (DVector<f64>, DMatrix<f64>) {
        let Products { mut own, mixed, mut gradient } = self.products();
        let places: Vec<usize> = (0..self.linear.free.len()).filter(|&j| self.linear.free[j]).collect();
        let gram = self.columns.gram.select_rows(&places).select_columns(&places);
        // Segments without a row make ΦᵀΦ singular; the pseudo-inverse leaves them out.
        if let Ok(inverse) = gram.pseudo_inverse(1e-12 * self.residuals.len() as f64) {
            let projected = mixed.select_rows(&places).transpose() * inverse;
            own -= &projected * mixed.select_rows(&places);
            // The ridge leaves a trace of the linear columns in the residuals.
            let trace = self.columns.moments(self.residuals.iter().map(|&residual| [residual]));
            gradient -= projected * trace.column(0).select_rows(&places);
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
        let across = (self.cost() - turned.norm_squared()).max(0.0).sqrt();
        let count = lengths.len();
        (turned.push(across), factor.insert_row(count, 0.0))
    }
}

impl<'a, const K: usize> Problem<'a, K> {
    /// The problem at a start.
    pub fn new(data: &'a Data, start: &Start) -> Self {
        Self::at(data, unbounded(&data.coordinates, &start.coordinates), start.preconditioned)
    }

    fn at(data: &'a Data, variables: DVector<f64>, preconditioned: bool) -> Self {
        let (coordinates, scales) = bounded(&data.coordinates, &variables);
        let point = Point::new(data, Start { coordinates, preconditioned });
        let (residuals, factor) = point.condense();
        let jacobian = factor * DMatrix::from_diagonal(&DVector::from_vec(scales));
        Self { data, variables, point, residuals, jacobian }
    }

    /// The point where the problem stands.
    pub fn into_point(self) -> Point<'a, K> {
        self.point
    }
}

impl<const K: usize> LeastSquaresProblem<f64, Dyn, Dyn> for Problem<'_, K> {
    type ResidualStorage = Owned<f64, Dyn>;
    type JacobianStorage = Owned<f64, Dyn, Dyn>;
    type ParameterStorage = Owned<f64, Dyn>;

    fn set_params(&mut self, variables: &DVector<f64>) {
        *self = Self::at(self.data, variables.clone(), self.point.at.preconditioned);
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
