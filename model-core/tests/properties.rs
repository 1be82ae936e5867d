//! The properties that operators of the Prandtl-Ishlinskii family have, of random members, from
//! random states.
//!
//! Any state that is admissible is the end of some history, so that most tests start with one.
//!
//! A tolerance in shares of the span is rounding: some 1e-16 a term, times the ratio of the
//! steepest to the flattest part of the model, at most about 1e5 here. Where there is none, bits
//! are equal.

mod common;
mod reference;

use common::{Parameters, Run, SIZE, admissible_outputs, cascades, family, history, jumping, plays};
use model_core::play::PlayBank;
use model_core::{Hysteresis, InputError, InverseHysteresis, Invertible, ModelParameters};
use proptest::prelude::*;
use reference::PlainBank;

/// Share of the span that rounding may cost without an inverse, and with one.
const ROUNDING: f64 = 1e-12;
const INVERSE_ROUNDING: f64 = 1e-9;

/// Two different shares, in order.
fn bounds() -> impl Strategy<Value = (f64, f64)> {
    (0.0..0.95, 0.01..1.0).prop_map(|(low, rise)| (low, low + rise * (1.0 - low)))
}

/// A path from rest through turning points, with samples between them at the given shares of each
/// way.
fn sampled(turns: &[f64], between: Vec<f64>) -> Vec<Vec<f64>> {
    let between = in_order(between, true);
    let turns = [&[0.0], turns].concat();
    let way = |pair: &[f64]| {
        let inner = between.iter().map(|share| pair[0] + share * (pair[1] - pair[0]));
        inner.chain([pair[1]]).collect()
    };
    turns.windows(2).map(way).collect()
}

/// A model on the branch of a direction, a little after the reversal at the end of the range, its
/// output, and the shares of a run that lies ahead.
fn on_a_branch(
    parameters: &Parameters,
    before: &[f64],
    run: Vec<f64>,
    rising: bool,
) -> (Run<f64>, f64, Vec<f64>) {
    let mut model = Run::after(parameters, before);
    let (end, start) = if rising { (0.0, 0.01) } else { (1.0, 0.99) };
    model.to(end);
    let y = model.to(start);
    let ahead = run.into_iter().map(|share| 0.02 + 0.96 * share).collect();
    (model, y, in_order(ahead, rising))
}

fn in_order(mut shares: Vec<f64>, rising: bool) -> Vec<f64> {
    shares.sort_by(f64::total_cmp);
    if !rising {
        shares.reverse();
    }
    shares
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(1000))]

    /// Between an extremum and a larger one nothing is remembered: not one bit of state.
    #[test]
    fn wiping_out_is_exact(
        parameters in family(), before in history(), (low, high) in bounds(),
        wiped in prop::collection::vec(0.0..0.999, 0..20), rising: bool, after in history(),
    ) {
        let (start, end) = if rising { (low, high) } else { (high, low) };
        let mut plain = Run::<f64>::after(&parameters, &before);
        // To the first extremum from the other side of it.
        plain.to(end);
        plain.to(start);
        let mut rich = Run { model: plain.model.clone(), state: plain.state.clone() };
        for share in wiped {
            rich.to(start + share * (end - start));
        }
        prop_assert_eq!(plain.to(end), rich.to(end));
        prop_assert_eq!(&plain.state, &rich.state);
        for share in after {
            prop_assert_eq!(plain.to(share), rich.to(share));
        }
    }

    #[test]
    fn the_output_of_one_envelope_never_falls_while_the_input_rises_from_any_state(
        parameters in cascades(), before in history(), run in history(), rising: bool,
    ) {
        let mut model = Run::<f64>::after(&parameters, &before);
        let last = *before.last().expect("not empty");
        let (mut y, sign) = (model.would_be(last), if rising { 1.0 } else { -1.0 });
        let ahead = |share: &f64| if rising { *share >= last } else { *share <= last };
        for share in in_order(run.into_iter().filter(ahead).collect(), rising) {
            let next = model.to(share);
            prop_assert!(sign * (next - y) >= -ROUNDING * model.span(), "from {y} to {next}");
            y = next;
        }
    }

    #[test]
    fn the_output_of_two_envelopes_never_falls_within_a_rise_of_the_input(
        parameters in jumping(), before in history(), run in history(), rising: bool,
    ) {
        let (mut model, mut y, run) = on_a_branch(&parameters, &before, run, rising);
        let sign = if rising { 1.0 } else { -1.0 };
        for share in run {
            let next = model.to(share);
            prop_assert!(sign * (next - y) >= -ROUNDING * model.span(), "from {y} to {next}");
            y = next;
        }
    }

    /// However fast or unevenly a path is walked, and however finely sampled.
    #[test]
    fn the_output_depends_on_the_path_and_not_on_its_sampling(
        parameters in family(), turns in history(),
        coarse in prop::collection::vec(0.0..1.0, 0..3), fine in prop::collection::vec(0.0..1.0, 0..40),
    ) {
        let (mut one, mut other) = (Run::<f64>::at_rest(&parameters), Run::<f64>::at_rest(&parameters));
        for (few, many) in sampled(&turns, coarse).iter().zip(sampled(&turns, fine)) {
            let end = |run: &mut Run<f64>, way: &[f64]| way.iter().map(|&share| run.to(share)).last();
            let (y, again) = (end(&mut one, few).expect("a sample"), end(&mut other, &many).expect("a sample"));
            prop_assert!((y - again).abs() <= ROUNDING * one.span(), "{y} and {again}");
            prop_assert_eq!(one.state.plays(), other.state.plays());
        }
    }

    #[test]
    fn the_inverse_undoes_a_model_of_one_envelope_from_any_state(
        parameters in cascades(), before in history(), after in history(),
    ) {
        let mut model = Run::<f64>::after(&parameters, &before);
        let inverse = model.model.inverse().unwrap();
        let mut state = inverse.state_of(&model.state);
        let input_span = model.input(1.0) - model.input(0.0);
        for share in after {
            let (x, y) = (model.input(share), model.to(share));
            let back = inverse.step(&mut state, y).unwrap();
            prop_assert!((back - x).abs() <= INVERSE_ROUNDING * input_span, "{x} came back as {back}");
        }
    }

    /// The fixed point of the extended model ends at 1e-10 of the output span: where the curve is
    /// flat that is more of the input's.
    #[test]
    fn the_inverse_undoes_a_model_of_two_envelopes_within_a_run(
        parameters in jumping(), before in history(), run in history(), rising: bool,
    ) {
        let (mut model, _, run) = on_a_branch(&parameters, &before, run, rising);
        let inverse = model.model.inverse().unwrap();
        let mut state = inverse.state_of(&model.state);
        let input_span = model.input(1.0) - model.input(0.0);
        let exactly = if matches!(parameters, ModelParameters::Egpi(_)) { 1e-6 } else { INVERSE_ROUNDING };
        for share in run {
            let (x, y) = (model.input(share), model.to(share));
            let back = inverse.step(&mut state, y).unwrap();
            prop_assert!((back - x).abs() <= exactly * input_span, "{x} came back as {back}");
        }
    }

    #[test]
    fn a_model_of_one_envelope_undoes_its_inverse_from_any_state(
        parameters in cascades(), before in history(), wanted in history(),
    ) {
        let mut model = Run::<f64>::after(&parameters, &before);
        let inverse = model.model.inverse().unwrap();
        let mut state = inverse.state_of(&model.state);
        for share in wanted {
            // What is reachable from here depends on the history: ask the model.
            let (low, high) = (model.would_be(0.0), model.would_be(1.0));
            let y = low + share * (high - low);
            let x = inverse.step(&mut state, y).unwrap();
            let got = model.model.step(&mut model.state, x).unwrap();
            prop_assert!((got - y).abs() <= INVERSE_ROUNDING * model.span(), "{y} wanted, {got} got");
        }
    }

    /// Where the inverse moves at all: an output that the jump at a reversal leaps over has no
    /// input.
    #[test]
    fn a_model_of_two_envelopes_undoes_its_inverse_wherever_it_moves(
        parameters in jumping(), before in history(), wanted in history(),
    ) {
        let mut model = Run::<f64>::after(&parameters, &before);
        let inverse = model.model.inverse().unwrap();
        let mut state = inverse.state_of(&model.state);
        let (low, high) = model.model.output_range();
        let mut last = model.input(*before.last().expect("not empty"));
        for share in wanted {
            let y = low + share * (high - low);
            let x = inverse.step(&mut state, y).unwrap();
            let got = model.model.step(&mut model.state, x).unwrap();
            let moved = x != last && x > model.input(0.0) && x < model.input(1.0);
            prop_assert!(!moved || (got - y).abs() <= INVERSE_ROUNDING * model.span(), "{y} wanted, {got} got");
            last = x;
        }
    }

    /// Some ten roundings, 6e-8 each, of terms that cancel: single ones are up to 100 times the
    /// span, and of the order of 100 where the span is less than 1.
    #[test]
    fn single_precision_is_double_precision_to_1e_4_of_the_span(parameters in family(), inputs in history()) {
        let (mut single, mut double) = (Run::<f32>::at_rest(&parameters), Run::<f64>::at_rest(&parameters));
        for share in inputs {
            let (y, exact) = (f64::from(single.to(share)), double.to(share));
            prop_assert!((y - exact).abs() <= 1e-4 * double.span().max(1.0), "{y} for {exact}");
        }
    }

    #[test]
    fn what_is_not_finite_is_refused_and_changes_nothing(
        parameters in family(), before in history(),
        bad in prop::sample::select(vec![f64::NAN, f64::INFINITY, f64::NEG_INFINITY]),
    ) {
        let mut model = Run::<f64>::after(&parameters, &before);
        let inverse = model.model.inverse().unwrap();
        let mut inverse_state = inverse.state_of(&model.state);
        let untouched = (model.state.clone(), inverse_state.clone());
        prop_assert_eq!(model.model.step(&mut model.state, bad), Err(InputError::NotFinite));
        prop_assert_eq!(inverse.step(&mut inverse_state, bad), Err(InputError::NotFinite));
        prop_assert_eq!((model.state, inverse_state), untouched);
    }

    /// An input outside the range is extrapolated: the plays remember a far end, not how far it
    /// was.
    #[test]
    fn an_input_far_outside_the_range_leaves_the_memory_of_any_other_so_far(
        parameters in family(), before in history(), high: bool, after in history(),
        far in prop::sample::select(vec![1e6, 1e30, 1e150, 1e300]),
    ) {
        let (mut one, mut other) = (Run::<f64>::after(&parameters, &before), Run::<f64>::after(&parameters, &before));
        let sign = if high { 1.0 } else { -1.0 };
        prop_assert!(one.model.step(&mut one.state, sign * far).unwrap().is_finite());
        prop_assert!(other.model.step(&mut other.state, sign * 1e3).unwrap().is_finite());
        for share in after {
            prop_assert_eq!(one.to(share), other.to(share));
        }
    }

    /// A demand beyond the range is answered by its end, and the end is what is remembered.
    #[test]
    fn an_output_far_outside_the_range_leaves_the_memory_of_the_end_of_the_range(
        parameters in cascades(), before in history(), high: bool, after in history(),
        far in prop::sample::select(vec![1e9, 1e30, 1e300, f64::MAX]),
    ) {
        let mut model = Run::<f64>::after(&parameters, &before);
        let inverse = model.model.inverse().unwrap();
        let mut state = inverse.state_of(&model.state);
        let (demand, end) = if high { (far, 1.0) } else { (-far, 0.0) };
        prop_assert_eq!(inverse.step(&mut state, demand).unwrap(), model.input(end));
        model.to(end);
        let input_span = model.input(1.0) - model.input(0.0);
        for share in after {
            let (x, y) = (model.input(share), model.to(share));
            let back = inverse.step(&mut state, y).unwrap();
            prop_assert!((back - x).abs() <= INVERSE_ROUNDING * input_span, "{x} came back as {back}");
        }
    }

    #[test]
    fn an_output_far_outside_the_range_of_two_envelopes_leaves_the_memory_of_any_other_so_far(
        parameters in jumping(), before in history(), high: bool, after in history(),
        far in prop::sample::select(vec![1e9, 1e30, 1e300, f64::MAX]),
    ) {
        let model = Run::<f64>::after(&parameters, &before);
        let inverse = model.model.inverse().unwrap();
        let (mut one, mut other) = (inverse.state_of(&model.state), inverse.state_of(&model.state));
        let sign = if high { 1.0 } else { -1.0 };
        let x = inverse.step(&mut one, sign * far).unwrap();
        prop_assert!(model.model.input_range().contains(x), "{x}");
        prop_assert_eq!(x, inverse.step(&mut other, sign * 1e7).unwrap());
        let (low, top) = model.model.output_range();
        for share in after {
            let y = low + share * (top - low);
            let (a, b) = (inverse.step(&mut one, y).unwrap(), inverse.step(&mut other, y).unwrap());
            prop_assert!((a - b).abs() <= 1e-6, "{a} and {b}");
        }
    }

    /// States made of whole cloth, which no short history leads to.
    #[test]
    fn the_bank_equals_the_papers_sums_and_is_inverted_from_every_admissible_state(
        parameters in plays(), v in -2.0..2.0,
        distances in prop::collection::vec(prop_oneof![-1.0..=1.0, Just(1.0), Just(-1.0)], SIZE),
        after in prop::collection::vec(-4.0..4.0, 1..40),
    ) {
        let (bank, mut plain) = (PlayBank::try_new(&parameters).unwrap(), PlainBank::new(&parameters));
        let outputs = admissible_outputs(&parameters, v, &distances);
        let mut state = bank.try_state(&outputs, v).unwrap();
        plain.outputs = outputs.to_vec();
        let inverse = bank.inverse().unwrap();
        let mut inverse_state = bank.inverse_state(&state);
        for v in after {
            let u = bank.step(&mut state, v).unwrap();
            let scale = 1.0 + u.abs();
            prop_assert!((u - plain.step(v)).abs() <= ROUNDING * scale);
            let back = inverse.step(&mut inverse_state, u).unwrap();
            prop_assert!((back - v).abs() <= INVERSE_ROUNDING, "{v} came back as {back}");
        }
    }
}
