//! PID and tracking controller: each property that their documentation promises.

use model_core::pid::{Pid, PidParameters, PidState};
use model_core::{
    ExtensionParameters, Hysteresis, InputError, Mgpi, Mode, ModelParameters, ObserverParameters, Tracking,
    TrackingParameters, paper,
};

const SIZE: usize = paper::SIZE;
const PERIOD_S: f64 = 1e-3;

fn parameters(pid: PidParameters<f64>) -> TrackingParameters<f64, SIZE, SIZE> {
    TrackingParameters {
        model: ModelParameters::Cascade(paper::mgpi().expect("valid")),
        extensions: ExtensionParameters::default(),
        pid,
        observer: ObserverParameters::default(),
        command_min: 0.0,
        command_max: 6.0,
        slew_bar_per_s: 1000.0,
        period_s: PERIOD_S,
    }
}

fn tracking(pid: PidParameters<f64>) -> Tracking<f64, SIZE, SIZE> {
    Tracking::try_new(&parameters(pid)).expect("valid")
}

/// A raised cosine. Unit: mm.
fn reference(tick: usize) -> f64 {
    60.0 * (1.0 - (std::f64::consts::TAU * tick as f64 * PERIOD_S / 20.0).cos())
}

#[test]
fn on_its_own_model_the_feedforward_alone_tracks_exactly() {
    let tracking = tracking(PidParameters::paper());
    let plant = Mgpi::try_new(&paper::mgpi().expect("valid")).expect("valid");
    let (mut state, mut plant_state) = (tracking.rest_state(Mode::FeedforwardOnly), plant.rest_state());
    for tick in 0..20_000 {
        let command = tracking.step(&mut state, Mode::FeedforwardOnly, reference(tick), 0.0).expect("finite");
        let contraction = plant.step(&mut plant_state, command.command).expect("finite");
        let lowest = plant.step(&mut plant_state.clone(), 0.0).expect("finite");
        assert!((contraction - reference(tick).max(lowest)).abs() < 1e-9, "tick {tick}: {contraction} mm");
    }
}

#[test]
fn every_change_of_mode_is_bumpless_with_and_without_integral_gain() {
    let modes = [Mode::Both, Mode::FeedforwardOnly, Mode::FeedbackOnly, Mode::Hold];
    for gains in [PidParameters::paper(), PidParameters { ki: 0.0, ..PidParameters::paper() }] {
        let tracking = tracking(gains);
        for from in modes {
            for to in modes {
                let mut state = tracking.rest_state(Mode::Both);
                let mut run = |mode, range: std::ops::Range<usize>| {
                    // A muscle that is 7 mm off, so that feedback and feed-forward differ much.
                    range
                        .map(|t| {
                            tracking.step(&mut state, mode, reference(t), reference(t) - 7.0).expect("finite")
                        })
                        .last()
                        .expect("not empty")
                        .command
                };
                run(Mode::Both, 0..5000);
                let before = run(from, 5000..5500);
                let after = run(to, 5500..5501);
                assert!((after - before).abs() < 0.005, "{from:?} to {to:?}: {before} to {after} bar");
            }
        }
    }
}

#[test]
fn the_transfer_term_fades() {
    let tracking = tracking(PidParameters { ki: 0.0, ..PidParameters::paper() });
    let mut state = tracking.rest_state(Mode::Hold);
    let mut last = None;
    for _ in 0..10_000 {
        last = tracking.step(&mut state, Mode::FeedforwardOnly, 60.0, 0.0).ok();
    }
    let last = last.expect("finite");
    assert!((last.command - last.feedforward).abs() < 1e-3, "{last:?}");
}

#[test]
fn the_integral_does_not_wind_up_at_a_limit() {
    // The reference is out of reach for 60 s; without back-calculation the integral would grow by
    // 0.6 bar/s.
    let tracking = tracking(PidParameters { ki: 0.05, ..PidParameters::paper() });
    let mut state = tracking.rest_state(Mode::FeedbackOnly);
    for _ in 0..60_000 {
        let command = tracking.step(&mut state, Mode::FeedbackOnly, 140.0, 120.0).expect("finite");
        assert!(command.command <= 6.0);
    }
    // The command leaves the limit within a second of the error's change of sign.
    let left = (0..1000).position(|_| {
        tracking.step(&mut state, Mode::FeedbackOnly, 100.0, 120.0).expect("finite").command < 5.99
    });
    assert!(left.is_some_and(|tick| tick < 500), "left the limit after {left:?} ticks");
}

#[test]
fn the_command_respects_slew_and_limits_whatever_is_asked() {
    let slow = TrackingParameters { slew_bar_per_s: 2.0, ..parameters(PidParameters::paper()) };
    let tracking = Tracking::try_new(&slow).expect("valid");
    let mut state = tracking.rest_state(Mode::Both);
    let mut last = 0.0;
    for tick in 0..20_000 {
        let wild = if (tick / 700) % 2 == 0 { 1e6 } else { -1e6 };
        let command = tracking.step(&mut state, Mode::Both, wild, 50.0).expect("finite");
        assert!((0.0..=6.0).contains(&command.command));
        assert!((command.command - last).abs() <= 2.0 * PERIOD_S * (1.0 + 1e-9), "tick {tick}");
        assert!(command.limited);
        last = command.command;
    }
}

#[test]
fn a_non_finite_sample_is_refused_and_changes_nothing() {
    let tracking = tracking(PidParameters::paper());
    let mut state = tracking.rest_state(Mode::Both);
    for tick in 0..100 {
        tracking.step(&mut state, Mode::Both, reference(tick), 0.0).expect("finite");
    }
    let before = state.clone();
    for (reference, contraction) in [(f64::NAN, 0.0), (1.0, f64::INFINITY)] {
        let refused = tracking.step(&mut state, Mode::FeedbackOnly, reference, contraction);
        assert_eq!(refused, Err(InputError::NotFinite));
        assert_eq!(state, before);
    }
}

#[test]
fn the_derivative_acts_on_the_measurement_and_is_filtered() {
    let gains = PidParameters { kp: 0.0, ki: 0.0, kd: 2.0, derivative_filter_s: 0.05, tracking_time_s: 1.0 };
    let pid = Pid::try_new(&gains, PERIOD_S).expect("valid");
    let mut state = PidState::starting_at(10.0);
    assert_eq!(pid.output(&mut state, -10.0, 10.0), 0.0);
    assert_eq!(pid.output(&mut state, 90.0, 10.0), 0.0, "a step of the reference must not kick");
    // A ramp of 3 mm/s: after several filter constants -kd times the rate.
    let mut output = 0.0;
    for tick in 0..1000 {
        output = pid.output(&mut state, 0.0, 10.0 + 3.0 * PERIOD_S * f64::from(tick));
    }
    assert!((output + 6.0).abs() < 1e-3, "{output} bar");
    // A step of the measurement kicks by no more than the filter lets through.
    let kick = (pid.output(&mut state, 0.0, 14.0) + 6.0).abs();
    assert!(kick < 2.0 * 2.0 / 0.05, "{kick} bar");
}
