//! Banks of few plays, which are kept by their outputs, against banks of more, which are kept by
//! turning points; and the inverse of compiled size against the one that is chosen at run time.

mod common;

use common::plays;
use model_core::cascade::Cascade;
use model_core::envelope::{Envelope, EnvelopeParameters, TanhEnvelope, TanhParameters};
use model_core::paper::{self, SIZE};
use model_core::play::{PlayBank, PlayParameters};
use model_core::{Hysteresis, InverseHysteresis, Invertible, Mgpi, MgpiParameters};
use proptest::prelude::*;

/// Up to here plays are few.
const FEW: usize = 10;
const N: usize = 16;

/// The paper's model with other plays.
fn with_plays(plays: PlayParameters<f64, N>, preconditioned: bool) -> MgpiParameters<f64, N, N> {
    let model = paper::mgpi().expect("valid").convert().expect("fits");
    MgpiParameters { plays, preconditioned, ..model }
}

/// At most ten plays, and the same with so many more, which weigh next to nothing, that they are
/// not few.
fn few_and_many(plays: &PlayParameters<f64, { common::SIZE }>) -> [PlayParameters<f64, N>; 2] {
    let mut few: PlayParameters<f64, N> = plays.convert().expect("fits");
    few.thresholds.truncate(FEW);
    few.weights.truncate(FEW);
    let mut many = few.clone();
    while many.thresholds.len() <= FEW {
        let last = many.thresholds.last().copied().unwrap_or(0.0);
        many.thresholds.push(last + 0.1).expect("fits");
        many.weights.push(1e-14).expect("fits");
    }
    [few, many]
}

/// Within the range of outputs (0 to 1), at its ends, and outside.
fn demands() -> impl Strategy<Value = Vec<f64>> {
    let ends = prop::sample::select(vec![0.0, 1.0, -1e-9, 1.0 + 1e-9, -1e9, 1e9]);
    prop::collection::vec(prop_oneof![3 => -0.1..1.1, 1 => ends], 1..60)
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(1000))]

    #[test]
    fn the_inverse_of_few_plays_answers_as_that_of_many(
        plays in plays(), preconditioned: bool, demands in demands()
    ) {
        let [few, many] = few_and_many(&plays).map(|plays| Mgpi::try_new(&with_plays(plays, preconditioned)).unwrap());
        let (low, high) = few.output_range();
        let (few, many) = (few.inverse().unwrap(), many.inverse().unwrap());
        let (mut few_state, mut many_state) = (few.rest_state(), many.rest_state());
        for share in demands {
            let y = low + share * (high - low);
            let (x, other) = (few.step(&mut few_state, y).unwrap(), many.step(&mut many_state, y).unwrap());
            prop_assert!((x - other).abs() < 1e-8, "{x} and {other} bar for {y} mm");
        }
    }

    #[test]
    fn turning_points_and_outputs_of_few_plays_are_one_memory(
        plays in plays(), inputs in prop::collection::vec(-1.0..1.0, 1..60), turned in 0_usize..60
    ) {
        let [few, _] = few_and_many(&plays);
        let bank = PlayBank::try_new(&few).unwrap();
        let mut by_outputs = bank.rest_state(0.0);
        let mut by_turns = bank.by_turning_points(&by_outputs);
        for (sample, v) in inputs.into_iter().enumerate() {
            if sample == turned {
                by_turns = bank.by_turning_points(&by_outputs);
            }
            let (u, other) = (bank.step(&mut by_outputs, v).unwrap(), bank.step(&mut by_turns, v).unwrap());
            prop_assert!((u - other).abs() < 1e-11 * (1.0 + u.abs()), "{u} and {other}");
            for (z, other) in bank.outputs(&by_outputs).iter().zip(&bank.outputs(&by_turns)) {
                prop_assert!((z - other).abs() < 1e-11, "{z} and {other}");
            }
        }
    }

    #[test]
    fn the_inverse_of_compiled_size_answers_as_the_one_chosen_at_run_time(
        preconditioned: bool, demands in demands()
    ) {
        let parameters: MgpiParameters<f32, SIZE, SIZE> = paper::mgpi().unwrap().convert().unwrap();
        let parameters = MgpiParameters { preconditioned, ..parameters };
        let chosen = Mgpi::<f32, 32, 32>::try_new(&parameters.convert().unwrap()).unwrap();
        let envelope = TanhEnvelope::try_new(paper::ENVELOPE.convert()).unwrap();
        let compiled = Cascade::with_envelope(envelope, &parameters).unwrap().inverse().unwrap();
        let (low, high) = chosen.output_range();
        let chosen = chosen.inverse().unwrap();
        let (mut state, mut compiled_state) = (chosen.rest_state(), compiled.rest_state());
        for share in demands {
            let y = low + share as f32 * (high - low);
            let (x, other) = (chosen.step(&mut state, y).unwrap(), compiled.step(&mut compiled_state, y).unwrap());
            prop_assert_eq!(x.to_bits(), other.to_bits());
        }
    }

    /// Near the ends of the envelope's values its inverse has no meaning; roundings of the plays
    /// must not lead there.
    #[test]
    fn an_envelope_that_saturates_within_the_range_is_inverted_up_to_its_ends(
        plays in plays(), steepness in 0.3..30.0, preconditioned: bool,
        shorts in prop::collection::vec(0.0..1e-6, 1..60)
    ) {
        let [few, _] = few_and_many(&plays);
        let envelope = EnvelopeParameters::Tanh(TanhParameters { c1: steepness, ..paper::ENVELOPE });
        let parameters = MgpiParameters { envelope, ..with_plays(few, preconditioned) };
        let model = Mgpi::<f32, N, N>::try_new(&parameters.convert().unwrap()).unwrap();
        let (low, high) = model.output_range();
        let inverse = model.inverse().unwrap();
        let (mut state, mut inverse_state) = (model.rest_state(), inverse.rest_state());
        for short in shorts {
            let y = low + (1.0 - short) as f32 * (high - low);
            let x = inverse.step(&mut inverse_state, y).unwrap();
            let got = model.step(&mut state, x).unwrap();
            prop_assert!((got - y).abs() < 1e-3 * (high - low), "{y} mm wanted, {got} mm got at {x} bar, {low} to {high}");
        }
    }
}

/// The largest play of a bank may be too large for the range ever to drive it: its ends then depend
/// on the history for ever.
#[test]
fn a_play_that_the_range_never_drives_both_ways_leaves_the_ends_right() {
    let plays: PlayParameters<f64, N> = PlayParameters::exponential(FEW, 0.3, 0.2, 2.0, 0.3).expect("fits");
    let largest = *plays.thresholds.last().expect("ten");
    let model = Mgpi::try_new(&with_plays(plays, false)).expect("valid");
    let inverse = model.inverse().expect("invertible");
    let envelope = TanhEnvelope::try_new(paper::ENVELOPE).expect("valid");
    let span = envelope.value(paper::PRESSURE_MAX_BAR) - envelope.value(0.0);
    assert!(span < 2.0 * largest, "the range drives all plays both ways");
    let (mut state, mut inverse_state) = (model.rest_state(), inverse.rest_state());
    for x in [0.0, 2.0, 0.0, 6.0, 0.0, 1.0, 0.5, 6.0, 3.0, 0.0, 6.0] {
        let beyond = if x == 0.0 { -1e3 } else { 1e3 };
        let y = model.step(&mut state, x).expect("finite");
        let demand = if x == 0.0 || x == 6.0 { y + beyond } else { y };
        let back = inverse.step(&mut inverse_state, demand).expect("finite");
        assert!((back - x).abs() < 1e-9, "{x} bar came back as {back}");
        assert!((inverse.last_output(&inverse_state) - y).abs() < 1e-9, "{y} mm at {x} bar");
    }
}
