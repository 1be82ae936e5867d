//! Each effect as a model and as its compensation: alone, in pairs, and all together.

#[path = "common/effects.rs"]
mod effects;

use std::f64::consts::TAU;

use effects::{DELAY_TICKS, EXACT, Effect, Extensions, LOSSY, PERIOD_S, SIZE, muscle, names, sets, together};
use model_core::extension::{ExtendedState, Output, Sample};
use model_core::{ExtendedInverse, ExtendedModel, Surroundings};

type Model = ExtendedModel<f64, SIZE, SIZE>;
type Inverse = ExtendedInverse<f64, SIZE, SIZE>;
/// Wide open: nothing is cut off.
const LIMITS: (f64, f64) = (-50.0, 50.0);
const TICKS: usize = 6000;

fn model(extensions: &Extensions) -> Model {
    Model::try_new(&muscle(), extensions).expect("valid")
}

fn inverse(extensions: &Extensions, limits: (f64, f64)) -> Inverse {
    Inverse::try_new(&muscle(), extensions, PERIOD_S, limits).expect("valid")
}

/// A swing with a smaller, faster one on it, from standstill. Between 0 and 1.
fn swing(tick: usize) -> f64 {
    let wave = |share: f64, frequency_hz: f64| {
        share * (0.5 - 0.5 * (TAU * frequency_hz * tick as f64 * PERIOD_S).cos())
    };
    wave(0.8, 0.4) + wave(0.2, 1.1)
}

/// Unit: mm.
fn wanted(tick: usize) -> f64 {
    15.0 + 95.0 * swing(tick)
}

fn surroundings(tick: usize) -> Surroundings<f64> {
    // Still, until the first command has come through the delay.
    let t = tick.saturating_sub(DELAY_TICKS) as f64 * PERIOD_S;
    Surroundings { load: Some(20.0 + 10.0 * (TAU * 0.3 * t).sin()), temperature: Some(25.0 + t) }
}

fn step(model: &Model, state: &mut ExtendedState<f64, SIZE>, tick: usize, input: f64) -> Output<f64> {
    let sample = Sample { input, surroundings: surroundings(tick), dt_s: PERIOD_S };
    model.step(state, &sample).expect("finite")
}

/// How many ticks the contraction comes late.
fn delay(extensions: &Extensions) -> usize {
    if extensions.transport_delay.is_some() { DELAY_TICKS } else { 0 }
}

/// The largest difference of forward of inverse from what was wanted, in mm.
fn forward_of_inverse(extensions: &Extensions, limits: (f64, f64)) -> f64 {
    let (model, inverse) = (model(extensions), inverse(extensions, limits));
    let (mut state, mut inverse_state) = (model.rest_state(), inverse.rest_state());
    let late = delay(extensions);
    let errors = (0..TICKS).map(|tick| {
        // The inverse is told the surroundings of the time at which it acts.
        let command =
            inverse.step(&mut inverse_state, wanted(tick), &surroundings(tick + late)).expect("finite");
        let contraction = step(&model, &mut state, tick, command).contraction;
        if tick < late { 0.0 } else { (contraction - wanted(tick - late)).abs() }
    });
    errors.fold(0.0, f64::max)
}

#[test]
fn forward_of_inverse_is_exact_for_every_effect_pair_and_all_together() {
    for set in sets(&EXACT) {
        let error = forward_of_inverse(&together(&set), LIMITS);
        println!("{:<60} {error:.1e} mm", names(&set));
    }
}
