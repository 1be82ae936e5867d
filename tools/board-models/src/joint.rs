//! A joint with as many stops as a board takes, for what a tick costs at most.

use model_core::List;
use model_core::joint::{JointParameters, PullParameters};
use model_core::pid::PidParameters;
use wire::joint::{BoardJointParameters, STOPS};

/// The controller of a joint that turns by 30 degrees to either side, each muscle with a torque of
/// some 7 N m/bar; the gains are those that `mgpi pil --joint` gives it.
pub fn joint_parameters() -> BoardJointParameters {
    let mut reaches = List::new();
    let mut friction = List::new();
    for stop in 0..STOPS {
        // Reaches from 0.005 rad on, each a third larger than the one before.
        let reach = 0.005 * (0..stop).fold(1.0_f32, |reach, _| reach * 4.0 / 3.0);
        // The list has room for so many.
        let _ = (reaches.push(reach), friction.push(1.0));
    }
    let muscle = |sign: f32| PullParameters {
        arm: [7.0, -3.0 * sign, -2.0],
        knee: 0.1,
        friction: friction.clone(),
        slip: [0.2, 0.25],
        lowest: [1.0, 1.0],
        highest: [6.0, 6.0],
        valve_lag_s: 0.05,
    };
    BoardJointParameters {
        joint: JointParameters {
            muscles: [muscle(1.0), muscle(-1.0)],
            passive: [0.0, 10.0, 0.0, 1.0],
            viscosity: 0.1,
            reaches,
            swing: 0.05,
            angles: (-0.5, 0.5),
        },
        pid: PidParameters { kp: 0.1, ki: 8.0, kd: 0.0, derivative_filter_s: 0.02, tracking_time_s: 0.2 },
        turn_rad_per_s: 2.0,
        stiffen_per_s: 30.0,
        slew_bar_per_s: 50.0,
        period_s: 1e-3,
    }
}
