//! The control law of compiled size against the tracking controller.

use model_core::cascade::{Cascade, InverseCascade};
use model_core::envelope::TanhEnvelope;
use model_core::law::{Law, LawParameters, LawState};
use model_core::paper::{self, SIZE};
use model_core::pid::PidParameters;
use model_core::{
    ExtensionParameters, InputError, Invertible, Mode, ModelParameters, ObserverParameters, Tracking,
    TrackingParameters,
};
use proptest::prelude::*;

type PaperLaw = Law<f64, InverseCascade<f64, TanhEnvelope<f64>, SIZE, SIZE>>;
type State = LawState<f64, SIZE>;

fn parameters(ki: f64, kd: f64) -> LawParameters<f64> {
    LawParameters {
        pid: PidParameters { ki, kd, ..PidParameters::paper() },
        command_min: 0.0,
        command_max: 5.5,
        slew_bar_per_s: 40.0,
        period_s: 1e-3,
    }
}

fn law(parameters: &LawParameters<f64>) -> PaperLaw {
    let envelope = TanhEnvelope::try_new(paper::ENVELOPE).expect("valid");
    let model = Cascade::with_envelope(envelope, &paper::mgpi().expect("valid")).expect("valid");
    Law::try_new(model.inverse().expect("invertible"), parameters).expect("valid")
}

proptest! {
    #[test]
    fn within_the_range_the_law_commands_what_the_tracking_controller_does(
        ki in 0.0..5.0, kd in 0.0..0.01,
        samples in prop::collection::vec((1.0..110.0, 1.0..110.0), 1..80),
    ) {
        let parameters = parameters(ki, kd);
        let law = law(&parameters);
        let tracking = Tracking::<f64, SIZE, SIZE>::try_new(&TrackingParameters {
            model: ModelParameters::Cascade(paper::mgpi().unwrap()),
            extensions: ExtensionParameters::default(),
            pid: parameters.pid,
            observer: ObserverParameters::default(),
            command_min: parameters.command_min,
            command_max: parameters.command_max,
            slew_bar_per_s: parameters.slew_bar_per_s,
            period_s: parameters.period_s,
        }).unwrap();
        let mut state: State = law.rest_state(samples[0].1);
        let mut tracking_state = tracking.rest_state(Mode::Both);
        for (reference, contraction) in samples {
            let command = law.step(&mut state, reference, contraction).unwrap();
            let other = tracking.step(&mut tracking_state, Mode::Both, reference, contraction).unwrap().command;
            prop_assert_eq!(command.to_bits(), other.to_bits(), "{} and {} bar", command, other);
        }
    }

    #[test]
    fn the_command_stays_within_limits_and_slew_whatever_is_measured(
        samples in prop::collection::vec((-1e6..1e6, -1e6..1e6), 1..80),
    ) {
        let parameters = parameters(1.0, 0.001);
        let law = law(&parameters);
        let mut state: State = law.rest_state(0.0);
        let mut last = parameters.command_min;
        for (reference, contraction) in samples {
            let command = law.step(&mut state, reference, contraction).unwrap();
            prop_assert!((parameters.command_min..=parameters.command_max).contains(&command));
            prop_assert!((command - last).abs() <= 1.000_001 * parameters.slew_bar_per_s * parameters.period_s);
            last = command;
        }
    }
}

#[test]
fn a_sample_that_is_not_finite_is_refused_and_leaves_the_state_as_it_was() {
    let law = law(&parameters(1.0, 0.001));
    let mut state: State = law.rest_state(0.0);
    law.step(&mut state, 30.0, 28.0).expect("finite");
    let before = state.clone();
    for (reference, contraction) in [(f64::NAN, 28.0), (30.0, f64::INFINITY), (f64::NEG_INFINITY, f64::NAN)] {
        assert_eq!(law.step(&mut state, reference, contraction), Err(InputError::NotFinite));
        assert_eq!(state, before);
    }
}

#[test]
fn wrong_parameters_are_refused_by_name() {
    let refuse = |change: fn(&mut LawParameters<f64>)| {
        let mut wrong = parameters(0.0, 0.0);
        change(&mut wrong);
        let inverse =
            Cascade::with_envelope(TanhEnvelope::try_new(paper::ENVELOPE).unwrap(), &paper::mgpi().unwrap());
        Law::try_new(inverse.unwrap().inverse().unwrap(), &wrong).unwrap_err().to_string()
    };
    assert!(refuse(|wrong| wrong.period_s = 0.0).contains("period_s"));
    assert!(refuse(|wrong| wrong.slew_bar_per_s = f64::NAN).contains("slew_bar_per_s"));
    assert!(refuse(|wrong| wrong.command_max = -1.0).contains("command range"));
    assert!(refuse(|wrong| wrong.pid.kp = -1.0).contains("kp"));
}
