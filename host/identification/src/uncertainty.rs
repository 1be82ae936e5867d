//! What is known about the raw parameters, from the Jacobian at the minimum.
//!
//! Coordinates and linear coefficients that no bound holds have the covariance B M B n / (n - p):
//! B = (JᵀJ)⁻¹, and M is that of Jᵀr, r the n residuals. Where these are white, M = σ² JᵀJ and all
//! is as in a textbook; where neighbouring ones are alike, M is larger (`autocorrelation`). The fit
//! has hidden p = tr(B M) / σ² rows' worth of the residuals: with white ones, one for each unknown.
//!
//! The raw parameters are functions of these unknowns, and get their covariance by first-order
//! propagation.

use model_core::ParameterError;
use nalgebra::{DMatrix, DVector, RowDVector};

use super::autocorrelation::{Scatter, memory, reach};
use super::collinear;
use super::coordinates::Coordinate;
use super::data::Data;
use super::inner::Inner;
use super::problem::{LEAST_EIGENVALUE, Point, grid};
use super::projection::Linear;
use super::raw;
use recording::model::named::{Named, named};

/// The share of a parameter's largest derivative by an unknown up to which another unknown, held at
/// a bound, leaves it free: weights of plays that are next to nothing move the other weights by
/// next to nothing.
const NEGLIGIBLE: f64 = 1e-3;

/// A raw parameter with what is known about it.
#[derive(Clone, Debug, PartialEq)]
pub struct Estimate {
    /// Name, value and dimension.
    pub parameter: Named,
    /// Standard error in the same unit; None where a bound binds or no row tells.
    pub standard_error: Option<f64>,
    /// Ends of the 95 % interval in the same unit; None where a bound binds or no row tells.
    pub interval: Option<[f64; 2]>,
}

/// What is known about the raw parameters together.
#[derive(Clone, Debug)]
pub struct Uncertainty {
    /// The raw parameters, each with its errors.
    pub estimates: Vec<Estimate>,
    /// Their correlation, in the same order; not a number where these have none.
    pub correlation: DMatrix<f64>,
    /// Groups of names that the recording hardly separates.
    pub collinear: Vec<Vec<String>>,
    /// Over how many rows residuals are alike; 1 if they are white.
    pub memory: usize,
}

impl Uncertainty {
    /// At a minimum.
    ///
    /// # Errors
    /// The numbers of operators are above the capacity.
    pub fn new<const K: usize>(data: &Data, point: &Point<K>) -> Result<Self, ParameterError> {
        let (coordinates, coefficients) = (&point.at.coordinates, point.linear.coefficients());
        let unknowns: Vec<f64> = coordinates.iter().copied().chain(coefficients).collect();
        let is_inside = |(coordinate, value): (&Coordinate, &f64)| !coordinate.is_at_bound(*value);
        let is_free = data.coordinates.iter().zip(coordinates).map(is_inside);
        let is_free: Vec<bool> = is_free.chain(point.linear.free.iter().copied()).collect();
        let information = point.information();
        // What no row tells anything of is not free either: a play that nothing drives, for one.
        let (free, held): (Vec<usize>, Vec<usize>) =
            (0..unknowns.len()).partition(|&place| is_free[place] && information[(place, place)] > 0.0);
        let by_unknowns = raw_by_unknowns::<K>(data, &unknowns)?;
        let information = information.select_rows(&free).select_columns(&free);
        let along = |turn: &DMatrix<f64>, scatter: &mut Scatter| {
            point.derivatives_along(data, &free, turn, |row| scatter.take(row))
        };
        let unknown = Unknowns::new(&information, &point.residuals(data), along);
        let by_free = by_unknowns.select_columns(&free);
        let covariance = &by_free * &unknown.covariance * by_free.transpose();
        let error = |row: usize| {
            let gradient = by_unknowns.row(row);
            let is_held = held.iter().any(|&place| gradient[place].abs() > NEGLIGIBLE * gradient.amax());
            let is_known = !is_held && unknown.is_told(&by_free.row(row).into_owned());
            if is_known { covariance[(row, row)].sqrt() } else { f64::NAN }
        };
        let errors = DVector::from_fn(by_unknowns.nrows(), |row, _| error(row));
        let estimate = |(parameter, &error): (Named, &f64)| {
            let reach = reach(unknown.freedom) * error;
            let (value, is_known) = (parameter.value, error.is_finite());
            Estimate {
                parameter,
                standard_error: is_known.then_some(error),
                interval: is_known.then_some([value - reach, value + reach]),
            }
        };
        let values = raw_values::<K>(data, &unknowns)?;
        let names: Vec<&str> = values.iter().map(|named| named.name.as_str()).collect();
        let correlation = covariance.component_div(&(&errors * errors.transpose()));
        Ok(Self {
            collinear: collinear::groups(&names, &correlation),
            correlation,
            memory: unknown.memory,
            estimates: values.into_iter().zip(&errors).map(estimate).collect(),
        })
    }

    /// The groups that the recording hardly separates, in words: `c1, c2; w0, w1, w2`. None without
    /// any.
    pub fn hardly_separable(&self) -> Option<String> {
        let groups: Vec<String> = self.collinear.iter().map(|group| group.join(", ")).collect();
        (!groups.is_empty()).then(|| groups.join("; "))
    }

    /// Whether a parameter is known by itself: at no bound, and in no group that the recording
    /// hardly separates.
    pub fn is_identifiable(&self, estimate: &Estimate) -> bool {
        estimate.interval.is_some()
            && !self.collinear.iter().flatten().any(|name| *name == estimate.parameter.name)
    }
}

/// What is known about unknowns that no bound holds.
pub(crate) struct Unknowns {
    /// Their covariance.
    pub(crate) covariance: DMatrix<f64>,
    /// Of each, one over the length of its column of the Jacobian.
    scales: DVector<f64>,
    /// Directions that no row tells anything of, in unknowns over their scales.
    untold: DMatrix<f64>,
    /// Over how many rows residuals are alike.
    memory: usize,
    /// Degrees of freedom of the covariance: the rows that the fit has left, or, of Bartlett's
    /// kernel, one and a half for each length of the memory (Priestley 1981).
    freedom: f64,
}

impl Unknowns {
    /// From JᵀJ at the free unknowns, and the residuals. `along` hands over the derivatives of each
    /// row along some directions, the columns of a matrix.
    pub(crate) fn new(
        information: &DMatrix<f64>,
        residuals: &[f64],
        along: impl FnOnce(&DMatrix<f64>, &mut Scatter),
    ) -> Self {
        // Unit length first: the unknowns differ by many orders of magnitude.
        let scales = information.diagonal().map(|square| 1.0 / square.sqrt());
        let eigen = information.component_mul(&(&scales * scales.transpose())).symmetric_eigen();
        let (told, untold): (Vec<usize>, Vec<usize>) =
            (0..scales.len()).partition(|&k| eigen.eigenvalues[k] > LEAST_EIGENVALUE);
        let mut turn = eigen.eigenvectors.select_columns(&told);
        for (mut direction, &k) in turn.column_iter_mut().zip(&told) {
            direction /= eigen.eigenvalues[k].sqrt();
        }
        let turn = DMatrix::from_diagonal(&scales) * turn;
        // In these directions, orthonormal over the rows, B is 1.
        let memory = memory(residuals);
        let mut scatter = Scatter::new(told.len(), residuals, memory);
        along(&turn, &mut scatter);
        let scatter = scatter.sum();
        let (rows, squares) = (residuals.len() as f64, residuals.iter().map(|r| r * r).sum::<f64>());
        // Without any residual not a number, and then 1.
        let left = (rows - rows * scatter.trace() / squares).max(1.0);
        Self {
            covariance: &turn * scatter * turn.transpose() * (rows / left),
            untold: eigen.eigenvectors.select_columns(&untold),
            scales,
            memory,
            freedom: left / (memory as f64 / 1.5).max(1.0),
        }
    }

    /// Over how many rows residuals are alike.
    pub(crate) fn memory(&self) -> usize {
        self.memory
    }

    /// Whether the rows tell of a parameter with these derivatives.
    pub(crate) fn is_told(&self, gradient: &RowDVector<f64>) -> bool {
        let gradient = gradient.component_mul(&self.scales.transpose());
        (&gradient * &self.untold).iter().all(|along| along.abs() <= NEGLIGIBLE * gradient.norm())
    }
}

/// The derivatives of the raw parameters by all unknowns, a column for each.
fn raw_by_unknowns<const K: usize>(data: &Data, unknowns: &[f64]) -> Result<DMatrix<f64>, ParameterError> {
    let mut columns = Vec::with_capacity(unknowns.len());
    for (place, &value) in unknowns.iter().enumerate() {
        let step = 1e-6 * value.abs().max(1e-3);
        let moved = |by: f64| {
            let mut moved = unknowns.to_vec();
            moved[place] += by;
            let values = raw_values::<K>(data, &moved)?;
            Ok(DVector::from_iterator(values.len(), values.iter().map(|named| named.value)))
        };
        // A difference as small as rounding counts as zero: the ends of the knots are 0 and 1,
        // wherever the others are.
        let difference = |up: f64, down: f64| {
            if (up - down).abs() < 1e-14 * up.abs() { 0.0 } else { (up - down) / (2.0 * step) }
        };
        columns.push(moved(step)?.zip_map(&moved(-step)?, difference));
    }
    Ok(DMatrix::from_columns(&columns))
}

/// The raw parameters at coordinates and linear coefficients.
fn raw_values<const K: usize>(data: &Data, unknowns: &[f64]) -> Result<Vec<Named>, ParameterError> {
    let (coordinates, coefficients) = unknowns.split_at(data.coordinates.len());
    let inner = Inner::new(&data.structure, coordinates, data.span);
    let segments = data.structure.segments;
    let (grid, _) = grid::<K>(&inner, segments, coordinates.len());
    let linear = Linear::new(coefficients, segments, Vec::new());
    let (parameters, density) = raw::parameters(&data.structure, &inner, &grid, &linear, data.span)?;
    Ok(named(&parameters, &density))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn of_two_unknowns_that_act_alike_only_the_sum_is_told() {
        let alike = |row: usize| (0.1 * row as f64).sin();
        let jacobian = DMatrix::from_fn(3, 200, |i, row| if i < 2 { alike(row) } else { alike(row * row) });
        let residuals: Vec<f64> = (0..200).map(|row| f64::from(row * row % 7 < 3) - 0.4).collect();
        let along = |turn: &DMatrix<f64>, scatter: &mut Scatter| {
            (turn.transpose() * &jacobian).column_iter().for_each(|row| scatter.take(row.as_slice()));
        };
        let unknown = Unknowns::new(&(&jacobian * jacobian.transpose()), &residuals, along);
        assert!(unknown.is_told(&RowDVector::from_row_slice(&[1.0, 1.0, 0.0])));
        assert!(unknown.is_told(&RowDVector::from_row_slice(&[0.0, 0.0, 1.0])));
        assert!(!unknown.is_told(&RowDVector::from_row_slice(&[1.0, 0.0, 0.0])));
        assert!(unknown.covariance.iter().all(|c| c.is_finite()));
    }
}
