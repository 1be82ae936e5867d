//! The staircase against the plain bank: the same operator.

use model_core::Real;
use model_core::play::{PlayBank, PlayParameters};
use model_core::staircase::StaircaseBank;
use proptest::prelude::*;

const N: usize = 40;

/// Increasing thresholds, positive and negative weights with positive partial sums.
fn plays<T: Real>() -> impl Strategy<Value = PlayParameters<T, N>> {
    (0.1..2.0, prop::collection::vec((0.005..0.2, 0.5..1.5), 0..N)).prop_map(|(q, steps)| {
        let (mut threshold, mut slope) = (0.0, q);
        let mut parameters = PlayParameters {
            q: T::from_f64(q),
            thresholds: heapless::Vec::new(),
            weights: heapless::Vec::new(),
        };
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
    prop::collection::vec(prop_oneof![-4.0..4.0, -0.1..0.1, Just(0.0), Just(1.5)], 1..120)
}

fn largest_difference<T: Real>(parameters: &PlayParameters<T, N>, inputs: &[f64]) -> f64 {
    let (plain, stairs) =
        (PlayBank::try_new(parameters).expect("valid"), StaircaseBank::try_new(parameters).expect("valid"));
    let (mut one, mut other) = (plain.rest_state(T::ZERO), stairs.rest_state(T::ZERO));
    let mut scale = 1.0_f64;
    let mut worst = 0.0_f64;
    for &v in inputs {
        let (a, b) = (
            plain.step(&mut one, T::from_f64(v)).expect("finite"),
            stairs.step(&mut other, T::from_f64(v)).expect("finite"),
        );
        scale = scale.max(a.to_f64().abs());
        worst = worst.max((a - b).to_f64().abs());
        for (z, w) in one.outputs().iter().zip(&stairs.outputs(&other)) {
            worst = worst.max((*z - *w).to_f64().abs());
        }
    }
    worst / scale
}

proptest! {
    #[test]
    fn the_staircase_equals_the_plain_bank_in_double_precision(parameters in plays::<f64>(), inputs in history()) {
        let difference = largest_difference(&parameters, &inputs);
        prop_assert!(difference < 1e-12, "{difference}");
    }

    #[test]
    fn the_staircase_equals_the_plain_bank_in_single_precision(parameters in plays::<f32>(), inputs in history()) {
        let difference = largest_difference(&parameters, &inputs);
        prop_assert!(difference < 2e-5, "{difference}");
    }

    #[test]
    fn the_staircase_starts_from_every_admissible_state(
        parameters in plays::<f64>(), before in history(), after in history()
    ) {
        let (plain, stairs) = (PlayBank::try_new(&parameters).unwrap(), StaircaseBank::try_new(&parameters).unwrap());
        let mut one = plain.rest_state(0.0);
        let mut last = 0.0;
        for v in before {
            plain.step(&mut one, v).unwrap();
            last = v;
        }
        let mut other = stairs.try_state(one.outputs(), last).unwrap();
        for v in after {
            let (a, b) = (plain.step(&mut one, v).unwrap(), stairs.step(&mut other, v).unwrap());
            prop_assert!((a - b).abs() < 1e-11, "{a} against {b} at {v}");
        }
    }

    #[test]
    fn the_staircase_refuses_what_no_history_can_reach(parameters in plays::<f64>(), v in -2.0..2.0) {
        let stairs = StaircaseBank::try_new(&parameters).unwrap();
        let mut outputs: Vec<f64> = parameters.thresholds.iter().map(|_| v).collect();
        prop_assert!(stairs.try_state(&outputs, v).is_ok());
        if let (Some(first), Some(threshold)) = (outputs.first_mut(), parameters.thresholds.first()) {
            *first = v - 1.01 * threshold;
            prop_assert!(stairs.try_state(&outputs, v).is_err());
        }
    }
}
