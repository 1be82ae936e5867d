//! Whether a recording is a joint's, and enough of one.
//!
//! Over all rows that count the angle is fitted by both pressures and the torque, a plane. Friction
//! makes that poor, but not its signs: the angle rises with the first muscle's pressure and with
//! the torque, and falls with the second one's. Other signs have a cause.

use std::f64::consts::PI;
use std::fmt;

use nalgebra::{DMatrix, DVector};
use recording::joint::columns::JointRecording;

use super::JointError;
use super::unknowns::COUNT;

/// Fewest rows for each unknown.
const ROWS: usize = 20;
/// Least span of the angle. Unit: rad.
const LEAST_ANGLE: f64 = 4.0 * PI / 180.0;
/// Least span of the sum and of the difference of both pressures. Unit: bar.
const LEAST_BAR: f64 = 0.5;
/// Least span of the torque. Unit: N m.
const LEAST_NM: f64 = 0.05;

/// Whether the angle rises with something.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Sign {
    Rises,
    Falls,
}

use Sign::{Falls, Rises};

/// What signs a joint has: with the pressures of both muscles, and with the torque.
const RIGHT: [Sign; 3] = [Rises, Falls, Rises];

/// Says what is wrong with signs that are not those of a joint.
pub(super) fn explain(signs: &[Sign; 3], f: &mut fmt::Formatter<'_>) -> fmt::Result {
    let [a, b, torque] = signs.map(|sign| if sign == Rises { "rises" } else { "falls" });
    write!(f, "the angle {a} with pressure_a_bar, {b} with pressure_b_bar and {torque} with the torque: ")?;
    f.write_str(match signs {
        [Falls, Rises, Falls] => "the angle sensor counts backwards; take the negative of angle_deg",
        [Falls, Rises, Rises] => {
            "the channels are swapped; name pressure_a_bar and command_a_bar those of the muscle that turns the \
             joint to larger angles"
        }
        [Rises, Falls, Falls] => "the torque has the other sign; it is positive towards larger angles",
        _ => "these are not two muscles that pull against each other; is one of the columns that of another channel?",
    })
}

/// Checks a recording.
pub(super) fn check(recording: &JointRecording) -> Result<(), JointError> {
    let JointRecording { pressures_bar: [a, b], angle_rad, torque_nm, scored, .. } = recording;
    let rows: Vec<usize> = (0..scored.len()).filter(|row| scored[*row]).collect();
    let needed = ROWS * COUNT;
    if rows.len() < needed {
        return Err(JointError::TooFewRows { rows: rows.len(), needed });
    }
    let span = |of: &dyn Fn(usize) -> f64| {
        let (low, high) = (rows.iter())
            .map(|row| of(*row))
            .fold((f64::MAX, f64::MIN), |(low, high), value| (low.min(value), high.max(value)));
        high - low
    };
    let moves = |what, span: f64, least: f64, unit, shown: f64| {
        let refused = JointError::Still { what, span: span * shown, least: least * shown, unit };
        if span < least { Err(refused) } else { Ok(()) }
    };
    moves("angle_deg", span(&|row| angle_rad[row]), LEAST_ANGLE, "degrees", 180.0 / PI)?;
    moves("the sum of both pressures", span(&|row| a[row] + b[row]), LEAST_BAR, "bar", 1.0)?;
    moves("the difference of both pressures", span(&|row| a[row] - b[row]), LEAST_BAR, "bar", 1.0)?;
    moves("torque_newton_metre", span(&|row| torque_nm[row]), LEAST_NM, "N m", 1.0)?;

    let features = |row: usize| [1.0, a[row], b[row], torque_nm[row]];
    let (mut gram, mut moment) = (DMatrix::zeros(4, 4), DVector::zeros(4));
    for row in rows {
        let features = DVector::from_row_slice(&features(row));
        gram.ger(1.0, &features, &features, 1.0);
        moment.axpy(angle_rad[row], &features, 1.0);
    }
    let plane = gram.cholesky().ok_or(JointError::Singular)?.solve(&moment);
    let signs = [1, 2, 3].map(|place| if plane[place] > 0.0 { Rises } else { Falls });
    if signs == RIGHT { Ok(()) } else { Err(JointError::Signs(signs)) }
}
