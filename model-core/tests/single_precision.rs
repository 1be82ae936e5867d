//! What the inverse of the paper's model loses in single precision, with either envelope, whatever
//! it is asked for.

use model_core::envelope::{AnyEnvelope, Envelope, EnvelopeParameters, PiecewiseLinearParameters};
use model_core::paper::{self, SIZE};
use model_core::{Hysteresis, InverseHysteresis, Invertible, Mgpi, MgpiParameters};
use proptest::prelude::*;

/// Of the range of inputs.
const LIMIT: f64 = 1e-6;
const KNOTS: usize = 8;

/// The paper's, with its envelope or with a piecewise-linear one through points of it.
fn parameters(is_piecewise: bool) -> MgpiParameters<f64, SIZE, SIZE> {
    let model = paper::mgpi().expect("valid");
    if !is_piecewise {
        return model;
    }
    let own = AnyEnvelope::try_new(&model.envelope).expect("valid");
    let inputs = (0..KNOTS)
        .map(|knot| model.input_min + (model.input_max - model.input_min) * knot as f64 / (KNOTS - 1) as f64);
    let values = inputs.clone().map(|input| own.value(input)).collect();
    let envelope =
        EnvelopeParameters::PiecewiseLinear(PiecewiseLinearParameters { inputs: inputs.collect(), values });
    MgpiParameters { envelope, ..model }
}

/// Jumps over the whole range of outputs (0 to 1) and a little beyond, and slow ways from one to
/// the other.
fn demands() -> impl Strategy<Value = Vec<f64>> {
    prop::collection::vec((-0.05..1.05, 1_usize..40), 1..60).prop_map(|places| {
        let mut demands = Vec::new();
        let mut from = 0.0;
        for (to, steps) in places {
            demands.extend((1..=steps).map(|step| from + (to - from) * step as f64 / steps as f64));
            from = to;
        }
        demands
    })
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(1000))]

    #[test]
    fn the_inverse_in_single_precision_errs_by_at_most_1e_6_of_full_scale(
        is_piecewise: bool, preconditioned: bool, demands in demands()
    ) {
        let parameters = MgpiParameters { preconditioned, ..parameters(is_piecewise) };
        let model = Mgpi::try_new(&parameters).unwrap();
        let span = model.input_range().max() - model.input_range().min();
        let (low, high) = model.output_range();
        let double = model.inverse().unwrap();
        let single = Mgpi::<f32, SIZE, SIZE>::try_new(&parameters.convert().unwrap()).unwrap().inverse().unwrap();
        let (mut state, mut single_state) = (double.rest_state(), single.rest_state());
        for share in demands {
            let y = (low + share * (high - low)) as f32;
            let exact = double.step(&mut state, y.into()).unwrap();
            let x = f64::from(single.step(&mut single_state, y).unwrap());
            prop_assert!((x - exact).abs() <= LIMIT * span, "{x} for {exact} bar, at {y} mm");
        }
    }
}
