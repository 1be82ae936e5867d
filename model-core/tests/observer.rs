//! The disturbance observer in the tracking controller.

use model_core::paper::{self, SIZE};
use model_core::pid::PidParameters;
use model_core::{
    ExtensionParameters, Hysteresis, Mgpi, Mode, ModelParameters, ObserverParameters, Tracking,
    TrackingParameters,
};

const PERIOD_S: f64 = 1e-3;
/// Time constant of the valve in these tests. Unit: s.
const LAG_S: f64 = 0.02;

fn tracking(rate_per_s: f64) -> Tracking<f64, SIZE, SIZE> {
    let parameters = TrackingParameters {
        model: ModelParameters::Cascade(paper::mgpi().expect("valid")),
        extensions: ExtensionParameters::default(),
        pid: PidParameters { kp: 0.0, ki: 0.0, ..PidParameters::paper() },
        observer: ObserverParameters { rate_per_s },
        command_min: 0.0,
        command_max: 6.0,
        slew_bar_per_s: 1000.0,
        period_s: PERIOD_S,
    };
    Tracking::try_new(&parameters).expect("valid")
}

/// The commands and contractions of a muscle behind a valve, to which `disturbed` does what it
/// does, given the time (s) and the undisturbed contraction (mm).
fn run(
    tracking: &Tracking<f64, SIZE, SIZE>,
    mode: impl Fn(f64) -> Mode,
    seconds: f64,
    reference_mm: f64,
    disturbed: impl Fn(f64, f64) -> f64,
) -> Vec<(f64, f64)> {
    let muscle = Mgpi::<f64, SIZE, SIZE>::try_new(&paper::mgpi().expect("valid")).expect("valid");
    let (mut state, mut plant) = (tracking.rest_state(mode(0.0)), muscle.rest_state());
    let (mut pressure, mut command) = (0.0, 0.0);
    (0..(seconds / PERIOD_S) as u32)
        .map(|tick| {
            let time_s = f64::from(tick) * PERIOD_S;
            pressure += (command - pressure) * (1.0 - (-PERIOD_S / LAG_S).exp());
            let contraction = disturbed(time_s, muscle.step(&mut plant, pressure).expect("finite"));
            command =
                tracking.step(&mut state, mode(time_s), reference_mm, contraction).expect("finite").command;
            (command, contraction)
        })
        .collect()
}

#[test]
fn a_load_is_taken_back_with_the_rate_of_the_observer_and_without_it_stays() {
    let pushed = |time_s: f64, mm: f64| if time_s < 2.0 { mm } else { mm - 10.0 };
    let error_at = |rate, time_s: f64| {
        let run = run(&tracking(rate), |_| Mode::Both, 3.0, 60.0, pushed);
        (run[(time_s / PERIOD_S) as usize].1 - 60.0).abs()
    };
    assert!((error_at(0.0, 2.9) - 10.0).abs() < 0.1);
    // After three time constants a twentieth is left, and what the valve's lag and the hysteresis
    // add.
    assert!(error_at(10.0, 2.3) < 2.0, "{}", error_at(10.0, 2.3));
    assert!(error_at(10.0, 2.9) < 0.1, "{}", error_at(10.0, 2.9));
}

#[test]
fn the_estimate_does_not_grow_while_the_command_cannot_follow() {
    // For 2 s the muscle is held short of what it is asked for, with the valve wide open.
    let held = |time_s: f64, mm: f64| if time_s < 2.0 { mm.min(100.0) } else { mm };
    let run = run(&tracking(10.0), |_| Mode::Both, 3.0, 120.0, held);
    assert!(run[1900].0 > 5.99, "{:?}", run[1900]);
    // It is let go, and nothing has to be unwound: after half a second it is there.
    assert!((run[2500].1 - 120.0).abs() < 0.5, "{:?}", run[2500]);
}

#[test]
fn every_change_of_mode_is_without_a_jump() {
    let shifted = |_: f64, mm: f64| mm - 8.0;
    let modes = [Mode::Both, Mode::FeedforwardOnly, Mode::Both, Mode::Hold, Mode::Both, Mode::FeedbackOnly];
    let mode = |time_s: f64| modes[(time_s as usize).min(modes.len() - 1)];
    let run = run(&tracking(5.0), mode, 6.0, 60.0, shifted);
    for change in 1..modes.len() {
        let at = (change as f64 / PERIOD_S) as usize;
        let jump = (run[at].0 - run[at - 1].0).abs();
        assert!(jump < 0.01, "{:?} to {:?}: {jump} bar", modes[change - 1], modes[change]);
        let next = (run[at + 1].0 - run[at].0).abs();
        assert!(next < 0.01, "a tick behind {:?}: {next} bar", modes[change]);
    }
}

#[test]
fn what_it_adds_is_told_as_feedback() {
    let tracking = tracking(10.0);
    let (mut state, contraction) = (tracking.rest_state(Mode::Both), 40.0);
    let mut last = 0.0;
    for _ in 0..500 {
        let command = tracking.step(&mut state, Mode::Both, 50.0, contraction).expect("finite");
        assert!((command.feedforward + command.feedback - command.command).abs() < 0.5 || command.limited);
        last = command.feedback;
    }
    assert!(last > 0.5, "{last} bar");
}

#[test]
fn a_rate_that_is_negative_or_overtakes_the_error_is_refused() {
    for rate in [-1.0, 2000.0, f64::NAN] {
        let parameters = TrackingParameters::<f64, SIZE, SIZE> {
            model: ModelParameters::Cascade(paper::mgpi().expect("valid")),
            extensions: ExtensionParameters::default(),
            pid: PidParameters::paper(),
            observer: ObserverParameters { rate_per_s: rate },
            command_min: 0.0,
            command_max: 6.0,
            slew_bar_per_s: 1000.0,
            period_s: PERIOD_S,
        };
        assert_eq!(Tracking::try_new(&parameters).unwrap_err().parameter, "observer rate_per_s");
    }
}
