//! A joint's parameters as a list of numbers, and what each of the linear ones does to the torque.

use model_core::List;
use model_core::joint::{ARM, PASSIVE, PullParameters};
use recording::joint::HostJointParameters;

use super::STOPS;

/// Places in the list: both arms, the passive torque, viscosity, the friction of either muscle at
/// its lowest and at its highest drive, and the knees behind all that is linear. In this form
/// friction is not negative anywhere between if these are not.
const ARMS: [usize; 2] = [0, ARM];
const REST: usize = 2 * ARM;
const VISCOSITY: usize = REST + PASSIVE;
const FRICTION: [[usize; 2]; 2] = {
    let first = VISCOSITY + 1;
    [[first, first + STOPS], [first + 2 * STOPS, first + 3 * STOPS]]
};
/// Number of those that are linear.
pub(super) const LINEAR: usize = VISCOSITY + 1 + 4 * STOPS;
/// Number of all.
pub(super) const COUNT: usize = LINEAR + 2;

/// A point in the space of the unknowns.
pub(super) type Unknowns = [f64; COUNT];

/// Whether one of them may not be negative.
pub(super) fn is_bounded(place: usize) -> bool {
    place >= VISCOSITY
}

/// The drives between which a muscle's friction is: the ends of its pressures, and some more above
/// for the knee.
fn ends(muscle: &PullParameters<f64, { recording::joint::STOPS }>) -> [f64; 2] {
    let ([first, last], [before, behind]) = (muscle.lowest, muscle.highest);
    [first.min(last), 1.08 * before.max(behind)]
}

/// What each linear unknown does to the torque at an angle (rad), a speed (rad/s), with the stops
/// there (rad), under both drives (bar).
pub(super) fn features(
    (angle, speed): (f64, f64),
    stops: &[f64; STOPS],
    drives: [f64; 2],
    known: &HostJointParameters,
) -> [f64; LINEAR] {
    let mut features = [0.0; LINEAR];
    for (muscle, sign) in [1.0, -1.0].into_iter().enumerate() {
        for power in 0..ARM {
            features[ARMS[muscle] + power] = sign * drives[muscle] * angle.powi(power as i32);
        }
        let [low, high] = ends(&known.muscles[muscle]);
        let share = (drives[muscle] - low) / (high - low);
        for (place, stop) in stops.iter().enumerate() {
            let [at_low, at_high] = FRICTION[muscle];
            features[at_low + place] = -(1.0 - share) * stop;
            features[at_high + place] = -share * stop;
        }
    }
    for power in 0..PASSIVE {
        features[REST + power] = -angle.powi(power as i32);
    }
    features[VISCOSITY] = -speed;
    features
}

/// The knees of both muscles. Unit: bar².
pub(super) fn knees(unknowns: &Unknowns) -> [f64; 2] {
    [unknowns[LINEAR], unknowns[LINEAR + 1]]
}

/// The parameters of a joint; what is not unknown is that of `known`.
pub(super) fn parameters(unknowns: &Unknowns, known: &HostJointParameters) -> HostJointParameters {
    let mut dry = [0.0; STOPS];
    let muscles = [0, 1].map(|muscle| {
        let [low, high] = ends(&known.muscles[muscle]);
        let [at_low, at_high] = FRICTION[muscle];
        let mut friction = [0.0; STOPS];
        for place in 0..STOPS {
            let (first, last) = (unknowns[at_low + place], unknowns[at_high + place]);
            friction[place] = (last - first) / (high - low);
            dry[place] += first - friction[place] * low;
        }
        PullParameters {
            arm: std::array::from_fn(|power| unknowns[ARMS[muscle] + power]),
            knee: knees(unknowns)[muscle],
            friction: List::from_iter(friction),
            ..known.muscles[muscle].clone()
        }
    });
    HostJointParameters {
        muscles,
        passive: std::array::from_fn(|power| unknowns[REST + power]),
        viscosity: unknowns[VISCOSITY],
        dry: List::from_iter(dry),
        ..known.clone()
    }
}
