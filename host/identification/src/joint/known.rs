//! What a recording tells about a joint: standard errors of its parameters and of its stiffness.
//!
//! As for one muscle (`crate::uncertainty`): from the derivatives of the simulated angle, wider
//! where the residuals of neighbouring rows are alike. An unknown at a bound is held, and has none.

use nalgebra::{DMatrix, DVector, RowDVector};
use recording::joint::HostJoint;

use super::balance::Rows;
use super::refine::{jacobian, residuals};
use super::unknowns::{COUNT, LINEAR, Unknowns, is_bounded, named};
use super::{JointError, THINNED};
use crate::autocorrelation::Scatter;
use crate::uncertainty;

/// Step of a difference in an unknown, as a share of it, or of 1 if that is more.
const STEP: f64 = 1e-5;

/// A parameter of a joint with what is known about it.
#[derive(Clone, Debug, PartialEq)]
pub struct JointEstimate {
    /// Its name in the model file, that of its section before it.
    pub name: String,
    /// Its unit.
    pub unit: &'static str,
    /// In that unit.
    pub value: f64,
    /// Standard error in the same unit; None where a bound holds it or no row tells.
    pub standard_error: Option<f64>,
}

/// What is known about a joint.
#[derive(Clone, Debug)]
pub struct JointKnown {
    /// The parameters, each with its error.
    pub estimates: Vec<JointEstimate>,
    /// Standard errors of the least and the largest stiffness in the middle of the angles; None
    /// where the recording does not tell them. Unit: N m/rad.
    pub stiffness_errors: [Option<f64>; 2],
    /// Over how many rows residuals are alike; 1 if they are white.
    pub memory: usize,
}

/// The middle of a joint's angles. Unit: rad.
pub(super) fn middle(joint: &HostJoint) -> f64 {
    0.5 * (joint.angles().min() + joint.angles().max())
}

impl JointKnown {
    /// At what was found, from the rows of `counts`.
    pub(super) fn new(rows: &Rows, counts: &[bool], found: &Unknowns) -> Result<Self, JointError> {
        let here = residuals(rows, counts, found).ok_or(JointError::Singular)?;
        let jacobian = jacobian(rows, counts, found, &here).ok_or(JointError::Singular)?;
        let largest = rows.largest();
        let is_held = |place: usize| {
            let is_most = |shape: usize| found[place] >= largest[shape];
            let at_most = place.checked_sub(LINEAR).is_some_and(is_most);
            is_bounded(place) && found[place] <= 0.0 || at_most || jacobian.column(place).norm() <= 0.0
        };
        let free: Vec<usize> = (0..COUNT).filter(|place| !is_held(*place)).collect();
        let jacobian = jacobian.select_columns(&free);
        let along = |turn: &DMatrix<f64>, scatter: &mut Scatter| {
            let turned = (&jacobian * turn).transpose();
            turned.column_iter().for_each(|row| scatter.take(row.as_slice()));
        };
        let information = jacobian.transpose() * &jacobian;
        let unknown = uncertainty::Unknowns::new(&information, here.as_slice(), along);
        // Of a number with these derivatives by the free unknowns.
        let error = |gradient: &DVector<f64>| {
            let is_told = unknown.is_told(&RowDVector::from_row_slice(gradient.as_slice()));
            is_told.then(|| (gradient.transpose() * &unknown.covariance * gradient)[(0, 0)].sqrt())
        };
        let errors = (0..COUNT).map(|place| {
            let at = free.iter().position(|free| *free == place)?;
            error(&DVector::from_fn(free.len(), |other, _| f64::from(u8::from(other == at))))
        });
        let estimates = named(found)
            .into_iter()
            .zip(errors)
            .map(|((name, unit, value), standard_error)| JointEstimate { name, unit, value, standard_error });
        let ends = |unknowns: &Unknowns| {
            let joint = rows.joint(unknowns).ok()?;
            let (soft, stiff) = joint.stiffness_range(middle(&joint));
            Some([soft, stiff])
        };
        let slopes: Option<Vec<[f64; 2]>> = free
            .iter()
            .map(|&place| {
                let step = STEP * found[place].abs().max(1.0);
                // Towards 0, so that knees and slips stay below their bounds.
                let step = -step.copysign(found[place]);
                let mut beside = *found;
                beside[place] += step;
                let (there, here) = (ends(&beside)?, ends(found)?);
                Some([0, 1].map(|end| (there[end] - here[end]) / step))
            })
            .collect();
        let of_end = |end: usize| {
            let slopes = slopes.as_ref()?;
            error(&DVector::from_fn(free.len(), |at, _| slopes[at][end]))
        };
        Ok(Self {
            estimates: estimates.collect(),
            stiffness_errors: [of_end(0), of_end(1)],
            memory: unknown.memory() * THINNED,
        })
    }
}
