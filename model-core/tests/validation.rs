//! Every parameter that no model can be made of is refused by name.

use model_core::envelope::{EnvelopeParameters, TanhParameters};
use model_core::pid::{Pid, PidParameters};
use model_core::{
    ExtensionParameters, Mgpi, MgpiParameters, ModelParameters, ObserverParameters, ParameterError,
    Requirement, Tracking, TrackingParameters, paper,
};

const SIZE: usize = paper::SIZE;
type Parameters = MgpiParameters<f64, SIZE, SIZE>;

fn refusal(spoil: impl Fn(&mut Parameters)) -> ParameterError {
    let mut parameters = paper::mgpi().expect("valid");
    spoil(&mut parameters);
    Mgpi::try_new(&parameters).expect_err("must be refused")
}

/// The paper's envelope.
fn tanh(parameters: &mut Parameters) -> &mut TanhParameters<f64> {
    match &mut parameters.envelope {
        EnvelopeParameters::Tanh(envelope) => envelope,
        other => panic!("{other:?} is not the paper's envelope"),
    }
}

#[test]
fn a_refusal_names_parameter_value_limit_and_unit() {
    let error = refusal(|p| tanh(p).c1 = -0.3385);
    assert_eq!(error.to_string(), "c1 is -0.3385 1/input unit, must be above 0 1/input unit");
    let error = refusal(|p| p.dead_zones.weights[5] = -200.0);
    assert!(error.to_string().starts_with("partial sums of dead-zone weights[5] is -54.5"), "{error}");
    assert_eq!((error.index, error.requirement), (Some(5), Requirement::Above(0.0)));
}

#[test]
fn every_broken_parameter_is_refused() {
    type Spoil = fn(&mut Parameters);
    let cases: [(&str, Spoil); 15] = [
        ("c0", |p| tanh(p).c0 = 0.0),
        ("c1", |p| tanh(p).c1 = f64::NAN),
        ("c2", |p| tanh(p).c2 = f64::INFINITY),
        ("c3", |p| tanh(p).c3 = f64::NAN),
        ("q", |p| p.plays.q = 0.0),
        ("play thresholds", |p| p.plays.thresholds[0] = 0.0),
        ("play thresholds", |p| p.plays.thresholds[3] = 0.16),
        ("play weights", |p| p.plays.weights[2] = f64::NAN),
        ("partial sums of q and play weights", |p| p.plays.weights[2] = -1.0),
        ("number of play weights", |p| p.plays.weights.truncate(3)),
        ("dead-zone thresholds", |p| p.dead_zones.thresholds[0] = 0.1),
        ("dead-zone thresholds", |p| p.dead_zones.thresholds[4] = 0.0),
        ("number of dead-zone weights", |p| p.dead_zones.weights.truncate(3)),
        ("offset", |p| p.dead_zones.offset = f64::NAN),
        ("input range", |p| p.input_max = 0.0),
    ];
    for (name, spoil) in cases {
        assert_eq!(refusal(spoil).parameter, name);
    }
    let mut empty = paper::mgpi().expect("valid");
    empty.dead_zones.thresholds.truncate(0);
    empty.dead_zones.weights.truncate(0);
    assert_eq!(Mgpi::try_new(&empty).expect_err("no dead zone").parameter, "dead zones");
}

#[test]
fn a_capacity_that_is_too_small_is_refused() {
    let error =
        paper::mgpi().expect("valid").convert::<f32, 4, SIZE>().expect_err("ten do not fit into four");
    assert_eq!(error.to_string(), "plays is 10, must be at most 4");
}

#[test]
fn broken_gains_and_limits_are_refused() {
    let gains = PidParameters::<f64>::paper();
    let named =
        |gains: PidParameters<f64>, period| Pid::try_new(&gains, period).expect_err("refused").parameter;
    assert_eq!(named(PidParameters { kp: -1.0, ..gains }, 1e-3), "kp");
    assert_eq!(named(PidParameters { ki: f64::NAN, ..gains }, 1e-3), "ki");
    assert_eq!(named(PidParameters { kd: -0.1, ..gains }, 1e-3), "kd");
    assert_eq!(named(PidParameters { derivative_filter_s: -1.0, ..gains }, 1e-3), "derivative_filter_s");
    assert_eq!(named(PidParameters { tracking_time_s: 0.0, ..gains }, 1e-3), "tracking_time_s");
    assert_eq!(named(gains, 0.0), "period_s");

    let sound = TrackingParameters {
        model: ModelParameters::Cascade(paper::mgpi().expect("valid")),
        extensions: ExtensionParameters::default(),
        pid: gains,
        observer: ObserverParameters::default(),
        command_min: 0.0,
        command_max: 6.0,
        slew_bar_per_s: 20.0,
        period_s: 1e-3,
    };
    assert!(Tracking::try_new(&sound).is_ok());
    let reversed = TrackingParameters { command_max: -1.0, ..sound.clone() };
    assert_eq!(Tracking::try_new(&reversed).expect_err("refused").parameter, "command range");
    let frozen = TrackingParameters { slew_bar_per_s: 0.0, ..sound };
    assert_eq!(Tracking::try_new(&frozen).expect_err("refused").parameter, "slew_bar_per_s");
}
