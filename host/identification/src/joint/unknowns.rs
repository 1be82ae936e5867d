//! A joint's parameters as a list of numbers, and what each of the linear ones does to the torque.

use model_core::List;
use model_core::joint::stops::Stops;
use model_core::joint::{ARM, PASSIVE, PullParameters};
use recording::joint::HostJointParameters;
use recording::joint::keys::{self, Key};

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
    let of = |section: &str, key: Key| (format!("{section}.{}", key.name), key.unit);
    let friction = |muscle: &'static str| {
        (0..STOPS).map(move |stop| {
            let (name, unit) = of(muscle, keys::FRICTION);
            (format!("{name}[{stop}]"), unit)
        })
    };
    let names = keys::MUSCLES
        .iter()
        .flat_map(|muscle| keys::ARM.map(|key| of(muscle, key)))
        .chain(keys::PASSIVE.map(|key| of(keys::REST, key)))
        .chain([of(keys::REST, keys::VISCOSITY)])
        .chain(keys::MUSCLES.into_iter().flat_map(friction))
        .chain(keys::MUSCLES.map(|muscle| of(muscle, keys::KNEE)))
        .chain(keys::MUSCLES.map(|muscle| of(muscle, keys::SLIP[0])));
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_unknown_has_the_name_and_the_place_of_its_parameter() {
        let named = named(&std::array::from_fn(|place| place as f64));
        assert_eq!(named.len(), COUNT);
        for (place, name, unit) in [
            (ARMS[1] + 1, "muscle_b.arm_linear_nm_per_bar_rad", "N m/(bar rad)"),
            (REST + 3, "passive.cube_nm_per_rad3", "N m/rad³"),
            (VISCOSITY, "passive.viscosity_nm_s_per_rad", "N m s/rad"),
            (FRICTION[1] + 2, "muscle_b.friction_nm_per_rad[2]", "N m/rad"),
            (LINEAR + 1, "muscle_b.knee_bar2", "bar²"),
            (LINEAR + 2, "muscle_a.slip_constant", "1"),
        ] {
            assert_eq!(named[place], (name.to_owned(), unit, place as f64));
        }
    }
}
