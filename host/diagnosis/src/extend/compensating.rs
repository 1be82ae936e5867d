//! What the inverse goes by where thresholds follow the rate of the input, which it does not know.
//!
//! On the loop's branches the contraction moves as fast as the input times their slope. At another speed of the contraction the
//! thresholds are as wide as at that of the input that belongs to it.

use model_core::Hysteresis;
use model_core::extension::PressureRateParameters;

use super::Extension;
use crate::carrier::LEAST_SLOPE;
use crate::turn::Loop;
use identification::{HostModel, simulate};

/// The model with the gain by the rate of the contraction that its gain by that of the input comes to; as it is where it has none.
pub fn compensating(mut model: Extension) -> Extension {
    let Ok(operator) = HostModel::try_new(&model.parameters) else { return model };
    let (low, high) = model.parameters.input();
    let Some(thresholds) = &mut model.extensions.rate_dependent_thresholds else { return model };
    let Some(PressureRateParameters { gain, .. }) = thresholds.pressure else { return model };
    let turn = Loop::new((low, high), |input| simulate(&operator, input));
    let (from, to) = operator.output_range();
    let least = LEAST_SLOPE * (to - from) / (high - low);
    for (&knot, value) in thresholds.gain.knots.iter().zip(&mut thresholds.gain.values) {
        *value = gain / turn.slope(knot).max(least).powf(thresholds.exponent);
    }
    model
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::extend::tests::model;

    #[test]
    fn the_inverse_has_the_gain_of_the_input_s_rate_where_that_makes_as_wide() {
        let mut by_input = model();
        let before = by_input.clone();
        let thresholds = by_input.extensions.rate_dependent_thresholds.as_mut().expect("thresholds");
        thresholds.pressure = Some(PressureRateParameters { gain: 0.4, resolution: 0.0 });
        let exponent = thresholds.exponent;
        let after = compensating(by_input);
        let thresholds = after.extensions.rate_dependent_thresholds.expect("thresholds");
        let operator = HostModel::try_new(&after.parameters).expect("a model");
        let turn = Loop::new(after.parameters.input(), |input| simulate(&operator, input));
        for (&knot, &gain) in thresholds.gain.knots.iter().zip(&thresholds.gain.values) {
            // At 3 input unit/s.
            let of_contraction = gain * (3.0 * turn.slope(knot)).powf(exponent);
            let of_input = 0.4 * 3f64.powf(exponent);
            assert!((of_contraction - of_input).abs() < 1e-9, "{of_contraction} {of_input} at {knot}");
        }
        assert_eq!(compensating(before.clone()).extensions, before.extensions);
    }
}
