//! The reduced least-squares problem: five nonlinear coordinates, the rest projected out.
//!
//! Variable projection (Golub and Pereyra 1973) with Kaufman's Jacobian (1975), whose gradient is exact: the
//! derivative of the model at fixed linear coefficients, less its part in the span of the free linear
//! columns. Slopes that stand at their bound do not take part.

use levenberg_marquardt::LeastSquaresProblem;
use nalgebra::{DMatrix, DVector, Dyn, OMatrix, OVector, Owned, U5, Vector5};

use super::coordinates::{Bounds, COUNT, Inner};
use super::inner::{sensitivities, simulate};
use super::projection::{Linear, Segments};

/// A recording, normalised for the search.
pub struct Data {
    /// All inputs, 0 … 1 over their span.
    pub inputs: Vec<f64>,
    /// The rows that count.
    pub rows: Vec<usize>,
    /// The outputs of those rows. Output unit.
    pub outputs: Vec<f64>,
    /// The smallest slope allowed. Output unit per unit of u.
    pub least_slope: f64,
    /// Number of plays.
    pub plays: usize,
    /// Number of dead zones, at least 1.
    pub dead_zones: usize,
}

/// The problem at a point.
pub struct Problem<'a> {
    data: &'a Data,
    bounds: Bounds,
    variables: Vector5<f64>,
    scales: [f64; COUNT],
    point: Point,
}

/// The model and its residuals at a point of the coordinates.
pub struct Point {
    /// The coordinates.
    pub coordinates: [f64; COUNT],
    /// Envelope and plays.
    pub inner: Inner,
    /// Where the rows lie.
    pub segments: Segments,
    /// Offset and slopes.
    pub linear: Linear,
    /// Model less measurement for each row that counts. Output unit.
    pub residuals: DVector<f64>,
}

impl Point {
    /// Evaluates the model, the linear part at its best.
    pub fn new(data: &Data, coordinates: [f64; COUNT]) -> Self {
        let inner = Inner::new(&coordinates, data.plays);
        let mut u = Vec::with_capacity(data.inputs.len());
        simulate(&inner, &data.inputs, &mut u);
        let segments = Segments::new(data.rows.iter().map(|&row| u[row]), inner.u_max(), data.dead_zones);
        let linear = segments.fit(&data.outputs, data.least_slope);
        let model = segments.evaluate(&linear.coefficients()).collect::<Vec<_>>();
        let residuals = DVector::from_iterator(
            data.outputs.len(),
            model.iter().zip(&data.outputs).map(|(model, measured)| model - measured),
        );
        Self { coordinates, inner, segments, linear, residuals }
    }

    /// Sum of the squared residuals.
    pub fn cost(&self) -> f64 {
        self.residuals.norm_squared()
    }

    /// The derivatives of the model by the coordinates at fixed linear coefficients: a column each.
    pub fn derivatives(&self, data: &Data) -> OMatrix<f64, Dyn, U5> {
        let by_u_max = self.inner.u_max_derivatives();
        let sensitivities = sensitivities(&self.inner, &data.inputs);
        let weights = self.linear.weights();
        // The knots dⱼ = j u_max/m move with u_max: each one passed takes wⱼ j/m with it.
        let mut passed = 0.0;
        let knots: Vec<f64> = weights
            .iter()
            .enumerate()
            .map(|(j, weight)| {
                passed += weight * j as f64 / weights.len() as f64;
                passed
            })
            .collect();
        let mut columns = OMatrix::<f64, Dyn, U5>::zeros(data.rows.len());
        for (i, (&row, &(segment, _))) in data.rows.iter().zip(self.segments.places()).enumerate() {
            for c in 0..COUNT {
                columns[(i, c)] =
                    self.linear.slopes[segment] * sensitivities[row][c] - knots[segment] * by_u_max[c];
            }
        }
        columns
    }

    /// Takes out of each column its part in the span of the free linear columns.
    fn project(&self, columns: &mut OMatrix<f64, Dyn, U5>) {
        let places: Vec<usize> = (0..self.linear.free.len()).filter(|&j| self.linear.free[j]).collect();
        let gram: DMatrix<f64> = self.segments.gram().select_rows(&places).select_columns(&places);
        // Segments without a row make ΦᵀΦ singular; the pseudo-inverse leaves them out.
        let Ok(inverse) = gram.pseudo_inverse(1e-12 * self.residuals.len() as f64) else {
            return;
        };
        for mut column in columns.column_iter_mut() {
            let moments = self.segments.moments(column.iter().copied()).select_rows(&places);
            let solution = &inverse * moments;
            let mut coefficients = vec![0.0; self.linear.free.len()];
            for (place, value) in places.iter().zip(solution.iter()) {
                coefficients[*place] = *value;
            }
            for (element, part) in column.iter_mut().zip(self.segments.evaluate(&coefficients)) {
                *element -= part;
            }
        }
    }
}

impl<'a> Problem<'a> {
    /// The problem at a start.
    pub fn new(data: &'a Data, bounds: Bounds, start: &[f64; COUNT]) -> Self {
        let variables = Vector5::from(bounds.variables(start));
        let (coordinates, scales) = bounds.coordinates(&variables.into());
        Self { data, bounds, variables, scales, point: Point::new(data, coordinates) }
    }

    /// The point where the problem stands.
    pub fn into_point(self) -> Point {
        self.point
    }
}

impl LeastSquaresProblem<f64, Dyn, U5> for Problem<'_> {
    type ResidualStorage = Owned<f64, Dyn>;
    type JacobianStorage = Owned<f64, Dyn, U5>;
    type ParameterStorage = Owned<f64, U5>;

    fn set_params(&mut self, variables: &OVector<f64, U5>) {
        self.variables.copy_from(variables);
        let coordinates;
        (coordinates, self.scales) = self.bounds.coordinates(&self.variables.into());
        self.point = Point::new(self.data, coordinates);
    }

    fn params(&self) -> OVector<f64, U5> {
        self.variables
    }

    fn residuals(&self) -> Option<DVector<f64>> {
        Some(self.point.residuals.clone())
    }

    fn jacobian(&self) -> Option<OMatrix<f64, Dyn, U5>> {
        let mut columns = self.point.derivatives(self.data);
        self.point.project(&mut columns);
        for (mut column, scale) in columns.column_iter_mut().zip(self.scales) {
            column *= scale;
        }
        Some(columns)
    }
}
