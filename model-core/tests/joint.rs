//! Two muscles at a joint: torque and stiffness by the two equations, bounds, and the controller
//! in a loop with the joint that it is a model of.

use model_core::joint::stops::Stops;
use model_core::joint::{
    Joint, JointControl, JointControlParameters, JointParameters, JointTarget, PullParameters,
};
use model_core::pid::PidParameters;
use model_core::{InputError, List};

const STOPS: usize = 4;
const PERIOD_S: f64 = 0.001;

/// A joint whose muscles differ, with friction that grows with the pressure.
fn joint() -> JointParameters<f64, STOPS> {
    let list = |numbers: [f64; STOPS]| List::from(numbers);
    let muscle = |strength: f64, turn: f64, friction: [f64; STOPS]| PullParameters {
        arm: [7.0 * strength, -3.5 * turn * strength, -0.6],
        knee: 0.3,
        friction: list(friction),
        slip: [0.2, 0.25],
        lowest: [2.0 - 0.4 * turn, 2.0 + 0.4 * turn],
        highest: [5.0 - 0.5 * turn, 5.0 + 0.5 * turn],
        valve_lag_s: 0.05,
    };
    JointParameters {
        muscles: [muscle(1.0, 1.0, [7.0, 4.5, 2.5, 0.8]), muscle(1.1, -1.0, [7.5, 4.0, 2.0, 0.7])],
        passive: [-1.0, 4.0, 0.3, 1.0],
        viscosity: 0.3,
        reaches: list([0.01, 0.03, 0.1, 0.3]),
        swing: 0.05,
        angles: (-0.4, 0.4),
    }
}

fn control(joint: JointParameters<f64, STOPS>) -> JointControlParameters<f64, STOPS> {
    JointControlParameters {
        joint,
        pid: PidParameters { kp: 0.1, ki: 8.0, kd: 0.0, derivative_filter_s: 0.02, tracking_time_s: 0.2 },
        turn_rad_per_s: 1.6,
        stiffen_per_s: 30.0,
        slew_bar_per_s: 50.0,
        period_s: PERIOD_S,
    }
}

/// The angle at which the joint is at rest under pressures, the stops turned to there.
fn rest(joint: &Joint<f64, STOPS>, stops: &mut Stops<f64, STOPS>, pressures: [f64; 2]) -> f64 {
    let before = stops.clone();
    let (mut low, mut high) = (-1.0, 1.0);
    for _ in 0..60 {
        let middle = 0.5 * (low + high);
        let mut turned = before.clone();
        joint.turn(&mut turned, middle, pressures);
        if joint.torque(middle, 0.0, &turned, pressures) > 0.0 { low = middle } else { high = middle }
    }
    joint.turn(stops, low, pressures);
    low
}

#[test]
fn pressures_of_the_controller_bring_about_the_torque_and_the_stiffness_that_are_asked_for() {
    // Without feedback: friction goes by what the feed-forward has brought the pressures to.
    let pid = PidParameters { kp: 0.0, ki: 0.0, ..control(joint()).pid };
    let parameters = JointControlParameters { pid, ..control(joint()) };
    let control = JointControl::try_new(&parameters).expect("a controller");
    let valid = control.joint();
    for (angle, load) in [(-0.3, 0.0), (0.0, 2.0), (0.25, -3.0)] {
        let (soft, stiff) = valid.stiffness_range(angle);
        assert!(stiff > 1.3 * soft && soft > 0.0, "{soft} to {stiff} N m/rad");
        let target = JointTarget { angle, stiffness: 0.5 * (soft + stiff), load };
        let mut state = control.rest_state(0.0);
        let mut stops = Stops::relaxed(0.0);
        let mut command = None;
        // Friction goes by the pressures of the sample before: at first the lowest ones.
        let mut held = valid.muscles().each_ref().map(|muscle| muscle.bounds(0.0).0);
        for _ in 0..1000 {
            command = control.step(&mut state, &target, angle).ok();
            valid.turn(&mut stops, state.due(), held);
            held = command.as_ref().map_or(held, |command| command.pressures);
        }
        let command = command.expect("finite");
        let torque = valid.torque(angle, 0.0, &stops, command.pressures);
        let reached = valid.stiffness(angle, command.pressures);
        assert!(command.is_as_stiff && (command.due - angle).abs() < 1e-9);
        assert!((reached - target.stiffness).abs() < 1e-6, "{reached} N m/rad");
        assert!((torque + load).abs() < 1e-6, "{torque} N m against {load} N m");
    }
}

#[test]
fn controller_tracks_the_joint_of_its_model_and_stiffness_steps_do_not_turn_it() {
    let parameters = control(joint());
    let control = JointControl::try_new(&parameters).expect("a controller");
    let valid = control.joint().clone();
    let (mut state, mut stops) = (control.rest_state(0.0), Stops::relaxed(0.0));
    let (soft, stiff) = valid.stiffness_range(0.0);
    let (mut pressures, mut angle) = ([0.01, 0.01], 0.0);
    let (mut worst, mut turned) = (0.0_f64, 0.0_f64);
    let share = 1.0 - (-PERIOD_S / 0.05_f64).exp();
    for tick in 0..20_000 {
        let time_s = f64::from(tick) * PERIOD_S;
        // Filled for two seconds, then it swings, then it is stiffened and softened.
        let wanted = if (2.0..12.0).contains(&time_s) { 0.25 * (0.628 * (time_s - 2.0)).sin() } else { 0.0 };
        let level = if time_s > 14.0 && (time_s as i64 % 2) == 0 { 0.9 } else { 0.1 };
        let target = JointTarget { angle: wanted, stiffness: soft + level * (stiff - soft), load: 0.0 };
        let command = control.step(&mut state, &target, angle).expect("finite");
        for (pressure, command) in pressures.iter_mut().zip(command.commands) {
            *pressure += share * (command - *pressure);
        }
        if time_s > 1.0 {
            for (muscle, pressure) in valid.muscles().iter().zip(pressures) {
                let (lowest, highest) = muscle.bounds(command.due);
                assert!(
                    pressure > lowest - 0.05 && pressure < highest + 0.05,
                    "{pressure} bar at {time_s} s"
                );
            }
            angle = rest(&valid, &mut stops, pressures);
        }
        if (2.5..12.0).contains(&time_s) {
            worst = worst.max((angle - command.due).abs());
        }
        if time_s > 13.5 {
            turned = turned.max(angle.abs());
        }
    }
    assert!(worst < 0.004, "{worst} rad of 0.8");
    assert!(turned < 0.002, "{turned} rad of 0.8");
}

#[test]
fn what_cannot_be_reached_is_answered_within_the_bounds_and_the_angle_goes_before_the_stiffness() {
    let control = JointControl::try_new(&control(joint())).expect("a controller");
    let muscles = control.joint().muscles();
    let within = |angle, pressures: [f64; 2]| {
        muscles.iter().zip(pressures).all(|(muscle, pressure)| {
            let (lowest, highest) = muscle.bounds(angle);
            pressure > lowest - 1e-9 && pressure < highest + 1e-9
        })
    };
    for (stiffness, load, limited) in
        [(1e4, 0.0, false), (0.0, 0.0, false), (50.0, 40.0, true), (50.0, -40.0, true)]
    {
        let mut state = control.rest_state(0.1);
        let target = JointTarget { angle: 0.1, stiffness, load };
        let mut last = None;
        for _ in 0..2000 {
            last = control.step(&mut state, &target, 0.1).ok();
        }
        let last = last.expect("finite");
        assert!(
            within(0.1, last.pressures) && !last.is_as_stiff,
            "{stiffness} N m/rad, {load} N m: {last:?}"
        );
        assert_eq!(last.limited, limited, "{stiffness} N m/rad, {load} N m: {last:?}");
    }
}

#[test]
fn a_value_that_is_not_finite_is_refused_and_leaves_no_trace() {
    let control = JointControl::try_new(&control(joint())).expect("a controller");
    let mut state = control.rest_state(0.0);
    let good = JointTarget { angle: 0.1, stiffness: 50.0, load: 0.0 };
    control.step(&mut state, &good, 0.0).expect("finite");
    let before = state.clone();
    for (target, angle) in [
        (JointTarget { angle: f64::NAN, ..good }, 0.0),
        (JointTarget { stiffness: f64::INFINITY, ..good }, 0.0),
        (JointTarget { load: f64::NAN, ..good }, 0.0),
        (good, f64::NEG_INFINITY),
    ] {
        assert_eq!(control.step(&mut state, &target, angle), Err(InputError::NotFinite));
        assert_eq!(state, before);
    }
}

#[test]
fn parameters_that_make_no_joint_are_refused_by_name() {
    let refused = |change: &dyn Fn(&mut JointParameters<f64, STOPS>)| {
        let mut parameters = joint();
        change(&mut parameters);
        Joint::try_new(&parameters).expect_err("no joint").parameter
    };
    assert_eq!(refused(&|joint| joint.muscles[0].arm[0] = -7.0), "arm less friction");
    assert_eq!(refused(&|joint| joint.muscles[1].lowest = [0.1, 0.1]), "lowest");
    assert_eq!(refused(&|joint| joint.muscles[1].highest = [1.0, 1.0]), "lowest");
    assert_eq!(refused(&|joint| joint.muscles[0].valve_lag_s = 0.0), "valve_lag_s");
    assert_eq!(refused(&|joint| joint.muscles[0].friction = List::new()), "friction");
    assert_eq!(refused(&|joint| joint.muscles[1].friction[0] = -0.1), "friction");
    assert_eq!(refused(&|joint| joint.muscles[1].slip = [-0.1, 0.5]), "slip");
    assert_eq!(refused(&|joint| joint.muscles[1].slip = [0.0, 0.0]), "slip");
    assert_eq!(refused(&|joint| joint.muscles[0].slip = [0.0, 50.0]), "arm less friction");
    assert_eq!(refused(&|joint| joint.reaches[1] = 0.001), "reaches");
    assert_eq!(refused(&|joint| joint.angles = (0.4, -0.4)), "angle range");
    assert_eq!(refused(&|joint| joint.muscles[0].arm[1] = 20.0), "arm less friction");
    assert_eq!(
        refused(&|joint| joint.muscles.iter_mut().for_each(|muscle| muscle.arm[1] *= -2.0)),
        "stiffening"
    );
}

#[test]
fn single_precision_asks_for_the_same_pressures() {
    let double = control(joint());
    let single = JointControlParameters::<f32, STOPS> {
        joint: double.joint.convert().expect("the same capacity"),
        pid: PidParameters { kp: 0.1, ki: 8.0, kd: 0.0, derivative_filter_s: 0.02, tracking_time_s: 0.2 },
        turn_rad_per_s: 1.6,
        stiffen_per_s: 30.0,
        slew_bar_per_s: 50.0,
        period_s: PERIOD_S as f32,
    };
    let (double, single) =
        (JointControl::try_new(&double).expect("valid"), JointControl::try_new(&single).expect("valid"));
    let (mut state, mut state32) = (double.rest_state(0.0), single.rest_state(0.0));
    for tick in 0..5000 {
        let angle = 0.3 * (f64::from(tick) * 0.002).sin();
        let target = JointTarget { angle, stiffness: 50.0, load: 0.0 };
        let target32 = JointTarget { angle: angle as f32, stiffness: 50.0, load: 0.0 };
        let one = double.step(&mut state, &target, angle).expect("finite").pressures;
        let other = single.step(&mut state32, &target32, angle as f32).expect("finite").pressures;
        for (one, other) in one.iter().zip(other) {
            assert!((one - f64::from(other)).abs() < 1e-3, "{one} and {other} bar at tick {tick}");
        }
    }
}
