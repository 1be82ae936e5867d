//! Standard errors of the raw parameters, from the Jacobian at the minimum.
//!
//! The covariance of coordinates and linear coefficients is σ² (JᵀJ)⁻¹ over those that no bound holds, σ² the
//! residual variance; the raw parameters are functions of them, and get their errors by first-order
//! propagation. Residuals are taken as independent: where neighbouring ones are alike, the true errors
//! are larger.

use nalgebra::{DMatrix, DVector};

use super::coordinates::{Bounds, COUNT, Inner};
use super::problem::{Data, Point};
use super::{Estimate, Span};

/// The raw parameters with their standard errors.
pub fn estimates(data: &Data, bounds: &Bounds, span: Span, point: &Point) -> Vec<Estimate> {
    let at: Vec<f64> = point.coordinates.iter().copied().chain(point.linear.coefficients()).collect();
    let mut free: Vec<bool> = bounds.at_bound(&point.coordinates).iter().map(|bound| !bound).collect();
    free.extend(&point.linear.free);
    let covariance = covariance(data, point, &free);
    let raw = |at: &[f64]| raw(data, span, at);
    let values = raw(&at);
    let mut variances = DVector::zeros(values.len());
    let mut bound = vec![false; values.len()];
    let mut jacobian = DMatrix::zeros(values.len(), at.len());
    for (column, &value) in at.iter().enumerate() {
        let step = 1e-6 * value.abs().max(1e-3);
        let moved = |by: f64| {
            let mut moved = at.clone();
            moved[column] += by;
            DVector::from_vec(raw(&moved))
        };
        jacobian.set_column(column, &((moved(step) - moved(-step)) / (2.0 * step)));
    }
    for row in 0..values.len() {
        let gradient = jacobian.row(row);
        bound[row] = (0..at.len()).any(|j| !free[j] && gradient[j] != 0.0);
        variances[row] = (gradient * &covariance * gradient.transpose())[(0, 0)];
    }
    let error = |row: usize| {
        let error = f64::sqrt(variances[row]);
        (!bound[row] && error.is_finite()).then_some(error)
    };
    names(data.dead_zones)
        .zip(values)
        .enumerate()
        .map(|(row, (name, value))| Estimate { name, value, standard_error: error(row) })
        .collect()
}

/// The covariance of all unknowns; rows and columns of those that are not free are 0.
fn covariance(data: &Data, point: &Point, free: &[bool]) -> DMatrix<f64> {
    let derivatives = point.derivatives(data);
    let linear = point.linear.free.len();
    let mut information = DMatrix::zeros(COUNT + linear, COUNT + linear);
    information.view_mut((0, 0), (COUNT, COUNT)).copy_from(&(derivatives.transpose() * &derivatives));
    information.view_mut((COUNT, COUNT), (linear, linear)).copy_from(&point.segments.gram());
    for (c, column) in derivatives.column_iter().enumerate() {
        let mixed = point.segments.moments(column.iter().copied());
        information.view_mut((COUNT, c), (linear, 1)).copy_from(&mixed);
        information.view_mut((c, COUNT), (1, linear)).copy_from(&mixed.transpose());
    }
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

fn names(dead_zones: usize) -> impl Iterator<Item = String> {
    let inner = ["c0", "c1", "c2", "c3", "q", "rho", "tau", "alpha"];
    let weights = (0..dead_zones).map(|j| format!("w{j}"));
    inner.into_iter().map(String::from).chain(weights).chain([String::from("offset")])
}

/// The raw parameters, in the order of [`names`], at coordinates and linear coefficients.
fn raw(data: &Data, (low, span): Span, at: &[f64]) -> Vec<f64> {
    let mut coordinates = [0.0; COUNT];
    coordinates.copy_from_slice(&at[..COUNT]);
    let inner = Inner::new(&coordinates, data.plays);
    let envelope = inner.raw_envelope(low, span);
    let (rho, tau) = inner.rho_and_tau();
    let (offset, slopes) = (at[COUNT], &at[COUNT + 1..]);
    let before = std::iter::once(&0.0).chain(slopes);
    [envelope.c0, envelope.c1, envelope.c2, envelope.c3, inner.s, rho, tau, inner.alpha]
        .into_iter()
        .chain(slopes.iter().zip(before).map(|(slope, before)| slope - before))
        .chain([offset])
        .collect()
}
