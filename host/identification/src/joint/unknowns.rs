//! A joint's parameters as a list of numbers, and what each of the linear ones does to the torque.

use model_core::List;
use model_core::joint::stops::Stops;
use model_core::joint::{ARM, PASSIVE, PullParameters};
use recording::joint::HostJointParameters;

use super::STOPS;

/// Places in the list: both arms, the passive torque, viscosity, the friction of either muscle, and
/// behind all that is linear the knees and what of the slips is constant.
const ARMS: [usize; 2] = [0, ARM];
const REST: usize = 2 * ARM;
const VISCOSITY: usize = REST + PASSIVE;
const FRICTION: [usize; 2] = [VISCOSITY + 1, VISCOSITY + 1 + STOPS];
/// Number of those that are linear.
pub(super) const LINEAR: usize = VISCOSITY + 1 + 2 * STOPS;
/// Number of all.
pub(super) const COUNT: usize = LINEAR + SHAPE;
/// Number of those that are not linear.
pub(super) const SHAPE: usize = 4;

/// A point in the space of the unknowns.
pub(super) type Unknowns = [f64; COUNT];

/// What the torque is not linear in: both knees (bar²), and of the slip of either muscle in the
/// middle of its drives, which is 1, the share that does not depend on the pressure.
pub(super) type Shape = [f64; SHAPE];

/// Whether one of them may not be negative.
pub(super) fn is_bounded(place: usize) -> bool {
    place >= VISCOSITY
}

/// A muscle as far as it is known before anything is solved for.
type Known = PullParameters<f64, { recording::joint::STOPS }>;

/// The drive of a pressure (bar) of a muscle, and the slip there.
pub(super) fn drive_and_slip(shape: &Shape, known: &Known, muscle: usize, pressure: f64) -> (f64, f64) {
    // Below where it is least, which is below every pressure that counts, a drive means nothing.
    let knee = shape[muscle];
    let pressure = pressure.max(knee.sqrt()).max(f64::MIN_POSITIVE);
    let drive = pressure + knee / pressure;
    let [constant, per_bar] = slip(shape, known, muscle);
    (drive, constant + per_bar * drive)
}

/// The slip of a muscle over its drive.
fn slip(shape: &Shape, known: &Known, muscle: usize) -> [f64; 2] {
    let middle = 0.25 * known.lowest.iter().chain(&known.highest).sum::<f64>();
    let constant = shape[2 + muscle];
    [constant, (1.0 - constant) / middle]
}

/// What each linear unknown does to the torque at an angle (rad), a speed (rad/s), with the stops
/// there (rad), under both drives (bar).
pub(super) fn features(
    (angle, speed): (f64, f64),
    stops: &Stops<f64, STOPS>,
    drives: [f64; 2],
) -> [f64; LINEAR] {
    let mut features = [0.0; LINEAR];
    for (muscle, sign) in [1.0, -1.0].into_iter().enumerate() {
        for power in 0..ARM {
            features[ARMS[muscle] + power] = sign * drives[muscle] * angle.powi(power as i32);
        }
        for (place, stop) in stops.moved()[muscle].iter().enumerate() {
            features[FRICTION[muscle] + place] = -stop;
        }
    }
    for power in 0..PASSIVE {
        features[REST + power] = -angle.powi(power as i32);
    }
    features[VISCOSITY] = -speed;
    features
}

/// Name, unit and value of each: the name in the model file behind that of its section.
pub(super) fn named(unknowns: &Unknowns) -> Vec<(String, &'static str, f64)> {
    const ARM_KEYS: [(&str, &str); ARM] = [
        ("arm_nm_per_bar", "N m/bar"),
        ("arm_linear_nm_per_bar_rad", "N m/(bar rad)"),
        ("arm_square_nm_per_bar_rad2", "N m/(bar rad²)"),
    ];
    const PASSIVE_KEYS: [(&str, &str); PASSIVE] = [
        ("constant_nm", "N m"),
        ("linear_nm_per_rad", "N m/rad"),
        ("square_nm_per_rad2", "N m/rad²"),
        ("cube_nm_per_rad3", "N m/rad³"),
    ];
    const MUSCLES: [&str; 2] = ["muscle_a", "muscle_b"];
    let names = MUSCLES
        .iter()
        .flat_map(|muscle| ARM_KEYS.map(|(key, unit)| (format!("{muscle}.{key}"), unit)))
        .chain(PASSIVE_KEYS.map(|(key, unit)| (format!("passive.{key}"), unit)))
        .chain([("passive.viscosity_nm_s_per_rad".to_owned(), "N m s/rad")])
        .chain(MUSCLES.iter().flat_map(|muscle| {
            (0..STOPS).map(move |stop| (format!("{muscle}.friction_nm_per_rad[{stop}]"), "N m/rad"))
        }))
        .chain(MUSCLES.iter().map(|muscle| (format!("{muscle}.knee_bar2"), "bar²")))
        .chain(MUSCLES.iter().map(|muscle| (format!("{muscle}.slip_constant"), "1")));
    names.zip(unknowns).map(|((name, unit), value)| (name, unit, *value)).collect()
}

/// Those that are not linear.
pub(super) fn shape(unknowns: &Unknowns) -> Shape {
    std::array::from_fn(|place| unknowns[LINEAR + place])
}

/// The parameters of a joint; what is not unknown is that of `known`.
pub(super) fn parameters(unknowns: &Unknowns, known: &HostJointParameters) -> HostJointParameters {
    let shape = shape(unknowns);
    let muscles = [0, 1].map(|muscle| PullParameters {
        arm: std::array::from_fn(|power| unknowns[ARMS[muscle] + power]),
        knee: shape[muscle],
        friction: List::from_iter((0..STOPS).map(|place| unknowns[FRICTION[muscle] + place])),
        slip: slip(&shape, &known.muscles[muscle], muscle),
        ..known.muscles[muscle].clone()
    });
    HostJointParameters {
        muscles,
        passive: std::array::from_fn(|power| unknowns[REST + power]),
        viscosity: unknowns[VISCOSITY],
        ..known.clone()
    }
}
