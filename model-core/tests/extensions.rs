//! Each effect as a model and as its compensation: alone, in pairs, and all together.

#[path = "common/effects.rs"]
mod effects;

use std::f64::consts::TAU;

use effects::{
    DELAY_TICKS, EXACT, Effect, Extensions, LOSSY, PERIOD_S, SIZE, exact_sets, muscle, names, together,
};
use model_core::extension::{ExtendedState, Output, Sample, ValveLagForm, ValveLagParameters};
use model_core::{
    ExtendedInverse, ExtendedModel, Hysteresis, InverseHysteresis, Invertible, Model as Operator,
    Surroundings,
};

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

/// The largest difference of inverse of forward from the pressure that was given, in bar.
fn inverse_of_forward(extensions: &Extensions) -> f64 {
    let (model, inverse) = (model(extensions), inverse(extensions, LIMITS));
    let (mut state, mut inverse_state) = (model.rest_state(), inverse.rest_state());
    let late = delay(extensions);
    let given: Vec<f64> = (0..TICKS).map(|tick| 0.5 + 5.0 * swing(tick)).collect();
    let errors = given.iter().enumerate().map(|(tick, &input)| {
        let Output { contraction, .. } = step(&model, &mut state, tick, input);
        if tick < late {
            return 0.0;
        }
        let command = inverse.step(&mut inverse_state, contraction, &surroundings(tick)).expect("finite");
        (command - given[tick - late]).abs()
    });
    errors.fold(0.0, f64::max)
}

#[test]
fn forward_of_inverse_is_exact_for_every_effect_pair_and_all_together() {
    for set in exact_sets() {
        let error = forward_of_inverse(&together(&set), LIMITS);
        // An inertia without damping gathers what the root's tolerance leaves.
        let bound = if set.iter().any(|(name, _)| name.starts_with("inertia")) { 1e-4 } else { 1e-6 };
        assert!(error < bound, "{}: {error:.1e} mm", names(&set));
    }
}

#[test]
fn forward_of_inverse_is_exact_behind_an_orifice_and_near_behind_a_second_order() {
    let late = |form| Extensions {
        valve_lag: Some(ValveLagParameters { lead_limit: 100.0, form, ..ValveLagParameters::new(0.05) }),
        ..Extensions::default()
    };
    let orifice = late(ValveLagForm::Orifice { supply: 9.0, outside: 1.0 });
    assert!(forward_of_inverse(&orifice, LIMITS) < 1e-6);
    // What the lead of the first order leaves of the second, far below what no lead would.
    let second = forward_of_inverse(&late(ValveLagForm::SecondOrder { damping_ratio: 1.0 }), LIMITS);
    let plain = Extensions::default();
    let (model, inverse) =
        (model(&late(ValveLagForm::SecondOrder { damping_ratio: 1.0 })), inverse(&plain, LIMITS));
    let (mut state, mut inverse_state) = (model.rest_state(), inverse.rest_state());
    let not_led = (0..TICKS).map(|tick| {
        let command = inverse.step(&mut inverse_state, wanted(tick), &surroundings(tick)).expect("finite");
        (step(&model, &mut state, tick, command).contraction - wanted(tick)).abs()
    });
    let not_led = not_led.fold(0.0, f64::max);
    assert!(second < 0.3 * not_led, "{second} {not_led}");
}

#[test]
fn inverse_of_forward_is_exact_for_every_effect_pair_and_all_together() {
    for set in exact_sets() {
        let error = inverse_of_forward(&together(&set));
        // The lead makes 50 times as much of an error.
        let bound = if set.iter().any(|(name, _)| *name == "valve_lag") { 5e-4 } else { 2e-6 };
        assert!(error < bound, "{}: {error:.1e} bar", names(&set));
    }
}

#[test]
fn without_extensions_model_and_inverse_are_those_of_the_operator_bit_for_bit() {
    let none = Extensions::default();
    let (extended, extended_inverse) = (model(&none), inverse(&none, LIMITS));
    let operator = Operator::try_new(&muscle()).expect("valid");
    let operator_inverse = operator.inverse().expect("invertible");
    let (mut state, mut inverse_state) = (extended.rest_state(), extended_inverse.rest_state());
    let (mut plain, mut plain_inverse) = (operator.rest_state(), operator_inverse.rest_state());
    for tick in 0..TICKS {
        let input = 6.5 * swing(tick);
        let Output { pressure, contraction } = step(&extended, &mut state, tick, input);
        assert_eq!(pressure, input);
        assert_eq!(contraction, operator.step(&mut plain, input).expect("finite"));
        let answer = extended_inverse.step(&mut inverse_state, wanted(tick), &surroundings(tick));
        assert_eq!(answer, operator_inverse.step(&mut plain_inverse, wanted(tick)));
    }
}

#[test]
fn a_backlash_is_inverted_exactly_and_a_held_dead_band_within_five_eighths_of_it() {
    let [backlash, hold, _] = LOSSY;
    let error = forward_of_inverse(&together(&[backlash]), LIMITS);
    assert!(error < 1e-9, "backlash: {error:.1e} mm");

    let hold = together(&[hold]);
    let (model, inverse) = (model(&hold), inverse(&hold, LIMITS));
    let (mut state, mut inverse_state) = (model.rest_state(), inverse.rest_state());
    let plain = Operator::try_new(&muscle()).and_then(|operator| operator.inverse()).expect("invertible");
    let mut plain_state = plain.rest_state();
    let band = hold.valve_deadband.expect("put in").band;
    let mut moves = 0;
    let mut last = f64::NAN;
    for tick in 0..TICKS {
        let pressure = plain.step(&mut plain_state, wanted(tick)).expect("finite");
        let command =
            inverse.step(&mut inverse_state, wanted(tick), &Surroundings::default()).expect("finite");
        let set = step(&model, &mut state, tick, command).pressure;
        assert!((set - pressure).abs() <= 0.625 * band + 1e-9, "tick {tick}: {set} for {pressure} bar");
        moves += usize::from(set != last);
        last = set;
    }
    // The pressure goes up and down by 5 bar or so: a move each 1/8 of the band, at the very most.
    assert!(moves < 2000, "{moves} moves");
}

#[test]
fn a_lag_behind_a_held_dead_band_makes_up_for_it() {
    let [_, hold, _] = LOSSY;
    let alone = forward_of_inverse(&together(&[hold]), LIMITS);
    let with_lag = forward_of_inverse(&together(&[hold, EXACT[0]]), LIMITS);
    assert!(with_lag < 0.2 * alone, "{with_lag} mm with a lag, {alone} mm without");
}

#[test]
fn a_supply_limits_the_command_and_is_left_at_once() {
    let [.., supply] = LOSSY;
    let set = together(&[supply, EXACT[0]]);
    let highest = set.supply_saturation.expect("put in").supply;
    let (model, inverse) = (model(&set), inverse(&set, (0.0, 10.0)));
    assert_eq!((inverse.limits().min(), inverse.limits().max()), (0.0, highest));
    let (mut state, mut inverse_state) = (model.rest_state(), inverse.rest_state());
    let mut beyond = 0;
    for tick in 0..TICKS {
        // The muscle reaches 121 mm at 5.5 bar; before that the lead against the lag reaches the
        // supply.
        let wanted = 1.2 * wanted(tick);
        let command = inverse.step(&mut inverse_state, wanted, &Surroundings::default()).expect("finite");
        assert!((0.0..=highest).contains(&command));
        let contraction = step(&model, &mut state, tick, command).contraction;
        if wanted > 100.0 {
            beyond = tick;
        } else if tick > beyond + 200 {
            // The operator's inverse remembers a peak that the supply has cut: hysteresis of half a
            // bar.
            assert!((contraction - wanted).abs() < 0.3, "tick {tick}: {contraction} for {wanted} mm");
        }
    }
    assert!(beyond > 0, "the supply was never reached");
}

/// The contraction every 16 ms of a smooth swing of the input, by steps of a share of that.
fn sampled(extensions: &Extensions, steps: &[f64]) -> Vec<f64> {
    let model = model(extensions);
    let mut state = model.rest_state();
    let mut time_s = 0.0;
    let mut steps = steps.iter().cycle();
    let mut contractions = vec![];
    for share in (1..=200).map(f64::from) {
        let end_s = 0.016 * share;
        let mut last = f64::NAN;
        while time_s < end_s - 1e-9 {
            let dt_s = (0.016 * steps.next().expect("endless")).min(end_s - time_s);
            time_s += dt_s;
            let input = 3.0 - 2.5 * (TAU * 0.7 * time_s).cos().powi(3);
            let sample = Sample { input, surroundings: Surroundings::default(), dt_s };
            last = model.step(&mut state, &sample).expect("finite").contraction;
        }
        contractions.push(last);
    }
    contractions
}

#[test]
fn time_steps_are_of_second_order_also_when_they_are_unequal() {
    // The rate-dependent width is left out: the filter of its rate is of first order.
    let dynamic = |name: &str| ["viscous_lag", "inertia", "creep"].contains(&name);
    let mut set: Vec<Effect> = EXACT.into_iter().filter(|(name, _)| dynamic(name)).collect();
    set.push(("slower", |all| all.inertia = Some(effects::profile([2e-4, 3e-4, 2e-4]))));
    let set = together(&set);
    let fine = sampled(&set, &[1.0 / 256.0]);
    let rms = |steps: &[f64]| {
        let coarse = sampled(&set, steps);
        let squares = coarse.iter().zip(&fine).map(|(coarse, fine)| (coarse - fine).powi(2));
        (squares.sum::<f64>() / fine.len() as f64).sqrt()
    };
    for pattern in [&[1.0][..], &[0.7, 0.3], &[0.2, 0.5, 0.3]] {
        let scaled = |by: f64| pattern.iter().map(|step| step * by).collect::<Vec<_>>();
        let [whole, half, quarter] = [1.0, 0.5, 0.25].map(|by| rms(&scaled(by)));
        println!("{pattern:?}: {whole:.2e}, {half:.2e}, {quarter:.2e} mm");
        assert!(half < 0.32 * whole && quarter < 0.32 * half, "{whole}, {half}, {quarter} mm");
    }
}

#[test]
fn a_coarser_tolerance_moves_an_answer_by_about_as_many_of_it_as_a_lag_has_steps() {
    let mut all = Extensions::default();
    let (viscosity, tolerance) = (0.03, 1e-7);
    all.viscous_lag = Some(effects::profile([viscosity; 3]));
    let (exact, coarse) = (model(&all), model(&all).with_tolerance(tolerance));
    let (mut one, mut other) = (exact.rest_state(), coarse.rest_state());
    let farthest = (0..TICKS)
        .map(|tick| {
            let pressure = 2.0 + 3.0 * swing(tick);
            let [exact, coarse] =
                [step(&exact, &mut one, tick, pressure), step(&coarse, &mut other, tick, pressure)]
                    .map(|output| output.contraction);
            (exact - coarse).abs()
        })
        .fold(0.0, f64::max);
    let (lowest, highest) = exact.operator().output_range();
    let range = exact.operator().input_range();
    let lag_s = viscosity * (highest - lowest) / (range.max() - range.min());
    // The operator is several times as steep in places as over all.
    let bound = 5.0 * lag_s / PERIOD_S * tolerance * (highest - lowest);
    assert!(farthest > 1e-6 * bound && farthest < bound, "{farthest} mm of {bound}");
}
