//! Standard errors of the raw parameters, from the Jacobian at the minimum.
//!
//! The covariance of coordinates and linear coefficients is σ² (JᵀJ)⁻¹ over those that no bound holds, σ² the
//! residual variance; the raw parameters are functions of them, and get their errors by first-order
//! propagation. Residuals are taken as independent: where neighbouring ones are alike, the true errors
//! are larger.

use model_core::ParameterError;
use nalgebra::{DMatrix, DVector};

use super::Estimate;
use super::coordinates::Coordinate;
use super::data::Data;
use super::inner::Inner;
use super::named::{Named, named};
use super::problem::{Point, Products, grid};
use super::projection::Linear;
use super::raw;

/// The raw parameters with their standard errors.
///
/// # Errors
/// The numbers of operators are above the capacity.
pub fn estimates<const K: usize>(data: &Data, point: &Point<'_, K>) -> Result<Vec<Estimate>, ParameterError> {
    let coordinates = point.at.coordinates.iter();
    let at: Vec<f64> = coordinates.clone().copied().chain(point.linear.coefficients()).collect();
    let is_inside = |(coordinate, value): (&Coordinate, &f64)| !coordinate.is_at_bound(*value);
    let mut free: Vec<bool> = data.coordinates.iter().zip(coordinates).map(is_inside).collect();
    free.extend(&point.linear.free);
    let covariance = covariance(data, point, &free);
    let values = raw_values::<K>(data, &at)?;
    let mut jacobian = DMatrix::zeros(values.len(), at.len());
    for (column, &value) in at.iter().enumerate() {
        let step = 1e-6 * value.abs().max(1e-3);
        let moved = |by: f64| {
            let mut moved = at.clone();
            moved[column] += by;
            let values = raw_values::<K>(data, &moved)?;
            Ok(DVector::from_iterator(values.len(), values.iter().map(|named| named.value)))
        };
        jacobian.set_column(column, &((moved(step)? - moved(-step)?) / (2.0 * step)));
    }
    let error = |row: usize| {
        let gradient = jacobian.row(row);
        let is_bound = (0..at.len()).any(|j| !free[j] && gradient[j] != 0.0);
        let error = (gradient * &covariance * gradient.transpose())[(0, 0)].sqrt();
        (!is_bound && error.is_finite()).then_some(error)
    };
    let estimate = |(row, parameter): (usize, Named)| Estimate { parameter, standard_error: error(row) };
    Ok(values.into_iter().enumerate().map(estimate).collect())
}

/// The covariance of all unknowns; rows and columns of those that are not free are 0.
fn covariance<const K: usize>(data: &Data, point: &Point<'_, K>, free: &[bool]) -> DMatrix<f64> {
    let Products { own, mixed, .. } = point.products();
    let (count, linear) = (own.nrows(), point.linear.free.len());
    let mut information = DMatrix::zeros(count + linear, count + linear);
    information.view_mut((0, 0), (count, count)).copy_from(&own);
    information.view_mut((count, count), (linear, linear)).copy_from(&point.columns.gram);
    information.view_mut((count, 0), (linear, count)).copy_from(&mixed);
    information.view_mut((0, count), (count, linear)).copy_from(&mixed.transpose());
    let places: Vec<usize> = (0..free.len()).filter(|&j| free[j]).collect();
    let reduced = information.select_rows(&places).select_columns(&places);
    // Unit diagonal first: the unknowns differ by many orders of magnitude.
    let scales = reduced.diagonal().map(|d| if d > 0.0 { 1.0 / d.sqrt() } else { 0.0 });
    let scaled = DMatrix::from_fn(places.len(), places.len(), |i, j| reduced[(i, j)] * scales[i] * scales[j]);
    let freedom = data.rows.len().saturating_sub(places.len()).max(1);
    let variance = point.cost() / freedom as f64;
    let mut covariance = DMatrix::zeros(free.len(), free.len());
    if let Some(inverse) = scaled.try_inverse() {
        for (i, &row) in places.iter().enumerate() {
            for (j, &column) in places.iter().enumerate() {
                covariance[(row, column)] = variance * inverse[(i, j)] * scales[i] * scales[j];
            }
        }
    } else {
        covariance.fill(f64::NAN);
    }
    covariance
}

/// The raw parameters at coordinates and linear coefficients.
fn raw_values<const K: usize>(data: &Data, at: &[f64]) -> Result<Vec<Named>, ParameterError> {
    let (coordinates, coefficients) = at.split_at(data.coordinates.len());
    let inner = Inner::new(&data.structure, coordinates, data.span);
    let segments = data.structure.segments;
    let (grid, _) = grid::<K>(&inner, segments, coordinates.len());
    let linear = Linear::new(coefficients, segments, Vec::new());
    let (parameters, density) = raw::parameters(&data.structure, &inner, &grid, &linear, data.span)?;
    Ok(named(&parameters, &density))
}
