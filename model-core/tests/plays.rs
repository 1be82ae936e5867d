//! The bank of plays against the equations of the paper: the same operator.

mod reference;

use model_core::play::{PlayBank, PlayParameters};
use model_core::{List, Real};
use proptest::prelude::*;
use reference::PlainBank;

const N: usize = 40;

/// Increasing thresholds, positive and negative weights with positive partial sums.
fn plays<T: Real>() -> impl Strategy<Value = PlayParameters<T, N>> {
    (0.1..2.0, prop::collection::vec((0.005..0.2, 0.5..1.5), 0..N)).prop_map(|(q, steps)| {
        let (mut threshold, mut slope) = (0.0, q);
        let mut parameters =
            PlayParameters { q: T::from_f64(q), thresholds: List::new(), weights: List::new() };
        for (step, factor) in steps {
            threshold += step;
            parameters.thresholds.push(T::from_f64(threshold)).expect("fits");
            parameters.weights.push(T::from_f64(slope * factor - slope)).expect("fits");
            slope *= factor;
        }
        parameters
    })
}

/// Small and large moves, repeats of earlier values, and standstill.
fn history() -> impl Strategy<Value = Vec<f64>> {
    prop::collection::vec(prop_oneof![-4.0..4.0, -0.1..0.1, 0.995..1.005, Just(0.0), Just(1.5)], 1..120)
}

/// Over outputs and sums, in units of the largest sum.
fn largest_difference<T: Real>(parameters: &PlayParameters<T, N>, inputs: &[f64]) -> f64 {
    let bank = PlayBank::try_new(parameters).expect("valid");
    let (mut plain, mut state) = (PlainBank::new(parameters), bank.rest_state(T::ZERO));
    let mut scale = 1.0_f64;
    let mut worst = 0.0_f64;
    for &v in inputs {
        let (a, b) = (plain.step(T::from_f64(v)), bank.step(&mut state, T::from_f64(v)).expect("finite"));
        scale = scale.max(a.to_f64().abs());
        worst = worst.max((a - b).to_f64().abs());
        for (z, w) in plain.outputs.iter().zip(&bank.outputs(&state)) {
            worst = worst.max((*z - *w).to_f64().abs());
        }
    }
    worst / scale
}

proptest! {
    #[test]
    fn the_bank_equals_the_papers_sums_in_double_precision(parameters in plays::<f64>(), inputs in history()) {
        let difference = largest_difference(&parameters, &inputs);
        prop_assert!(difference < 1e-12, "{difference}");
    }

    #[test]
    fn the_bank_equals_the_papers_sums_in_single_precision(parameters in plays::<f32>(), inputs in history()) {
        let difference = largest_difference(&parameters, &inputs);
        prop_assert!(difference < 2e-5, "{difference}");
    }

    #[test]
    fn the_bank_starts_from_every_admissible_state(
        parameters in plays::<f64>(), before in history(), after in history()
    ) {
        let bank = PlayBank::try_new(&parameters).unwrap();
        let mut plain = PlainBank::new(&parameters);
        let last = before.into_iter().inspect(|&v| { plain.step(v); }).last().unwrap();
        let mut state = bank.try_state(&plain.outputs, last).unwrap();
        for v in after {
            let (a, b) = (plain.step(v), bank.step(&mut state, v).unwrap());
            prop_assert!((a - b).abs() < 1e-11, "{a} against {b} at {v}");
        }
    }

    #[test]
    fn outputs_that_no_history_reaches_are_refused(parameters in plays::<f64>(), v in -2.0..2.0) {
        let bank = PlayBank::try_new(&parameters).unwrap();
        let mut outputs: Vec<f64> = parameters.thresholds.iter().map(|_| v).collect();
        prop_assert!(bank.try_state(&outputs, v).is_ok());
        if let (Some(first), Some(threshold)) = (outputs.first_mut(), parameters.thresholds.first()) {
            *first = v - 1.01 * threshold;
            prop_assert!(bank.try_state(&outputs, v).is_err());
        }
    }
}

/// Swings that drive the same plays again and again, and never wipe anything out.
#[test]
fn a_million_swings_within_others_add_up_no_roundings() {
    let parameters: PlayParameters<f32, N> =
        PlayParameters::exponential(N, 0.3, 0.1, 2.0, 0.02).expect("fits");
    let bank = PlayBank::try_new(&parameters).expect("valid");
    for amplitude in [0.011, 0.1, 0.3, 0.9, 2.0] {
        let (mut plain, mut state) = (PlainBank::new(&parameters), bank.rest_state(0.0));
        let mut worst = 0.0_f32;
        for k in 0..1_000_000 {
            let swing = amplitude * (1.0 - k as f32 * 1e-9);
            let v = 0.3 + if k % 2 == 0 { swing } else { -swing };
            worst = worst.max((plain.step(v) - bank.step(&mut state, v).expect("finite")).abs());
        }
        assert!(worst < 4e-6, "{worst} at amplitude {amplitude}");
    }
}
