//! A joint's parameters as a list of numbers, and what each of the linear ones does to the torque.

use model_core::List;
use model_core::joint::{ARM, PASSIVE, PullParameters};
use recording::joint::HostJointParameters;

use super::STOPS;

/// Places in the list: both arms, the passive torque, viscosity, friction without and with the
/// pressure of either muscle, and the knees behind all that is linear.
const ARMS: [usize; 2] = [0, ARM];
const REST: usize = 2 * ARM;
const VISCOSITY: usize = REST + PASSIVE;
const DRY: usize = VISCOSITY + 1;
const FRICTION: [usize; 2] = [DRY + STOPS, DRY + 2 * STOPS];
/// Number of those that are linear.
pub(super) const LINEAR: usize = DRY + 3 * STOPS;
/// Number of all.
pub(super) const COUNT: usize = LINEAR + 2;

/// A point in the space of the unknowns.
pub(super) type Unknowns = [f64; COUNT];

/// Whether one of them may not be negative.
pub(super) fn is_bounded(place: usize) -> bool {
    place >= VISCOSITY
}

/// What each linear unknown does to the torque at an angle (rad), a speed (rad/s), with the stops
/// there (rad), under both drives (bar).
pub(super) fn features(angle: f64, speed: f64, stops: &[f64; STOPS], drives: [f64; 2]) -> [f64; LINEAR] {
    let mut features = [0.0; LINEAR];
    for (muscle, sign) in [1.0, -1.0].into_iter().enumerate() {
        for power in 0..ARM {
            features[ARMS[muscle] + power] = sign * drives[muscle] * angle.powi(power as i32);
        }
        for (place, stop) in stops.iter().enumerate() {
            features[FRICTION[muscle] + place] = -drives[muscle] * stop;
        }
    }
    for power in 0..PASSIVE {
        features[REST + power] = -angle.powi(power as i32);
    }
    features[VISCOSITY] = -speed;
    for (place, stop) in stops.iter().enumerate() {
        features[DRY + place] = -stop;
    }
    features
}

/// The knees of both muscles. Unit: bar².
pub(super) fn knees(unknowns: &Unknowns) -> [f64; 2] {
    [unknowns[LINEAR], unknowns[LINEAR + 1]]
}

/// The parameters of a joint; what is not unknown is that of `known`.
pub(super) fn parameters(unknowns: &Unknowns, known: &HostJointParameters) -> HostJointParameters {
    let list = |from: usize| List::try_from_iter(unknowns[from..from + STOPS].iter().copied()).unwrap_or_default();
    let muscle = |place: usize| PullParameters {
        arm: std::array::from_fn(|power| unknowns[ARMS[place] + power]),
        knee: knees(unknowns)[place],
        friction: list(FRICTION[place]),
        ..known.muscles[place].clone()
    };
    HostJointParameters {
        muscles: [muscle(0), muscle(1)],
        passive: std::array::from_fn(|power| unknowns[REST + power]),
        viscosity: unknowns[VISCOSITY],
        dry: list(DRY),
        ..known.clone()
    }
}
