//! What only the pair shows, at joints of the rig: sound ones never trip it, however they are
//! driven and loaded, and a sensor that stops in the middle of a motion is seen.

use board_client::joint::run::PERIOD_S;
use board_client::joint::{JointMeasured, JointPlant, JointWanted, Loop, parameters};
use board_client::pil::PilError;
use board_client::stop::Stop;
use host_tests::joint::{HostJoint, Wired, Wrong, identified};
use rayon::prelude::*;
use recording::joint::file::JointFile;
use wire::joint::JointFault;
use wire::{Fault, Protection};

/// Joints that nothing was chosen by.
const SEEDS: std::ops::RangeInclusive<u64> = 201..=206;

/// A joint with a torque from outside that nobody has told, and a sensor that stops.
struct Loaded<'a> {
    joint: Wired,
    load_nm: &'a (dyn Fn(f64) -> f64 + Sync),
    begins_s: f64,
    freezes_s: f64,
}

impl JointPlant for Loaded<'_> {
    fn advance(&mut self, time_s: f64, commands_bar: [f32; 2]) -> Result<JointMeasured, PilError> {
        self.joint.put_on((self.load_nm)((time_s - self.begins_s).max(0.0)));
        if time_s > self.begins_s + self.freezes_s {
            self.joint.wrong = Wrong::Frozen;
        }
        self.joint.advance(time_s, commands_bar)
    }
}

/// What a joint is driven by, over the time since it has started.
struct Course<'a> {
    /// Share of the angles from the middle: -0.5 to 0.5.
    angle: &'a (dyn Fn(f64) -> f64 + Sync),
    /// Share of the stiffnesses that it can have.
    stiffness: &'a (dyn Fn(f64) -> f64 + Sync),
    /// Unit: N m.
    load_nm: &'a (dyn Fn(f64) -> f64 + Sync),
    freezes_s: f64,
    duration_s: f64,
}

/// Drives the joint of a seed; the fault that has ended it, and when, if one has. Unit: s.
fn driven(file: &JointFile, seed: u64, course: &Course<'_>) -> Option<(f64, JointFault)> {
    let control = parameters(&file.parameters, PERIOD_S).expect("a joint in single precision");
    let (lowest, highest) = file.parameters.angles;
    let (middle, range) = (0.5 * (lowest + highest), highest - lowest);
    let (soft, stiff) = file.joint.stiffness_range(middle);
    let wanted = |time_s: f64| JointWanted {
        angle_deg: (middle + range * (course.angle)(time_s)).to_degrees(),
        stiffness: soft + (course.stiffness)(time_s) * (stiff - soft),
        torque_nm: 0.0,
    };
    // A start and an approach take so long.
    let begins_s = 14.0;
    let mut plant = Loaded {
        joint: Wired::new(seed, Wrong::Nothing),
        load_nm: course.load_nm,
        begins_s,
        freezes_s: course.freezes_s,
    };
    let mut board = HostJoint::new(Protection::STANDARD);
    let mut joint = Loop::new((&control, None), &mut board, &mut plant, Stop::default()).expect("configured");
    joint.start(&wanted(0.0)).expect("the joint of the model");
    joint.approach(&wanted(0.0)).expect("it follows");
    let ticks = (course.duration_s / PERIOD_S) as usize;
    match joint.follow((0..ticks).map(|tick| wanted(tick as f64 * PERIOD_S)), |_, _| ()) {
        Ok(_) => None,
        Err(PilError::Joint { time_s, fault }) => Some((time_s - begins_s, fault)),
        Err(other) => panic!("{other}"),
    }
}

fn triangle(time_s: f64) -> f64 {
    1.0 - 4.0 * ((time_s + 0.25).rem_euclid(1.0) - 0.5).abs()
}

fn joints() -> Vec<(u64, JointFile)> {
    SEEDS.into_par_iter().map(|seed| (seed, identified(seed).expect("identified"))).collect()
}

const NEVER: f64 = f64::INFINITY;

#[test]
fn a_sound_joint_trips_nothing_and_a_sensor_that_stops_while_it_turns_is_seen() {
    let joints = joints();
    let steps = |share: f64, period_s: f64| {
        move |time_s: f64| if ((time_s / period_s) as u64).is_multiple_of(2) { -share } else { share }
    };
    let soft_and_stiff = |time_s: f64| 0.5 + steps(0.4, 1.7)(time_s);
    let ends = steps(0.45, 2.0);
    let inner = steps(0.2, 2.0);
    let degree = |time_s: f64| 0.02 * triangle(time_s / 8.0);
    let fast = |time_s: f64| 0.35 * (std::f64::consts::TAU * time_s).sin();
    let (aside, still) = (|_: f64| 0.3, |_: f64| -0.1);
    let wide = |time_s: f64| 0.3 * triangle(time_s / 10.0);
    let half = |_: f64| 0.5;
    let none = |_: f64| 0.0;
    // Torques that nobody tells: slowly to and fro, by what a joint holds at a still reference, and
    // a push each four seconds.
    let slow = |time_s: f64| 4.0 * triangle(time_s / 16.0);
    let pushes = |time_s: f64| [0.0, 3.0, 0.0, -3.0][(time_s / 2.0) as usize % 4];
    let sound: [(&str, Course<'_>); 6] = [
        ("steps from end to end", course(&ends, &soft_and_stiff, &none, 24.0)),
        ("slow, by a degree", course(&degree, &half, &none, 24.0)),
        ("fast", course(&fast, &half, &none, 16.0)),
        ("still, stiffness steps", course(&aside, &soft_and_stiff, &none, 20.0)),
        ("still, a torque grows", course(&still, &half, &slow, 32.0)),
        ("slow, pushed", course(&wide, &half, &pushes, 24.0)),
    ];
    for (name, course) in &sound {
        let ended: Vec<_> = joints.par_iter().map(|(seed, file)| driven(file, *seed, course)).collect();
        assert!(ended.iter().all(Option::is_none), "{name}: {ended:?}");
    }
    for (name, angle) in [
        ("to and fro", &(|time_s: f64| 0.3 * triangle(time_s / 8.0)) as &(dyn Fn(f64) -> f64 + Sync)),
        ("steps", &inner),
    ] {
        let stops = Course { freezes_s: 3.3, ..course(angle, &half, &none, 12.0) };
        for (seed, file) in &joints {
            let (time_s, fault) = driven(file, *seed, &stops).expect("it is seen");
            println!("{seed}, {name}: {fault} {:.2} s behind", time_s - stops.freezes_s);
            assert_eq!(fault, JointFault::AngleStuck, "{seed}, {name}");
            assert!(time_s - stops.freezes_s < 3.0, "{seed}, {name}: {time_s} s");
        }
    }
}

#[test]
fn a_torque_that_is_too_large_for_a_joint_ends_by_the_authority_of_its_feedback() {
    let joints = joints();
    let heavy = |time_s: f64| (8.0 * time_s).min(30.0);
    let (still, half) = (|_: f64| 0.0, |_: f64| 0.5);
    for (seed, file) in &joints {
        let (time_s, fault) = driven(file, *seed, &course(&still, &half, &heavy, 12.0)).expect("it is seen");
        println!("{seed}: {fault} after {time_s:.2} s");
        assert_eq!(fault, JointFault::OfBoard(Fault::Authority), "{seed}");
    }
}

fn course<'a>(
    angle: &'a (dyn Fn(f64) -> f64 + Sync),
    stiffness: &'a (dyn Fn(f64) -> f64 + Sync),
    load_nm: &'a (dyn Fn(f64) -> f64 + Sync),
    duration_s: f64,
) -> Course<'a> {
    Course { angle, stiffness, load_nm, freezes_s: NEVER, duration_s }
}
