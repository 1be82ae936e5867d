//! Inverses and states: random models, random histories, both directions.

use heapless::Vec as List;
use model_core::dead_zone::{DeadZoneParameters, DeadZones};
use model_core::envelope::TanhParameters;
use model_core::play::{PlayBank, PlayParameters};
use model_core::{Hysteresis, InputError, InverseHysteresis, Invertible, Mgpi, MgpiParameters};
use proptest::prelude::*;

const N: usize = 12;
const M: usize = 12;

fn list<const L: usize>(values: impl IntoIterator<Item = f64>) -> List<f64, L> {
    values.into_iter().collect()
}

/// Plays with increasing thresholds and positive partial sums; single weights may be negative.
fn plays() -> impl Strategy<Value = PlayParameters<f64, N>> {
    (0.1..2.0, prop::collection::vec((0.02..0.3, 0.3..2.0), 0..N)).prop_map(|(q, steps)| {
        let (mut threshold, mut slope) = (0.0, q);
        let (mut thresholds, mut weights) = (vec![], vec![]);
        for (step, factor) in steps {
            threshold += step;
            thresholds.push(threshold);
            weights.push(slope * factor - slope);
            slope *= factor;
        }
        PlayParameters { q, thresholds: list(thresholds), weights: list(weights) }
    })
}

fn dead_zones() -> impl Strategy<Value = DeadZoneParameters<f64, M>> {
    (prop::collection::vec((0.05..0.3, 5.0..100.0), 1..M), -20.0..20.0).prop_map(|(steps, offset)| {
        let (mut threshold, mut slope) = (0.0, 0.0);
        let (mut thresholds, mut weights) = (vec![], vec![]);
        for (step, next) in steps {
            thresholds.push(threshold);
            threshold += step;
            weights.push(next - slope);
            slope = next;
        }
        DeadZoneParameters { thresholds: list(thresholds), weights: list(weights), offset }
    })
}

fn model() -> impl Strategy<Value = Mgpi<f64, N, M>> {
    let envelope = (0.5..2.0, 0.1..0.5, -1.0..1.0, -0.5..0.5);
    (envelope, plays(), dead_zones()).prop_map(|((c0, c1, c2, c3), plays, dead_zones)| {
        let envelope = TanhParameters { c0, c1, c2, c3 };
        let parameters = MgpiParameters { envelope, plays, dead_zones, input_min: 0.0, input_max: 6.0 };
        Mgpi::try_new(&parameters).expect("valid by construction")
    })
}

fn history(range: std::ops::Range<f64>) -> impl Strategy<Value = Vec<f64>> {
    prop::collection::vec(range, 1..40)
}

proptest! {
    #[test]
    fn the_inverse_undoes_the_model_along_every_history(model in model(), inputs in history(0.0..6.0)) {
        let inverse = model.inverse().unwrap();
        let (mut state, mut inverse_state) = (model.rest_state(), inverse.rest_state());
        for x in inputs {
            let y = model.step(&mut state, x).unwrap();
            let back = inverse.step(&mut inverse_state, y).unwrap();
            prop_assert!((back - x).abs() < 1e-9, "{x} bar came back as {back} bar");
        }
    }

    #[test]
    fn the_model_undoes_the_inverse_along_every_reachable_history(model in model(), shares in history(0.0..1.0)) {
        let inverse = model.inverse().unwrap();
        let (mut state, mut inverse_state) = (model.rest_state(), inverse.rest_state());
        for share in shares {
            // What is reachable from here depends on the history: ask the model.
            let reach = |x| model.step(&mut state.clone(), x).unwrap();
            let (low, high) = (reach(0.0), reach(6.0));
            let wanted = low + share * (high - low);
            let x = inverse.step(&mut inverse_state, wanted).unwrap();
            let got = model.step(&mut state, x).unwrap();
            prop_assert!((got - wanted).abs() < 1e-8, "{wanted} mm wanted, {got} mm got");
        }
    }

    #[test]
    fn the_inverse_can_take_over_after_every_history(model in model(), before in history(0.0..6.0), after in history(0.0..6.0)) {
        let inverse = model.inverse().unwrap();
        let mut state = model.rest_state();
        for x in before {
            model.step(&mut state, x).unwrap();
        }
        let mut inverse_state = inverse.state_of(&state);
        for x in after {
            let y = model.step(&mut state, x).unwrap();
            let back = inverse.step(&mut inverse_state, y).unwrap();
            prop_assert!((back - x).abs() < 1e-9, "{x} bar came back as {back} bar");
        }
    }

    #[test]
    fn an_unreachable_demand_leaves_the_memory_that_the_end_of_the_range_leaves(
        model in model(), before in history(0.0..6.0), high in any::<bool>(), after in history(0.0..6.0)
    ) {
        let inverse = model.inverse().unwrap();
        let (mut state, mut inverse_state) = (model.rest_state(), inverse.rest_state());
        for x in before {
            let y = model.step(&mut state, x).unwrap();
            inverse.step(&mut inverse_state, y).unwrap();
        }
        let (demand, end) = if high { (1e4, 6.0) } else { (-1e4, 0.0) };
        prop_assert_eq!(inverse.step(&mut inverse_state, demand).unwrap(), end);
        model.step(&mut state, end).unwrap();
        for x in after {
            let y = model.step(&mut state, x).unwrap();
            let back = inverse.step(&mut inverse_state, y).unwrap();
            prop_assert!((back - x).abs() < 1e-7, "{x} bar came back as {back} bar");
        }
    }

    #[test]
    fn a_non_finite_input_is_refused_and_changes_nothing(
        model in model(), inputs in history(0.0..6.0), bad in prop::sample::select(vec![f64::NAN, f64::INFINITY, f64::NEG_INFINITY])
    ) {
        let inverse = model.inverse().unwrap();
        let (mut state, mut inverse_state) = (model.rest_state(), inverse.rest_state());
        for x in inputs {
            let y = model.step(&mut state, x).unwrap();
            inverse.step(&mut inverse_state, y).unwrap();
        }
        let (state_before, inverse_before) = (state.clone(), inverse_state.clone());
        prop_assert_eq!(model.step(&mut state, bad), Err(InputError::NotFinite));
        prop_assert_eq!(inverse.step(&mut inverse_state, bad), Err(InputError::NotFinite));
        prop_assert_eq!(state, state_before);
        prop_assert_eq!(inverse_state, inverse_before);
    }

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

#[test]
fn wiping_out_is_exact_for_the_whole_model() {
    let parameters = model_core::paper::mgpi().expect("valid");
    let model = Mgpi::try_new(&parameters).expect("valid");
    let run = |inputs: &[f64]| {
        let mut state = model.rest_state();
        inputs.iter().map(|&x| model.step(&mut state, x).expect("finite")).last()
    };
    // Fig. 4: p5 wipes out p1 to p4.
    assert_eq!(run(&[0.0, 3.0, 1.0, 2.5, 0.5, 5.0, 2.0]), run(&[0.0, 5.0, 2.0]));
}
