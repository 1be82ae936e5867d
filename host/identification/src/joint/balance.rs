//! The balance of torques as least squares: at every row the torque of the joint is that from
//! outside, with the other sign.
//!
//! An error counts by what angle it is, the torque over the stiffness there: a first solution
//! counts torques, and says how stiff the joint is for the second. For given knees and slips the
//! problem is linear; these four are searched by golden sections, one after the other.

use std::ops::Range;

use model_core::List;
use model_core::joint::PullParameters;
use model_core::joint::stops::{Stops, Thresholds};
use nalgebra::{DMatrix, DVector};
use recording::joint::columns::JointRecording;
use recording::joint::{HostJoint, HostJointParameters};

use super::unknowns::{
    COUNT, LINEAR, SHAPE, Shape, Unknowns, drive_and_slip, features, is_bounded, parameters, shape,
};
use super::{JointError, SHORTEST, STOPS, bounds};
use crate::nnls;

/// Half the rows that an angle is averaged over, for what is driven by it. Unit: s.
const SMOOTHED_S: f64 = 0.02;
/// The same for the speed.
const SPEED_S: f64 = 0.1;
/// The search for knees and slips looks at every Nth row.
const THINNED: usize = 5;
/// The largest knee as a share of the square of the lowest pressure.
const LARGEST_KNEE: f64 = 0.8;
/// Rounds of the search, and sections of each.
const ROUNDS: usize = 3;
const SECTIONS: usize = 10;
/// Of the diagonal, that makes what no row tells 0.
const RIDGE: f64 = 1e-10;

/// A recording with what is made of it once.
pub(super) struct Rows {
    pub(super) time_s: Vec<f64>,
    pub(super) pressures: Vec<[f64; 2]>,
    /// As measured. Unit: rad.
    pub(super) angle: Vec<f64>,
    pub(super) torque: Vec<f64>,
    smoothed: Vec<f64>,
    speed: Vec<f64>,
    /// Not below the lowest ones, as they are while the joint is filled: what friction goes by.
    held: Vec<[f64; 2]>,
    thresholds: Thresholds<f64, STOPS>,
    known: HostJointParameters,
    parts: Vec<Range<usize>>,
    scored: Vec<bool>,
}

impl Rows {
    /// Of a recording that has been checked.
    pub(super) fn of(recording: &JointRecording, swing: f64) -> Result<Self, JointError> {
        let JointRecording { time_s, pressures_bar: [a, b], angle_rad, torque_nm, scored, .. } = recording;
        let step_s = (time_s[time_s.len() - 1] - time_s[0]) / (time_s.len() - 1) as f64;
        let half = |s: f64| (s / step_s).round() as usize;
        // What was not recorded in one go has no speed in between.
        let smoothed: Vec<f64> =
            recording.parts().flat_map(|part| averaged(&angle_rad[part], half(SMOOTHED_S))).collect();
        let part_speed =
            |part: Range<usize>| slopes(&time_s[part.clone()], &angle_rad[part], half(SPEED_S).max(1));
        let speed = recording.parts().flat_map(part_speed).collect();
        let at = |row: &usize| scored[*row];
        let rows = || (0..time_s.len()).filter(at);
        let first = rows().map(|row| smoothed[row]).fold(f64::INFINITY, f64::min);
        let last = rows().map(|row| smoothed[row]).fold(f64::NEG_INFINITY, f64::max);
        let longest: f64 = 0.5 / SHORTEST;
        let reach = |k: usize| SHORTEST * (last - first) * longest.powf(k as f64 / (STOPS - 1) as f64);
        let reaches = || (0..STOPS).map(reach);
        let muscle = |place: usize, pressures: &[f64]| {
            let points: Vec<(f64, f64)> = rows().map(|row| (smoothed[row], pressures[row])).collect();
            Ok::<_, JointError>(PullParameters {
                arm: [0.0; 3],
                knee: 0.0,
                friction: List::new(),
                slip: [0.0, 0.0],
                lowest: bounds::lowest(points.clone(), (first, last)),
                highest: bounds::highest(points, (first, last)),
                valve_lag_s: bounds::lag_s(recording, place)?,
            })
        };
        let known = HostJointParameters {
            muscles: [muscle(0, a)?, muscle(1, b)?],
            passive: [0.0; 4],
            viscosity: 0.0,
            reaches: List::from_iter(reaches()),
            swing,
            angles: (first, last),
        };
        let pressures: Vec<[f64; 2]> = a.iter().zip(b).map(|(a, b)| [*a, *b]).collect();
        let least = [0, 1].map(|muscle: usize| {
            let [first, last] = known.muscles[muscle].lowest;
            first.min(last).max(f64::MIN_POSITIVE)
        });
        let held = |[a, b]: &[f64; 2]| [a.max(least[0]), b.max(least[1])];
        Ok(Self {
            time_s: time_s.clone(),
            held: pressures.iter().map(held).collect(),
            pressures,
            angle: angle_rad.clone(),
            torque: torque_nm.clone(),
            smoothed,
            speed,
            thresholds: Thresholds::try_new(&List::from_iter(reaches()))?,
            known,
            parts: recording.parts().collect(),
            scored: scored.clone(),
        })
    }

    /// Whether a joint is where it was measured at each row, rather than simulated: until rows
    /// count, in each recording, it is being filled; and where rows of the recording are history
    /// only, up to the first one behind.
    pub(super) fn is_given(&self, counts: &[bool]) -> Vec<bool> {
        let first = |part: &Range<usize>| {
            let counted = part.clone().find(|row| counts[*row]);
            (part.clone(), counted.unwrap_or(part.end))
        };
        let is_history = |row: usize| !self.scored[row] || row > 0 && !self.scored[row - 1];
        (self.parts.iter().map(first))
            .flat_map(|(part, first)| part.map(move |row| row <= first || is_history(row)))
            .collect()
    }

    pub(super) fn parameters(&self, unknowns: &Unknowns) -> HostJointParameters {
        parameters(unknowns, &self.known)
    }

    pub(super) fn joint(&self, unknowns: &Unknowns) -> Result<HostJoint, JointError> {
        Ok(HostJoint::try_new(&self.parameters(unknowns))?)
    }

    /// The stops of a joint at a row, as measured angle and pressures have turned them.
    pub(super) fn stops_at(&self, row: usize, joint: &HostJoint) -> Stops<f64, { recording::joint::STOPS }> {
        let mut memory = Stops::relaxed(self.smoothed[0]);
        for (angle, held) in self.smoothed.iter().zip(&self.held).take(row + 1) {
            joint.turn(&mut memory, *angle, *held);
        }
        memory
    }

    /// Turns the stops of a joint from the row before to an angle (rad) in this one.
    pub(super) fn turn(
        &self,
        row: usize,
        joint: &HostJoint,
        stops: &mut Stops<f64, { recording::joint::STOPS }>,
        angle: f64,
    ) {
        joint.turn(stops, angle, self.held[row]);
    }

    /// The same to where it was measured.
    pub(super) fn turn_as_measured(
        &self,
        row: usize,
        joint: &HostJoint,
        stops: &mut Stops<f64, { recording::joint::STOPS }>,
    ) {
        self.turn(row, joint, stops, self.smoothed[row]);
    }

    /// What each linear unknown does to the torque, at every row.
    pub(super) fn features<'a>(&'a self, shape: &'a Shape) -> impl Iterator<Item = [f64; LINEAR]> + 'a {
        let mut memory = Stops::relaxed(self.smoothed[0]);
        let of = |muscle: usize, pressure: f64| {
            drive_and_slip(shape, &self.known.muscles[muscle], muscle, pressure)
        };
        (0..self.smoothed.len()).map(move |row| {
            let factors = [0, 1].map(|muscle| of(muscle, self.held[row][muscle]).1);
            self.thresholds.turn(&mut memory, self.smoothed[row], factors);
            let drives = [0, 1].map(|muscle| of(muscle, self.pressures[row][muscle]).0);
            features((self.smoothed[row], self.speed[row]), &memory, drives)
        })
    }

    /// The largest of what is not linear.
    pub(super) fn largest(&self) -> Shape {
        let knee = |muscle: usize| {
            let [first, last] = self.known.muscles[muscle].lowest;
            LARGEST_KNEE * first.min(last).max(0.0).powi(2)
        };
        [knee(0), knee(1), 1.0, 1.0]
    }
}

/// The unknowns whose torque is nearest to that from outside in the rows of `counts`.
pub(super) fn solve(rows: &Rows, counts: &[bool]) -> Result<Unknowns, JointError> {
    let mut weights = vec![1.0; counts.len()];
    let mut found = None;
    for _ in 0..2 {
        let of = |shape: &Shape, each: usize| linear(rows, counts, each, &weights, shape);
        let best = search(rows, |shape| of(shape, THINNED).map_or(f64::INFINITY, |(_, cost)| cost));
        let (unknowns, _) = of(&best, 1).ok_or(JointError::Singular)?;
        found = Some(unknowns);
        let joint = rows.joint(&unknowns)?;
        for row in (0..counts.len()).filter(|row| counts[*row]) {
            weights[row] = 1.0 / joint.stiffness(rows.smoothed[row], rows.pressures[row]);
        }
    }
    found.ok_or(JointError::Singular)
}

/// The same, where every row counts by its torque: none of it has to be a joint.
pub(super) fn of_torques(rows: &Rows, counts: &[bool]) -> Result<Unknowns, JointError> {
    let weights = vec![1.0; counts.len()];
    let of = |shape: &Shape, each: usize| linear(rows, counts, each, &weights, shape);
    let best = search(rows, |shape| of(shape, THINNED).map_or(f64::INFINITY, |(_, cost)| cost));
    of(&best, 1).map(|(unknowns, _)| unknowns).ok_or(JointError::Singular)
}

/// The linear unknowns for a given shape, by every Nth row that counts, and the sum of
/// squares.
fn linear(
    rows: &Rows,
    counts: &[bool],
    each: usize,
    weights: &[f64],
    shape: &Shape,
) -> Option<(Unknowns, f64)> {
    let (mut gram, mut moment) = (DMatrix::zeros(LINEAR, LINEAR), DVector::zeros(LINEAR));
    let mut square = 0.0;
    let used = rows.features(shape).enumerate().filter(|(row, _)| counts[*row]).step_by(each);
    for (row, features) in used {
        let features = DVector::from_row_slice(&features) * weights[row];
        let wanted = -rows.torque[row] * weights[row];
        gram.ger(1.0, &features, &features, 1.0);
        moment.axpy(wanted, &features, 1.0);
        square += wanted * wanted;
    }
    let lengths = gram.diagonal().map(|square: f64| if square > 0.0 { square.sqrt() } else { 1.0 });
    let scaled = gram.component_div(&(&lengths * lengths.transpose()));
    let scaled = scaled + DMatrix::identity(LINEAR, LINEAR) * RIDGE;
    let bounded: Vec<bool> = (0..LINEAR).map(is_bounded).collect();
    let values = nnls::solve(&scaled, &moment.component_div(&lengths), &bounded).values;
    let values = values.component_div(&lengths);
    let cost = square - 2.0 * values.dot(&moment) + values.dot(&(&gram * &values));
    let mut unknowns = [0.0; COUNT];
    unknowns[..LINEAR].copy_from_slice(values.as_slice());
    unknowns[LINEAR..].copy_from_slice(shape);
    cost.is_finite().then_some((unknowns, cost))
}

/// The shape of the least cost.
fn search(rows: &Rows, cost: impl Fn(&Shape) -> f64) -> Shape {
    let golden = 0.5 * (5.0_f64.sqrt() - 1.0);
    let largest = rows.largest();
    let mut shape = largest.map(|largest| 0.3 * largest);
    for _ in 0..ROUNDS {
        for place in 0..SHAPE {
            let at = |value: f64| {
                let mut trial = shape;
                trial[place] = value;
                cost(&trial)
            };
            let (mut low, mut high) = (0.0, largest[place]);
            let inner = |low: f64, high: f64| [high - golden * (high - low), low + golden * (high - low)];
            let [mut a, mut b] = inner(low, high);
            let [mut cost_a, mut cost_b] = [at(a), at(b)];
            for _ in 0..SECTIONS {
                if cost_a < cost_b {
                    (high, b, cost_b) = (b, a, cost_a);
                    a = inner(low, high)[0];
                    cost_a = at(a);
                } else {
                    (low, a, cost_a) = (a, b, cost_b);
                    b = inner(low, high)[1];
                    cost_b = at(b);
                }
            }
            shape[place] = if cost_a < cost_b { a } else { b };
        }
    }
    shape
}

/// The knees and slips of some unknowns are within what a joint may have.
pub(super) fn allows(rows: &Rows, unknowns: &Unknowns) -> bool {
    shape(unknowns).iter().zip(rows.largest()).all(|(value, largest)| *value <= largest)
}

/// Means over so many values to either side.
pub(super) fn averaged(values: &[f64], half: usize) -> Vec<f64> {
    let last = values.len() - 1;
    let mean = |at: usize| {
        // As many on one side as on the other, so that nothing comes late.
        let half = half.min(at).min(last - at);
        values[at - half..=at + half].iter().sum::<f64>() / (2 * half + 1) as f64
    };
    (0..=last).map(mean).collect()
}

/// Slopes of lines through so many values to either side.
fn slopes(times: &[f64], values: &[f64], half: usize) -> Vec<f64> {
    let last = values.len() - 1;
    let slope = |at: usize| {
        let (from, to) = (at.saturating_sub(half), (at + half).min(last));
        let count = (to - from + 1) as f64;
        let mean = |list: &[f64]| list[from..=to].iter().sum::<f64>() / count;
        let (time, value) = (mean(times), mean(values));
        let sums = (from..=to).fold((0.0, 0.0), |(up, along), row| {
            let by = times[row] - time;
            (up + by * (values[row] - value), along + by * by)
        });
        sums.0 / sums.1
    };
    (0..=last).map(slope).collect()
}
