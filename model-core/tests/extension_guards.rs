//! What extensions refuse, what they keep in single precision over a long time, and that no input
//! leads out of the number type.

mod common;
#[path = "common/effects.rs"]
mod effects;

use common::{Parameters, SIZE as CAPACITY, cascades, history};
use effects::{
    BY_PRESSURE, ELSEWHERE, EXACT, Effect, Extensions, LOSSY, PERIOD_S, SIZE, muscle, profile, together,
};
use model_core::agpi::AgpiParameters;
use model_core::extension::transport_delay::DELAY_SAMPLES;
use model_core::extension::{
    CreepParameters, DeadbandForm, PeriodicDisturbanceParameters, PressureRateParameters, ProfileParameters,
    Sample, TransportDelayParameters, ValveDeadbandParameters, ValveLagForm,
};
use model_core::{
    ExtendedInverse, ExtendedModel, ExtensionParameters, Hysteresis, InputError, ModelParameters,
    Surroundings,
};
use proptest::prelude::*;

fn every_effect() -> Extensions {
    together(EXACT.iter().chain(&LOSSY[..1]).chain(&LOSSY[2..]))
}

fn sample(input: f64, load: f64, dt_s: f64) -> Sample<f64> {
    Sample { input, surroundings: Surroundings { load: Some(load), temperature: Some(25.0) }, dt_s }
}

#[test]
fn what_is_not_finite_and_time_that_does_not_pass_is_refused_without_a_change() {
    let model = ExtendedModel::<f64, SIZE, SIZE>::try_new(&muscle(), &every_effect()).expect("valid");
    let mut state = model.rest_state();
    for tick in 0..50 {
        model.step(&mut state, &sample(0.02 * f64::from(tick), 20.0, PERIOD_S)).expect("finite");
    }
    let before = state.clone();
    for (input, load, dt_s, why) in [
        (f64::NAN, 20.0, PERIOD_S, InputError::NotFinite),
        (f64::INFINITY, 20.0, PERIOD_S, InputError::NotFinite),
        (1.0, f64::NAN, PERIOD_S, InputError::NotFinite),
        (1.0, 20.0, f64::NAN, InputError::NotFinite),
        (1.0, 20.0, f64::INFINITY, InputError::NotFinite),
        (1.0, 20.0, 0.0, InputError::NotLater),
        (1.0, 20.0, -PERIOD_S, InputError::NotLater),
    ] {
        assert_eq!(model.step(&mut state, &sample(input, load, dt_s)), Err(why));
        assert_eq!(state, before);
    }

    let inverse =
        ExtendedInverse::<f64, SIZE, SIZE>::try_new(&muscle(), &every_effect(), PERIOD_S, (0.0, 6.0))
            .expect("valid");
    let mut state = inverse.rest_state();
    for tick in 0..50 {
        inverse.step(&mut state, 10.0 + 0.1 * f64::from(tick), &Surroundings::default()).expect("finite");
    }
    let before = state.clone();
    let hot = Surroundings { load: None, temperature: Some(f64::NEG_INFINITY) };
    for (wanted, surroundings) in [(f64::NAN, Surroundings::default()), (20.0, hot)] {
        assert_eq!(inverse.step(&mut state, wanted, &surroundings), Err(InputError::NotFinite));
        assert_eq!(state, before);
    }
}

#[test]
fn a_delay_holds_as_many_samples_as_it_says_and_refuses_more_without_a_change() {
    let line = |delay_s| {
        let transport_delay = Some(TransportDelayParameters { delay_s });
        let extensions = Extensions { transport_delay, ..Extensions::default() };
        let model = ExtendedModel::<f64, SIZE, SIZE>::try_new(&muscle(), &extensions).expect("valid");
        let mut state = model.rest_state();
        (0..2 * DELAY_SAMPLES).find_map(|tick| {
            let before = state.clone();
            // A power of two: times are exact.
            let refused = model.step(&mut state, &sample(tick as f64 * 1e-3, 20.0, 1.0 / 1024.0)).err()?;
            assert_eq!(state, before);
            Some((tick, refused))
        })
    };
    assert_eq!(line((DELAY_SAMPLES - 1) as f64 / 1024.0), None);
    assert_eq!(line(DELAY_SAMPLES as f64 / 1024.0), Some((DELAY_SAMPLES, InputError::DelayTooLong)));
}

fn of_form(all: &mut Extensions, form: ValveLagForm<f64>) {
    all.valve_lag.iter_mut().for_each(|lag| lag.form = form);
}

#[test]
fn parameters_that_no_effect_has_are_refused_by_their_name() {
    let cases: [(&str, Effect); 19] = [
        (
            "valve_deadband band",
            ("", |all| {
                all.valve_deadband = Some(ValveDeadbandParameters { band: 0.0, form: DeadbandForm::Hold });
            }),
        ),
        (
            "valve_lag time_constant_s",
            ("", |all| {
                all.valve_lag.iter_mut().for_each(|lag| lag.time_constant_s = 0.0);
            }),
        ),
        ("valve_lag lead_limit", ("", |all| all.valve_lag.iter_mut().for_each(|lag| lag.lead_limit = -1.0))),
        (
            "valve_lag damping_ratio",
            ("", |all| of_form(all, ValveLagForm::SecondOrder { damping_ratio: 0.0 })),
        ),
        ("valve_lag outside", ("", |all| of_form(all, ValveLagForm::Orifice { supply: 8.0, outside: 0.0 }))),
        ("valve_lag supply", ("", |all| of_form(all, ValveLagForm::Orifice { supply: 1.0, outside: 1.0 }))),
        (
            "transport_delay delay_s",
            ("", |all| {
                all.transport_delay.iter_mut().for_each(|delay| delay.delay_s = f64::NAN);
            }),
        ),
        (
            "load",
            ("", |all| {
                all.load.iter_mut().for_each(|load| load.offset = profile([0.0, f64::INFINITY, 0.0]));
            }),
        ),
        ("viscous_lag", ("", |all| all.viscous_lag = Some(profile([0.1, -0.1, 0.1])))),
        ("inertia", ("", |all| all.inertia = Some(ProfileParameters::constant(-1e-6)))),
        ("warm_up travel", ("", |all| all.warm_up.iter_mut().for_each(|warm_up| warm_up.travel = 0.0))),
        (
            "knots",
            ("", |all| {
                all.load.iter_mut().for_each(|load| load.offset.knots.reverse());
            }),
        ),
        (
            "rate_dependent_width exponent",
            ("", |all| {
                all.rate_dependent_width.iter_mut().for_each(|width| width.exponent = 0.0);
            }),
        ),
        (
            "rate_dependent_thresholds filter_s",
            ("", |all| {
                all.rate_dependent_thresholds.iter_mut().for_each(|width| width.filter_s = 0.0);
            }),
        ),
        (
            "rate_dependent_thresholds",
            ("", |all| {
                all.rate_dependent_thresholds
                    .iter_mut()
                    .for_each(|width| width.gain = profile([0.1, -0.1, 0.1]));
            }),
        ),
        (
            "rate_dependent_thresholds pressure_gain",
            ("", |all| {
                let pressure = Some(PressureRateParameters { gain: -0.1, resolution: 0.0 });
                all.rate_dependent_thresholds.iter_mut().for_each(|width| width.pressure = pressure);
            }),
        ),
        (
            "rate_dependent_thresholds resolution",
            ("", |all| {
                let pressure = Some(PressureRateParameters { gain: 0.1, resolution: -1.0 });
                all.rate_dependent_thresholds.iter_mut().for_each(|width| width.pressure = pressure);
            }),
        ),
        (
            "sum of creep fractions",
            ("", |all| {
                all.creep.iter_mut().for_each(|creep| creep.fractions.iter_mut().for_each(|c| *c = 0.25));
            }),
        ),
        (
            "periodic_disturbance phase_rad",
            ("", |all| {
                all.periodic_disturbance.iter_mut().for_each(|tone| tone.phase_rad = 7.0);
            }),
        ),
    ];
    for (parameter, (_, spoil)) in cases {
        let mut extensions = every_effect();
        spoil(&mut extensions);
        let refused = ExtendedModel::<f64, SIZE, SIZE>::try_new(&muscle(), &extensions);
        assert_eq!(refused.expect_err(parameter).parameter, parameter);
    }
}

#[test]
fn thresholds_that_change_are_refused_where_the_plays_cannot_widen() {
    let extensions = together(EXACT.iter().filter(|(name, _)| *name == "rate_dependent_thresholds"));
    let refused = |parameters: &Parameters| {
        let refused = ExtendedModel::<f64, CAPACITY, CAPACITY>::try_new(parameters, &extensions);
        refused.expect_err("cannot widen").to_string()
    };
    let ModelParameters::Cascade(mut cascade) = muscle().convert().expect("fits") else { unreachable!() };
    let plays = &mut cascade.plays;
    while plays.thresholds.len() < CAPACITY {
        let last = plays.thresholds.last().copied().expect("plays");
        plays.thresholds.push(2.0 * last).expect("fits");
        plays.weights.push(0.01).expect("fits");
    }
    let many = refused(&ModelParameters::Cascade(cascade.clone()));
    assert_eq!(many, "number of plays whose thresholds change is 12, must be at most 10");
    cascade.plays.thresholds.truncate(2);
    cascade.plays.weights.truncate(2);
    cascade.plays.weights[1] = -0.01;
    let negative = refused(&ModelParameters::Cascade(cascade.clone()));
    assert!(negative.starts_with("play weights where thresholds change[1] is -0.01"), "{negative}");
    let two_envelopes = AgpiParameters {
        rising: cascade.envelope.clone(),
        falling: cascade.envelope,
        plays: cascade.plays,
        gain: 100.0,
        offset: 0.0,
        input_min: 0.0,
        input_max: 6.0,
        preconditioned: true,
    };
    let two = refused(&ModelParameters::Agpi(two_envelopes));
    assert_eq!(two, "number of envelopes where thresholds change is 2, must be exactly 1");
}

/// The contraction after each of many steps of `dt_s` in single precision, the pressure as given.
fn single(extensions: &Extensions, dt_s: f32, inputs: impl Iterator<Item = f32>) -> Vec<f32> {
    let extensions: ExtensionParameters<f32> = extensions.convert().expect("fits");
    let model = muscle().convert().expect("fits");
    let model = ExtendedModel::<f32, SIZE, SIZE>::try_new(&model, &extensions).expect("valid");
    let mut state = model.rest_state();
    let contraction = |input| {
        let sample = Sample { input, surroundings: Surroundings::default(), dt_s };
        model.step(&mut state, &sample).expect("finite").contraction
    };
    inputs.map(contraction).collect()
}

#[test]
fn a_tone_keeps_its_phase_over_an_hour_in_single_precision() {
    let tone = PeriodicDisturbanceParameters {
        amplitude: 1.0,
        frequency_hz: 1.37,
        phase_rad: -2.0,
        compensated: true,
    };
    let extensions = Extensions { periodic_disturbance: Some(tone), ..Extensions::default() };
    let ticks = 3_600_000;
    let run = single(&extensions, 1e-3, std::iter::repeat_n(2.0, ticks));
    let still = single(&Extensions::default(), 1e-3, std::iter::once(2.0))[0];
    for tick in (0..ticks).step_by(9973) {
        let phase = std::f64::consts::TAU * 1.37_f32 as f64 * tick as f64 * 1e-3_f32 as f64 - 2.0;
        let error = f64::from(run[tick] - still) - phase.sin();
        assert!(error.abs() < 0.01, "tick {tick}: {error}");
    }
}

#[test]
fn creep_over_a_thousand_seconds_and_drift_lose_nothing_in_single_precision() {
    let creep = CreepParameters {
        time_constants_s: [1000.0].into_iter().collect(),
        fractions: [0.5].into_iter().collect(),
    };
    let extensions = Extensions { creep: Some(creep), ..Extensions::default() };
    let ticks = 1_000_000;
    let run = single(&extensions, 1e-3, std::iter::once(0.0).chain(std::iter::repeat_n(5.0, ticks)));
    let step = single(&Extensions::default(), 1e-3, [0.0, 5.0].into_iter());
    let (low, high) = (f64::from(step[0]), f64::from(step[1]));
    // Half of the step comes late; 1/e of that after a time constant.
    let expected = high - 0.5 * (high - low) * (-1.0_f64).exp();
    assert!((f64::from(run[ticks]) - expected).abs() < 1e-3, "{} for {expected} mm", run[ticks]);

    let drift = model_core::extension::DriftParameters { rate_per_s: 1e-3, compensated: false };
    let extensions = Extensions { drift: Some(drift), ..Extensions::default() };
    let run = single(&extensions, 1e-3, std::iter::repeat_n(0.0, ticks + 1));
    assert!((run[ticks] - run[0] - 1.0).abs() < 1e-4, "{} mm", run[ticks] - run[0]);
}

/// Any set of effects.
fn effects() -> impl Strategy<Value = Extensions> {
    let list: Vec<Effect> = EXACT.into_iter().chain(ELSEWHERE).chain(LOSSY).chain([BY_PRESSURE]).collect();
    let count = list.len();
    prop::sample::subsequence(list, 0..=count).prop_map(|set| together(&set))
}

/// Those of the effects that this cascade can have: the thresholds of ten plays at most can change,
/// without negative weights.
fn of(parameters: &Parameters, mut extensions: Extensions) -> Extensions {
    let ModelParameters::Cascade(cascade) = parameters else { return extensions };
    let plays = &cascade.plays;
    if plays.thresholds.len() > 10 || plays.weights.iter().any(|weight| *weight < 0.0) {
        extensions.rate_dependent_thresholds = None;
    }
    extensions
}

/// Numbers of every size.
fn wild() -> impl Strategy<Value = f32> {
    prop_oneof![Just(0.0), -10.0..10.0_f32, -1e36..1e36_f32, -1e-36..1e-36_f32]
}

fn extended(
    parameters: &Parameters,
    extensions: &Extensions,
) -> (ExtendedModel<f32, CAPACITY, CAPACITY>, ExtendedInverse<f32, CAPACITY, CAPACITY>) {
    let parameters = parameters.convert().expect("same capacity");
    let extensions = extensions.convert().expect("fits");
    let inverse = ExtendedInverse::try_new(&parameters, &extensions, 1e-3, (-10.0, 10.0));
    (ExtendedModel::try_new(&parameters, &extensions).expect("valid"), inverse.expect("valid"))
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(300))]

    /// Whatever is asked, in single precision.
    #[test]
    fn no_finite_sample_leads_out_of_the_number_type(
        parameters in cascades(), extensions in effects(),
        samples in prop::collection::vec((wild(), wild(), prop_oneof![Just(1e-3), 1e-9..1e9_f32]), 1..40),
    ) {
        let (model, inverse) = extended(&parameters, &of(&parameters, extensions));
        let (mut state, mut inverse_state) = (model.rest_state(), inverse.rest_state());
        for (number, load, dt_s) in samples {
            let surroundings = Surroundings { load: Some(load), temperature: Some(-load) };
            let output = model.step(&mut state, &Sample { input: number, surroundings, dt_s });
            let Ok(output) = output else { return Err(TestCaseError::fail(format!("{output:?}"))) };
            prop_assert!(output.contraction.is_finite(), "{output:?}");
            let command = inverse.step(&mut inverse_state, number, &surroundings).expect("finite");
            prop_assert!(command.is_finite(), "{command} bar for {number} mm");
        }
    }

    /// Random members of the family, random histories: asked for what the model has done, the
    /// inverse makes it do it again.
    #[test]
    fn forward_of_inverse_is_exact_for_any_set_of_effects(
        parameters in cascades(), shares in history(),
        set in prop::sample::subsequence([EXACT.as_slice(), &ELSEWHERE].concat(), 0..=EXACT.len()),
    ) {
        let extensions = of(&parameters, Extensions { transport_delay: None, ..together(&set) });
        let model = ExtendedModel::<f64, CAPACITY, CAPACITY>::try_new(&parameters, &extensions).expect("valid");
        let inverse = ExtendedInverse::<f64, CAPACITY, CAPACITY>::try_new(&parameters, &extensions, PERIOD_S, (-1e12, 1e12));
        let inverse = inverse.expect("valid");
        let (mut once, mut again) = (model.rest_state(), model.rest_state());
        let mut inverse_state = inverse.rest_state();
        let (low, high) = model.operator().output_range();
        for share in shares {
            let range = model.operator().input_range();
            // Small moves in the middle: an inertia without damping swings beyond them, and still
            // does not leave the range.
            let command = range.min() + (0.45 + 0.1 * share) * (range.max() - range.min());
            let wanted = model.step(&mut once, &sample(command, 20.0, PERIOD_S)).expect("finite").contraction;
            let command = inverse.step(&mut inverse_state, wanted, &Surroundings::default()).expect("finite");
            let contraction = model.step(&mut again, &sample(command, 20.0, PERIOD_S)).expect("finite").contraction;
            prop_assert!((contraction - wanted).abs() < 1e-5 * (high - low), "{contraction} for {wanted}");
        }
    }
}
