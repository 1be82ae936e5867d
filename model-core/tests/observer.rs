//! The disturbance observer in the tracking controller.

use model_core::paper::{self, SIZE};
use model_core::pid::PidParameters;
use model_core::{
    ExtensionParameters, Hysteresis, Mgpi, Mode, ModelParameters, ObserverParameters, Tracking,
    TrackingParameters,
};
use proptest::prelude::*;

const PERIOD_S: f64 = 1e-3;
/// The steepest slope of the paper's muscle. Unit: mm/bar.
const STEEPEST: f64 = 45.0;
/// Of the integral on the steepest slope. Unit: 1/s.
const RATE: f64 = 10.0;
const ON: ObserverParameters<f64> = ObserverParameters { slope: STEEPEST, reach: 10.0, band: 0.1 };

fn parameters(observer: ObserverParameters<f64>) -> TrackingParameters<f64, SIZE, SIZE> {
    TrackingParameters {
        model: ModelParameters::Cascade(paper::mgpi().expect("valid")),
        extensions: ExtensionParameters::default(),
        pid: PidParameters { kp: 0.0, ki: RATE / STEEPEST, ..PidParameters::paper() },
        observer,
        command_min: 0.0,
        command_max: 6.0,
        slew_bar_per_s: 1000.0,
        period_s: PERIOD_S,
    }
}

fn tracking(observer: ObserverParameters<f64>) -> Tracking<f64, SIZE, SIZE> {
    Tracking::try_new(&parameters(observer)).expect("valid")
}

/// The commands and contractions of a muscle that is approached from below and held. At a time (s)
/// so much pressure is missing as `missing` says, bar.
fn held(
    tracking: &Tracking<f64, SIZE, SIZE>,
    mode: impl Fn(f64) -> Mode,
    seconds: f64,
    reference_mm: f64,
    missing: impl Fn(f64) -> f64,
    noise: impl Fn(u32) -> f64,
) -> Vec<(f64, f64)> {
    let muscle = Mgpi::<f64, SIZE, SIZE>::try_new(&paper::mgpi().expect("valid")).expect("valid");
    let (mut state, mut plant) = (tracking.rest_state(mode(0.0)), muscle.rest_state());
    let mut command = 0.0;
    (0..(seconds / PERIOD_S) as u32)
        .map(|tick| {
            let time_s = f64::from(tick) * PERIOD_S;
            let contraction = muscle.step(&mut plant, command - missing(time_s)).expect("finite");
            let reference = reference_mm * time_s.min(1.0);
            let seen = contraction + noise(tick);
            command = tracking.step(&mut state, mode(time_s), reference, seen).expect("finite").command;
            (command, contraction)
        })
        .collect()
}

/// How long after 2 s the contraction of a run takes to within 1 mm. Unit: s.
fn settling_s(run: &[(f64, f64)], reference_mm: f64) -> f64 {
    let last = run.iter().rposition(|(_, mm)| (mm - reference_mm).abs() > 1.0).unwrap_or(0);
    last as f64 * PERIOD_S - 2.0
}

#[test]
fn a_load_is_taken_back_as_fast_as_on_the_steepest_slope_wherever_the_muscle_is() {
    for reference_mm in [30.0, 60.0, 90.0] {
        for bar in [0.4, -0.4] {
            let time_s = |observer| {
                let missing = |time_s| if time_s < 2.0 { 0.0 } else { bar };
                let run = held(&tracking(observer), |_| Mode::Both, 5.0, reference_mm, missing, |_| 0.0);
                settling_s(&run, reference_mm)
            };
            let (with, without) = (time_s(ON), time_s(ObserverParameters::default()));
            // The pressure that is missing has to shrink to that of a millimetre: ln(0.4 x 45) time
            // constants, on the steepest slope.
            let expected_s = (0.4 * STEEPEST).ln() / RATE;
            assert!(with < 1.3 * expected_s, "{reference_mm} mm, {bar} bar: {with} s, {without} s");
            assert!(with < without, "{reference_mm} mm, {bar} bar: {with} s, {without} s");
        }
    }
}

#[test]
fn noise_within_the_band_changes_no_gain_but_that_of_the_place() {
    let quiet = held(&tracking(ON), |_| Mode::Both, 4.0, 60.0, |_| 0.0, |_| 0.0);
    let noisy = |tick: u32| if tick.is_multiple_of(2) { 0.09 } else { -0.09 };
    let heard = held(&tracking(ON), |_| Mode::Both, 4.0, 60.0, |_| 0.0, noisy);
    let (quiet, heard) = (quiet[3999], heard[3999]);
    assert!((quiet.1 - heard.1).abs() < 0.05, "{quiet:?} {heard:?}");
}

#[test]
fn every_change_of_mode_is_without_a_jump() {
    let modes = [Mode::Both, Mode::FeedforwardOnly, Mode::Both, Mode::Hold, Mode::Both, Mode::FeedbackOnly];
    let mode = |time_s: f64| modes[(time_s as usize).min(modes.len() - 1)];
    let run = held(&tracking(ON), mode, 6.0, 60.0, |_| 0.2, |_| 0.0);
    for change in 2..modes.len() {
        let at = (change as f64 / PERIOD_S) as usize;
        let jump = (run[at].0 - run[at - 1].0).abs();
        assert!(jump < 0.01, "{:?} to {:?}: {jump} bar", modes[change - 1], modes[change]);
    }
}

#[test]
fn what_cannot_be_reached_does_not_wind_up() {
    // For 2 s more pressure is missing than there is.
    let missing = |time_s| if time_s < 2.0 { 4.0 } else { 0.0 };
    let run = held(&tracking(ON), |_| Mode::Both, 5.0, 110.0, missing, |_| 0.0);
    assert!(run[1900].0 > 5.99, "{:?}", run[1900]);
    assert!((run[4999].1 - 110.0).abs() < 1.0, "{:?}", run[4999]);
}

#[test]
fn parameters_out_of_their_limits_are_refused_by_name() {
    for (wrong, name) in [
        (ObserverParameters { slope: -1.0, ..ON }, "observer slope"),
        (ObserverParameters { slope: f64::NAN, ..ON }, "observer slope"),
        (ObserverParameters { reach: 0.9, ..ON }, "observer reach"),
        (ObserverParameters { band: -0.1, ..ON }, "observer band"),
    ] {
        assert_eq!(Tracking::try_new(&parameters(wrong)).unwrap_err().parameter, name);
    }
}

proptest! {
    #[test]
    fn with_a_reach_of_one_the_commands_are_those_without_an_observer_bit_for_bit(
        samples in prop::collection::vec((-50.0..250.0, -50.0..250.0), 1..80),
    ) {
        let with = tracking(ObserverParameters { reach: 1.0, ..ON });
        let without = tracking(ObserverParameters::default());
        let (mut a, mut b) = (with.rest_state(Mode::Both), without.rest_state(Mode::Both));
        for (reference, contraction) in samples {
            let with = with.step(&mut a, Mode::Both, reference, contraction).unwrap();
            let without = without.step(&mut b, Mode::Both, reference, contraction).unwrap();
            prop_assert_eq!(with, without);
        }
    }
}
