//! Finite arguments at the ends of the number type: answered with finite values, and forgotten by
//! the next sound one.

mod common;

use common::{Run, family, history};
use model_core::pid::PidParameters;
use model_core::{
    ExtensionParameters, Hysteresis, Mode, ModelParameters, ObserverParameters, Tracking, TrackingParameters,
    paper,
};
use proptest::prelude::*;

const SIZE: usize = paper::SIZE;

fn tracking() -> Tracking<f64, SIZE, SIZE> {
    let parameters = TrackingParameters {
        model: ModelParameters::Cascade(paper::mgpi().expect("valid")),
        extensions: ExtensionParameters::default(),
        pid: PidParameters::paper(),
        observer: ObserverParameters::default(),
        command_min: 0.0,
        command_max: 6.0,
        slew_bar_per_s: 1000.0,
        period_s: 1e-3,
    };
    Tracking::try_new(&parameters).expect("valid")
}

/// The commands of three seconds around 60 mm, with one sample of reference and contraction in
/// place of another.
fn commands(wild: Option<(f64, f64)>) -> Vec<f64> {
    let tracking = tracking();
    let mut state = tracking.rest_state(Mode::Both);
    let mut command = |(reference, contraction)| {
        tracking.step(&mut state, Mode::Both, reference, contraction).expect("finite").command
    };
    let before = (0..1000).map(|_| (60.0, 59.0));
    let after = (0..2000).map(|_| (60.0, 59.0));
    before.chain([wild.unwrap_or((60.0, 59.0))]).chain(after).map(&mut command).collect()
}

#[test]
fn a_wild_sample_does_not_wind_up_the_integral() {
    let sound = commands(None);
    for wild in [(60.0, 1e6), (60.0, -1e6)] {
        let disturbed = commands(Some(wild));
        for (tick, (a, b)) in sound.iter().zip(&disturbed).enumerate().skip(1100) {
            assert!((a - b).abs() < 0.01, "{wild:?}, tick {tick}: {b} bar instead of {a} bar");
        }
    }
}

#[test]
fn a_sample_at_the_end_of_the_number_type_leaves_no_state_that_is_not_finite() {
    let disturbed = commands(Some((f64::MAX, -f64::MAX)));
    assert!(disturbed.iter().all(|command| command.is_finite()), "{:?}", disturbed.last());
}

proptest! {
    #[test]
    fn an_input_at_the_end_of_the_number_type_has_a_finite_output(parameters in family(), before in history(), high: bool) {
        let mut run = Run::<f64>::after(&parameters, &before);
        let y = run.model.step(&mut run.state, if high { f64::MAX } else { -f64::MAX }).unwrap();
        prop_assert!(y.is_finite(), "{y}");
    }
}
