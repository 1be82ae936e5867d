//! Gauss-Newton on the simulated angle, damped as by Levenberg, with the bounds of the unknowns.
//!
//! Derivatives are differences of whole simulations: there is one for each unknown, side by side.

use nalgebra::{DMatrix, DVector};
use rayon::prelude::*;

use super::balance::{Rows, allows};
use super::simulate::simulate;
use super::unknowns::{COUNT, LINEAR, Unknowns, is_bounded, shape};
use super::{JointError, THINNED};
use crate::nnls;

/// Most steps.
const STEPS: usize = 12;
/// A step that gains less than this share of the sum of squares is the last.
const CONVERGED: f64 = 1e-4;
/// The torque that a difference is of. Unit: N m.
const TORQUE: f64 = 1e-3;
/// Step of a difference in a knee or a slip, as a share of its largest value: small beside the
/// curvature of the angle, large beside rounding.
const SHAPED: f64 = 1e-3;
/// Damping at first, and at which nothing more is tried.
const DAMPING: f64 = 1e-4;
const MOST_DAMPING: f64 = 1e3;

/// Unknowns whose simulated angle is nearer to the measured one in the rows of `counts`.
pub(super) fn refined(rows: &Rows, counts: &[bool], from: Unknowns) -> Result<Unknowns, JointError> {
    let there = |at: &Unknowns| residuals(rows, counts, at);
    let mut at = from;
    let mut here = there(&at).ok_or(JointError::Singular)?;
    let mut damping = DAMPING;
    for _ in 0..STEPS {
        // Next to what is no joint there are no differences: what is found stays.
        let Some(jacobian) = jacobian(rows, counts, &at, &here) else { break };
        let (gram, slope) = (jacobian.transpose() * &jacobian, jacobian.transpose() * &here);
        let before = here.norm_squared();
        loop {
            let trial = step(&gram, &slope, &at, damping);
            match there(&trial).filter(|found| found.norm_squared() < before) {
                Some(found) => {
                    (at, here) = (trial, found);
                    damping *= 0.1;
                    break;
                }
                None if damping > MOST_DAMPING => break,
                None => damping *= 10.0,
            }
        }
        if before - here.norm_squared() < CONVERGED * before {
            break;
        }
    }
    Ok(at)
}

/// Simulated less measured angle in every Nth row of `counts`, rad; None where the unknowns
/// are those of no joint.
pub(super) fn residuals(rows: &Rows, counts: &[bool], unknowns: &Unknowns) -> Option<DVector<f64>> {
    let joint = rows.joint(unknowns).ok().filter(|_| allows(rows, unknowns))?;
    let simulated = simulate(rows, counts, &joint);
    let used = (0..counts.len()).filter(|row| counts[*row]).step_by(THINNED);
    Some(DVector::from_iterator(used.clone().count(), used.map(|row| simulated[row] - rows.angle[row])))
}

/// The derivatives of these residuals, `here` at some unknowns, a column for each; None next to
/// what is no joint.
pub(super) fn jacobian(
    rows: &Rows,
    counts: &[bool],
    at: &Unknowns,
    here: &DVector<f64>,
) -> Option<DMatrix<f64>> {
    let steps = steps(rows, counts, at);
    let column = |place: usize| {
        let mut beside = *at;
        beside[place] += steps[place];
        Some((residuals(rows, counts, &beside)? - here) / steps[place])
    };
    let columns: Option<Vec<DVector<f64>>> = (0..COUNT).into_par_iter().map(column).collect();
    columns.map(|columns| DMatrix::from_columns(&columns))
}

/// Of which size the differences are, away from the bounds.
fn steps(rows: &Rows, counts: &[bool], at: &Unknowns) -> [f64; COUNT] {
    let (mut squares, mut used) = ([0.0; LINEAR], 0.0);
    let shape = shape(at);
    for (features, _) in rows.features(&shape).zip(counts).filter(|(_, counts)| **counts) {
        squares.iter_mut().zip(features).for_each(|(sum, feature)| *sum += feature * feature);
        used += 1.0;
    }
    let largest = rows.largest();
    std::array::from_fn(|place| match squares.get(place) {
        Some(square) => TORQUE / (square / used).sqrt().max(TORQUE),
        None => {
            let (value, largest) = (shape[place - LINEAR], largest[place - LINEAR]);
            if value > 0.5 * largest { -SHAPED * largest } else { SHAPED * largest }
        }
    })
}

/// The unknowns that a damped step leads to, none of the bounded ones negative.
fn step(gram: &DMatrix<f64>, slope: &DVector<f64>, at: &Unknowns, damping: f64) -> Unknowns {
    let lengths = gram.diagonal().map(|square| if square > 0.0 { square.sqrt() } else { 1.0 });
    let mut damped = gram.component_div(&(&lengths * lengths.transpose()));
    for place in 0..COUNT {
        damped[(place, place)] += damping;
    }
    let scaled = DVector::from_row_slice(at).component_mul(&lengths);
    let moment = &damped * scaled - slope.component_div(&lengths);
    let bounded: Vec<bool> = (0..COUNT).map(is_bounded).collect();
    let values = nnls::solve(&damped, &moment, &bounded).values.component_div(&lengths);
    std::array::from_fn(|place| values[place])
}
