//! What single precision costs the inverse: the same model and samples in `f32` and in `f64`.

use anyhow::{Result, ensure};
use firmware::law::inverse_step;
use firmware::order::BoardTracking;
use model_core::{InverseHysteresis, Invertible, Mgpi, paper};

use super::drive::Parameters;
use super::inputs::Sample;

/// The largest difference between the board's inverse and that of the paper's model in double precision, in the range of
/// the inverse's answer; and the number of the sample where it is.
///
/// # Errors
/// An answer is not finite.
pub fn inverse_error(parameters: &Parameters, samples: &[Sample]) -> Result<(f64, usize)> {
    let tracking = BoardTracking::try_new(parameters)?;
    let single = tracking.inverse();
    let double = Mgpi::try_new(&paper::mgpi()?)?.inverse()?;
    let range = double.input_range();
    let (mut single_state, mut double_state) = (single.rest_state(), double.rest_state());
    let mut largest = (0.0, 0);
    for (number, sample) in samples.iter().enumerate() {
        let answer = inverse_step(single, &mut single_state, sample.reference_mm)?;
        let exact = double.step(&mut double_state, f64::from(sample.reference_mm))?;
        let error = (f64::from(answer) - exact).abs() / (range.max() - range.min());
        ensure!(
            error.is_finite(),
            "sample {number}, {sample:?}: the inverse answers {answer} instead of {exact}"
        );
        if error > largest.0 {
            largest = (error, number);
        }
    }
    Ok(largest)
}
