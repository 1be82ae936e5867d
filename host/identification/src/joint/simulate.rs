//! The angle that a joint answers both pressures and a torque with, at rest at every row.

use recording::joint::HostJoint;

use super::balance::Rows;

/// How near 0 a torque has to be. Unit: N m.
const TOLERANCE: f64 = 1e-9;
/// Largest turn from row to row that is looked for. Unit: rad.
const FARTHEST: f64 = 0.5;
/// Bisection alone takes some 40 steps.
const STEPS: usize = 60;

/// The simulated angle of every row from the first of `counts` on, where the joint begins at the
/// measured one; before it the measured angle. So it is in each recording of several. Unit: rad.
pub(super) fn simulate(rows: &Rows, counts: &[bool], joint: &HostJoint) -> Vec<f64> {
    let begin = counts.iter().position(|counts| *counts).unwrap_or(0);
    let mut angles = rows.angle.clone();
    let mut stops = rows.stops_at(begin, joint);
    let mut angle = stops.angle();
    let mut slope = -joint.stiffness(angle, rows.pressures[begin]);
    let is_given = rows.is_given(counts);
    for (row, simulated) in angles.iter_mut().enumerate().skip(begin + 1) {
        if is_given[row] {
            rows.turn_as_measured(row, joint, &mut stops);
            angle = stops.angle();
            slope = -joint.stiffness(angle, rows.pressures[row]);
            continue;
        }
        let step_s = rows.time_s[row] - rows.time_s[row - 1];
        let last = angle;
        let surplus = |angle: f64| {
            let mut turned = stops.clone();
            rows.turn(row, joint, &mut turned, angle);
            joint.torque(angle, (angle - last) / step_s, &turned, rows.pressures[row]) + rows.torque[row]
        };
        let (mut low, mut high) = (last - FARTHEST, last + FARTHEST);
        let mut f = surplus(angle);
        for _ in 0..STEPS {
            if f.abs() <= TOLERANCE {
                break;
            }
            if f > 0.0 {
                low = angle;
            } else {
                high = angle;
            }
            let secant = angle - f / slope;
            let next = if low < secant && secant < high { secant } else { 0.5 * (low + high) };
            let f_next = surplus(next);
            if next == angle {
                break;
            }
            let found = (f_next - f) / (next - angle);
            if found < 0.0 {
                slope = found;
            }
            (angle, f) = (next, f_next);
        }
        rows.turn(row, joint, &mut stops, angle);
        *simulated = angle;
    }
    angles
}

/// Root mean square of simulated less measured angle over the rows of `counts`. Unit: rad.
pub(super) fn rmse(rows: &Rows, counts: &[bool], simulated: &[f64]) -> f64 {
    let errors = rows.angle.iter().zip(simulated).zip(counts).filter(|(_, counts)| **counts);
    let squares: Vec<f64> = errors.map(|((angle, simulated), _)| (simulated - angle).powi(2)).collect();
    (squares.iter().sum::<f64>() / squares.len() as f64).sqrt()
}
