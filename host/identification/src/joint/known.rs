//! What a recording tells about a joint: standard errors of its parameters and of its stiffness.
//!
//! As for one muscle (`crate::uncertainty`): from the derivatives of the simulated angle, wider
//! where the residuals of neighbouring rows are alike. An unknown at a bound is held, and has none.

use nalgebra::{DMatrix, DVector, RowDVector};

use super::balance::Rows;
use super::refine::{jacobian, residuals};
use super::slack::Slack;
use super::unknowns::{COUNT, LINEAR, Unknowns, is_bounded, named};
use super::{JointError, THINNED};
use crate::autocorrelation::Scatter;
use crate::uncertainty;

/// Step of a difference in an unknown, as a share of it, or of 1 if that is more: about the cube
/// root of what numbers are rounded by, at which rounding and curvature matter least together.
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
    /// The least and the largest stiffness in the middle of the angles, each with its standard
    /// error, if the recording tells that. Unit: N m/rad.
    pub stiffness: [(f64, Option<f64>); 2],
    /// Over how many rows residuals are alike; 1 if they are white.
    pub memory: usize,
    /// Where a muscle was slack in the recording, which is left out.
    pub slack: Vec<Slack>,
}

/// The free unknowns at what was found.
struct Free {
    places: Vec<usize>,
    known: uncertainty::Unknowns,
}

impl Free {
    /// None next to what is no joint, where there are no derivatives.
    fn new(rows: &Rows, counts: &[bool], found: &Unknowns) -> Option<Self> {
        let here = residuals(rows, counts, found)?;
        let jacobian = jacobian(rows, counts, found, &here)?;
        let largest = rows.largest();
        let is_held = |place: usize| {
            let is_most = |shape: usize| found[place] >= largest[shape];
            let at_most = place.checked_sub(LINEAR).is_some_and(is_most);
            is_bounded(place) && found[place] <= 0.0 || at_most || jacobian.column(place).norm() <= 0.0
        };
        let places: Vec<usize> = (0..COUNT).filter(|place| !is_held(*place)).collect();
        let jacobian = jacobian.select_columns(&places);
        let along = |turn: &DMatrix<f64>, scatter: &mut Scatter| {
            let turned = (&jacobian * turn).transpose();
            turned.column_iter().for_each(|row| scatter.take(row.as_slice()));
        };
        let information = jacobian.transpose() * &jacobian;
        let known = uncertainty::Unknowns::new(&information, here.as_slice(), along);
        Some(Self { places, known })
    }

    /// The standard error of a number with these derivatives by the free unknowns.
    fn error(&self, gradient: &DVector<f64>) -> Option<f64> {
        let is_told = self.known.is_told(&RowDVector::from_row_slice(gradient.as_slice()));
        let square = || (gradient.transpose() * &self.known.covariance * gradient)[(0, 0)];
        is_told.then(|| square().sqrt()).filter(|error| error.is_finite())
    }

    /// That of an unknown; None where it is held.
    fn error_of(&self, place: usize) -> Option<f64> {
        let at = self.places.iter().position(|free| *free == place)?;
        self.error(&DVector::from_fn(self.places.len(), |other, _| f64::from(u8::from(other == at))))
    }

    /// Those of both ends of the stiffness.
    fn errors_of_stiffness(&self, rows: &Rows, found: &Unknowns, here: [f64; 2]) -> Option<[Option<f64>; 2]> {
        let slope = |place: &usize| {
            // Towards 0, so that knees and slips stay below their bounds.
            let step = -(STEP * found[*place].abs().max(1.0)).copysign(found[*place]);
            let mut beside = *found;
            beside[*place] += step;
            let there = stiffness(rows, &beside).ok()?;
            Some([0, 1].map(|end| (there[end] - here[end]) / step))
        };
        let slopes: Vec<[f64; 2]> = self.places.iter().map(slope).collect::<Option<_>>()?;
        let of = |end: usize| self.error(&DVector::from_fn(slopes.len(), |at, _| slopes[at][end]));
        Some([of(0), of(1)])
    }
}

/// The least and the largest stiffness in the middle of the angles. Unit: N m/rad.
fn stiffness(rows: &Rows, unknowns: &Unknowns) -> Result<[f64; 2], JointError> {
    let joint = rows.joint(unknowns)?;
    let (soft, stiff) = joint.stiffness_range(0.5 * (joint.angles().min() + joint.angles().max()));
    Ok([soft, stiff])
}

impl JointKnown {
    /// At what was found, from the rows of `counts`.
    pub(super) fn new(
        rows: &Rows,
        counts: &[bool],
        found: &Unknowns,
        slack: Vec<Slack>,
    ) -> Result<Self, JointError> {
        let free = Free::new(rows, counts, found);
        let free = free.as_ref();
        let estimate = |(place, (name, unit, value)): (usize, (String, &'static str, f64))| {
            let standard_error = free.and_then(|free| free.error_of(place));
            JointEstimate { name, unit, value, standard_error }
        };
        let ends = stiffness(rows, found)?;
        let errors = free.and_then(|free| free.errors_of_stiffness(rows, found, ends)).unwrap_or_default();
        Ok(Self {
            estimates: named(found).into_iter().enumerate().map(estimate).collect(),
            stiffness: [0, 1].map(|end| (ends[end], errors[end])),
            memory: free.map_or(1, |free| free.known.memory() * THINNED),
            slack,
        })
    }
}
