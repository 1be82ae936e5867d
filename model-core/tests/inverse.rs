//! The inverses of the two stages against the sums of the paper, and the states of their plays.

mod common;

use common::{dead_zones, plays};
use model_core::dead_zone::DeadZones;
use model_core::play::PlayBank;
use proptest::prelude::*;

fn history(range: std::ops::Range<f64>) -> impl Strategy<Value = Vec<f64>> {
    prop::collection::vec(range, 1..40)
}

proptest! {
    #[test]
    fn a_bank_is_the_inverse_of_its_inverse_and_states_map_there_and_back(
        parameters in plays(), inputs in history(-2.0..2.0)
    ) {
        let bank = PlayBank::try_new(&parameters).unwrap();
        let inverse = bank.inverse().unwrap();
        let mut state = bank.rest_state(0.0);
        for v in inputs {
            bank.step(&mut state, v).unwrap();
        }
        let back = inverse.inverse_state(&bank.inverse_state(&state));
        for (one, other) in bank.outputs(&state).iter().zip(&bank.outputs(&back)) {
            prop_assert!((one - other).abs() < 1e-9);
        }
        let again = inverse.inverse().unwrap();
        let (mut one, mut other) = (state.clone(), state);
        for v in [-1.0, 0.3, -0.2, 1.5] {
            prop_assert!((bank.step(&mut one, v).unwrap() - again.step(&mut other, v).unwrap()).abs() < 1e-9);
        }
    }

    #[test]
    fn states_that_a_history_reaches_are_admissible_and_others_are_refused(
        parameters in plays(), inputs in history(-2.0..2.0)
    ) {
        let bank = PlayBank::try_new(&parameters).unwrap();
        let mut state = bank.rest_state(0.0);
        let mut last = 0.0;
        for v in inputs {
            bank.step(&mut state, v).unwrap();
            last = v;
        }
        prop_assert!(bank.try_state(&bank.outputs(&state), last).is_ok());
        let mut moved = bank.outputs(&state).to_vec();
        if let (Some(first), Some(threshold)) = (moved.first_mut(), parameters.thresholds.first()) {
            *first = last + threshold * 1.01;
            prop_assert!(bank.try_state(&moved, last).is_err());
        }
    }

    /// The curve through the knots against the sums of equations (14) and (20).
    #[test]
    fn the_dead_zone_curve_is_the_papers_sum_and_its_inverse_the_papers_inverse_sum(
        parameters in dead_zones(), u in -1.0..4.0
    ) {
        let zones = DeadZones::try_new(&parameters).unwrap();
        let dead_zone = |value: f64, d: f64| if d == 0.0 { value } else { (value - d).max(0.0) };
        let (d, w) = (&parameters.thresholds, &parameters.weights);
        let sum: f64 = d.iter().zip(w).map(|(d, w)| w * dead_zone(u, *d)).sum();
        let y = zones.value(u);
        prop_assert!((y - parameters.offset - sum).abs() < 1e-9, "{y} against {sum}");

        let sums: Vec<f64> = w.iter().scan(0.0, |sum, w| { *sum += w; Some(*sum) }).collect();
        let inverse: f64 = (0..w.len()).map(|j| {
            let weight = if j == 0 { 1.0 / w[0] } else { -w[j] / (sums[j] * sums[j - 1]) };
            let threshold: f64 = (0..=j).map(|k| w[k] * (d[j] - d[k])).sum();
            weight * dead_zone(y - parameters.offset, threshold)
        }).sum();
        prop_assert!((inverse - u).abs() < 1e-8, "{inverse} against {u}");
        prop_assert!((zones.inverse(y) - u).abs() < 1e-9);
    }

    /// The bank that is the inverse against the sums of equation (21).
    #[test]
    fn the_inverse_bank_has_the_papers_thresholds(parameters in plays()) {
        let bank = PlayBank::try_new(&parameters).unwrap();
        let inverse = bank.inverse().unwrap();
        let (r, p, q) = (&parameters.thresholds, &parameters.weights, parameters.q);
        // On the first loading from 0 the inverse bends at its thresholds: probe it there.
        for i in 0..r.len() {
            let threshold: f64 = q * r[i] + (0..i).map(|j| p[j] * (r[i] - r[j])).sum::<f64>();
            let mut state = inverse.rest_state(0.0);
            let v = inverse.step(&mut state, threshold).unwrap();
            prop_assert!((v - r[i]).abs() < 1e-9, "threshold {i}: {v} against {}", r[i]);
        }
    }
}
