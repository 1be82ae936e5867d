//! Thresholds by the rate of the pressure: the model against an independent formulation of the
//! plays, and how near its inverse is.

#[path = "common/effects.rs"]
mod effects;

use std::f64::consts::TAU;

use effects::{BY_PRESSURE, Extensions, PERIOD_S, SIZE, muscle, profile, together};
use model_core::cascade::CascadeParameters;
use model_core::envelope::EnvelopeParameters;
use model_core::extension::{PressureRateParameters, RateDependentThresholdsParameters, Sample};
use model_core::{ExtendedInverse, ExtendedModel, Model, ModelParameters, Surroundings};

const TICKS: usize = 6000;

fn cascade() -> CascadeParameters<f64, SIZE, SIZE> {
    let ModelParameters::Cascade(cascade) = muscle() else { panic!("the paper's is a cascade") };
    cascade
}

/// Swings of two speeds, then a rest. Unit: bar.
fn pressure(tick: usize) -> f64 {
    let wave = |frequency_hz: f64| 0.5 - 0.5 * (TAU * frequency_hz * tick as f64 * PERIOD_S).cos();
    if tick < 5000 { 3.5 * wave(0.4) + 1.5 * wave(1.2) } else { 0.2 }
}

/// The contractions of the model with these extensions. Unit: mm.
fn contractions(extensions: &Extensions, pressure: impl Fn(usize) -> f64) -> Vec<f64> {
    let model = ExtendedModel::try_new(&muscle(), extensions).expect("valid");
    let mut state = model.rest_state();
    let mut step = |tick| {
        let sample = Sample { input: pressure(tick), surroundings: Surroundings::default(), dt_s: PERIOD_S };
        model.step(&mut state, &sample).expect("finite").contraction
    };
    (0..TICKS).map(&mut step).collect()
}

fn largest_difference(one: &[f64], other: &[f64]) -> f64 {
    one.iter().zip(other).map(|(one, other)| (one - other).abs()).fold(0.0, f64::max)
}

#[test]
fn the_model_is_that_of_plays_that_the_rate_of_the_pressure_widens() {
    let (extensions, cascade) = (together(&[BY_PRESSURE]), cascade());
    let RateDependentThresholdsParameters { exponent, filter_s, pressure: by, .. } =
        extensions.rate_dependent_thresholds.clone().expect("put in");
    let PressureRateParameters { gain, resolution } = by.expect("put in");
    let EnvelopeParameters::Tanh(tanh) = &cascade.envelope else { panic!("the paper's is a tanh") };
    let Ok(Model::Cascade(operator)) = Model::try_new(&muscle()) else { panic!("valid") };
    let envelope = |p: f64| tanh.c0 * (tanh.c1 * p + tanh.c2).tanh() + tanh.c3;
    let plays = &cascade.plays;
    // It came from the other end: every play is driven down.
    let mut memory: Vec<f64> = plays.thresholds.iter().map(|r| envelope(cascade.input_min) + r).collect();
    let (mut seen, mut rate) = (pressure(0), 0.0);
    let expected: Vec<f64> = (0..TICKS)
        .map(|tick| {
            let now = seen.clamp(pressure(tick) - resolution, pressure(tick) + resolution);
            let speed = (now - seen).abs() / PERIOD_S;
            rate += (speed - rate) * (1.0 - (-PERIOD_S / filter_s).exp());
            seen = now;
            // A rate this small counts as standing still.
            let power = if rate < 1e-9 { 0.0 } else { rate.powf(exponent) };
            let (v, times) = (envelope(pressure(tick)), 1.0 + gain * power);
            let mut u = plays.q * v;
            for (z, (r, p)) in memory.iter_mut().zip(plays.thresholds.iter().zip(&plays.weights)) {
                *z = z.clamp(v - times * r, v + times * r);
                u += p * *z;
            }
            operator.dead_zones().value(u)
        })
        .collect();
    let difference = largest_difference(&contractions(&extensions, pressure), &expected);
    assert!(difference < 1e-9, "{difference:.1e} mm");
    let narrow = largest_difference(&contractions(&Extensions::default(), pressure), &expected);
    assert!(narrow > 1.0, "nothing is wider: {narrow} mm");
}

#[test]
fn beside_forces_the_model_is_the_same_where_these_are_none() {
    let alone = together(&[BY_PRESSURE]);
    let beside = Extensions { viscous_lag: Some(profile([0.0, 0.0, 0.0])), ..alone.clone() };
    let difference = largest_difference(&contractions(&alone, pressure), &contractions(&beside, pressure));
    assert!(difference < 1e-7, "{difference:.1e} mm");
}

#[test]
fn noise_within_the_resolution_is_no_motion() {
    let slow = |tick: usize| 1.0 + 0.1 * PERIOD_S * tick as f64;
    let noisy = |tick: usize| slow(tick) + if tick.is_multiple_of(2) { 0.0019 } else { -0.0019 };
    let mut extensions = together(&[BY_PRESSURE]);
    let off = |extensions: &Extensions| {
        largest_difference(&contractions(extensions, noisy), &contractions(extensions, slow))
    };
    // The noise itself goes through the loop, too.
    let seen = off(&extensions);
    assert!(seen < 0.2, "{seen} mm");
    if let Some(thresholds) = &mut extensions.rate_dependent_thresholds {
        thresholds.pressure = Some(PressureRateParameters { gain: 0.3, resolution: 0.0 });
    }
    let bare = off(&extensions);
    assert!(bare > 5.0 * seen, "{bare} mm where noise counts, {seen} mm where it does not");
}

#[test]
fn the_inverse_by_the_rate_of_the_contraction_takes_most_of_it_away() {
    let extensions = together(&[BY_PRESSURE]);
    let model = ExtendedModel::try_new(&muscle(), &extensions).expect("valid");
    let error = |compensated: &Extensions| {
        let inverse =
            ExtendedInverse::<f64, SIZE, SIZE>::try_new(&muscle(), compensated, PERIOD_S, (-50.0, 50.0))
                .expect("valid");
        let (mut state, mut inverse_state) = (model.rest_state(), inverse.rest_state());
        let mut squares = 0.0;
        for tick in 0..TICKS {
            let wanted = 15.0 + 20.0 * pressure(tick.min(4999));
            let surroundings = Surroundings::default();
            let input = inverse.step(&mut inverse_state, wanted, &surroundings).expect("finite");
            let sample = Sample { input, surroundings, dt_s: PERIOD_S };
            squares += (model.step(&mut state, &sample).expect("finite").contraction - wanted).powi(2);
        }
        (squares / TICKS as f64).sqrt()
    };
    let (with, without) = (error(&extensions), error(&Extensions::default()));
    assert!(with < 0.5 * without, "{with} mm with, {without} mm without");
}
