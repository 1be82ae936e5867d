//! How much later a driven muscle answers whose loop is wider the faster it moves.
//!
//! The faster the muscle slides, the more pressure its friction takes. To a small change of the
//! command it then answers as a viscous muscle does, with a lag: the change of the pressure that is
//! needed over the change of the speed of that pressure. Where the friction grows by a power of the
//! speed below 1, this lag is the longer, the slower the muscle moves. A muscle that has just turned
//! round does not slide, and has no such lag.
//!
//! It is taken from the model itself, by ramps through its range at two speeds that are near each
//! other, so that it holds for any way in which a model depends on the rate.

use model_core::extension::Sample;
use model_core::{ExtensionParameters, ParameterError, Surroundings};
use recording::model::HostExtendedModel;
use recording::model_file::ModelFile;

use crate::slopes::{PLACES, SWEEPS, Slope};

/// Times in which a ramp goes through the input's range: from a fast reference to one so slow that
/// the slowest loop that is tuned for ([`crate::SLOWEST`]) is ten times faster. Unit: s.
const SWEEPS_S: [f64; SWEEPS] = [1.0, 10.0, 100.0];
/// Shares of such a time between which the change with the speed is taken.
const NEAR: [f64; 2] = [1.05, 0.95];
/// Steps of a ramp, a multiple of twice the places, and those to either side of a place over which
/// its slope is taken: 2 % of the range in all, as [`crate::slopes`] does.
const STEPS: usize = 800;
const AROUND: usize = 8;

/// The filter of the rate in a model whose width depends on it. Unit: s.
pub fn filter_s(extensions: &ExtensionParameters<f64>) -> Option<f64> {
    let width = extensions.rate_dependent_width.as_ref().map(|width| width.filter_s);
    width.or(extensions.rate_dependent_thresholds.as_ref().map(|thresholds| thresholds.filter_s))
}

/// Adds to the slopes of a model how late it is at each speed.
///
/// # Errors
/// The parameters or the extensions of the file are not valid.
pub fn add(file: &ModelFile, slopes: &mut [Slope]) -> Result<(), ParameterError> {
    if filter_s(&file.extensions).is_none() {
        return Ok(());
    }
    // A viscosity, a mass and a delay are looked at by themselves.
    let extensions = ExtensionParameters {
        rate_dependent_width: file.extensions.rate_dependent_width.clone(),
        rate_dependent_thresholds: file.extensions.rate_dependent_thresholds.clone(),
        ..ExtensionParameters::default()
    };
    let model = HostExtendedModel::try_new(&file.parameters, &extensions)?;
    let (low, high) = file.parameters.input();
    for (speed, sweep_s) in SWEEPS_S.into_iter().enumerate() {
        let [slower, faster] = NEAR.map(|share| ramps(&model, (low, high), share * sweep_s));
        let difference = (high - low) * (1.0 / (NEAR[1] * sweep_s) - 1.0 / (NEAR[0] * sweep_s));
        for (place, slope) in slopes.iter_mut().enumerate() {
            let is_rising = place < PLACES;
            // A faster ramp is behind: lower on the way up, higher on the way down.
            let behind = (slower[place].0 - faster[place].0) * if is_rising { 1.0 } else { -1.0 };
            let driven = 0.5 * (slower[place].1 + faster[place].1);
            slope.sliding_s[speed] = if driven > 0.0 { (behind / driven / difference).max(0.0) } else { 0.0 };
        }
    }
    Ok(())
}

/// Output and slope at each place of ramps up and down through a range in a time (s) each.
fn ramps(model: &HostExtendedModel, (low, high): (f64, f64), sweep_s: f64) -> Vec<(f64, f64)> {
    let mut state = model.rest_state();
    let mut answer = |input: f64| {
        let sample = Sample { input, surroundings: Surroundings::default(), dt_s: sweep_s / STEPS as f64 };
        // Inputs within the range are finite: no step is refused.
        model.step(&mut state, &sample).map(|output| output.contraction).unwrap_or_default()
    };
    let step = (high - low) / STEPS as f64;
    let up: Vec<f64> = (0..=STEPS).map(|k| answer(low + step * k as f64)).collect();
    let down: Vec<f64> = (0..=STEPS).map(|k| answer(high - step * k as f64)).collect();
    let of = |branch: &[f64], way: f64| {
        (0..PLACES)
            .map(|place| {
                let at = (2 * place + 1) * STEPS / (2 * PLACES);
                let slope = (branch[at + AROUND] - branch[at - AROUND]) / (2 * AROUND) as f64 / step;
                (branch[at], way * slope)
            })
            .collect::<Vec<_>>()
    };
    [of(&up, 1.0), of(&down, -1.0)].concat()
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use super::*;
    use crate::margins::margins;
    use crate::response::Feedback;
    use crate::slopes::slopes;
    use crate::{SENSITIVITY, feedback, tune};

    const PAPER: &str = include_str!("../../../examples/paper-tables-1-2.toml");
    const WIDTH: &str = "[extensions.rate_dependent_width]\nradius_bar = 0.05\nexponent = 0.5\n\
                         filter_s = 0.01\nknots_mm = [0.0, 100.0]\nwidth_bar = [0.02, 0.02]\n";

    const KNOWN: &str = "[recorded]\nstep_s = 0.005\nnoise_mm = 0.01\nsteeper = 1.2\nlate_s = 0.0\n\
                         late_error_s = 0.001\n";

    fn file(extension: &str) -> ModelFile {
        let text = format!("{PAPER}\n{extension}");
        ModelFile::parse(Path::new("model.toml"), &text).expect("valid")
    }

    fn of(extension: &str) -> Vec<Slope> {
        let file = file(extension);
        let mut slopes = slopes(&file.model);
        add(&file, &mut slopes).expect("valid");
        slopes
    }

    #[test]
    fn a_width_by_the_root_of_the_rate_makes_later_by_half_the_width_over_the_root() {
        let range = 6.0;
        // Behind a turn a fast ramp needs some way until the friction has turned round.
        for (_, slope) in of(WIDTH).into_iter().enumerate().filter(|(place, _)| place % PLACES >= 3) {
            for (sweep_s, late_s) in SWEEPS_S.into_iter().zip(slope.sliding_s) {
                // p = u + 0.02 sqrt(u'): dp/du' = 0.01/sqrt(u'), and u' is p' at a constant speed.
                let expected_s = 0.01 / f64::sqrt(range / sweep_s);
                assert!((late_s / expected_s - 1.0).abs() < 0.15, "{late_s} s, {expected_s} s: {slope:?}");
            }
        }
    }

    #[test]
    fn thresholds_that_grow_with_the_rate_make_later_the_slower_the_muscle_moves() {
        let thresholds = "[extensions.rate_dependent_thresholds]\nexponent = 0.5\nfilter_s = 0.01\n\
                          knots_mm = [0.0, 100.0]\ngain = [0.05, 0.05]\n";
        let middle = of(thresholds)[3];
        assert!(middle.sliding_s[0] > 0.0, "{middle:?}");
        assert!(middle.sliding_s.windows(2).all(|pair| pair[1] > 2.0 * pair[0]), "{middle:?}");
    }

    #[test]
    fn a_loop_that_is_wider_the_faster_it_moves_gets_an_integral_that_its_slow_moves_bear() {
        let tuned = |extension: &str| {
            tune(&file(&format!("{extension}{KNOWN}")), 1e-3, Some(0.03), false).expect("safe")
        };
        let (narrow, wide) = (tuned(""), tuned(&WIDTH.replace("0.02", "0.1")));
        assert!(wide.tuning.ki < 0.7 * narrow.tuning.ki, "{:?}, {:?}", wide.tuning, narrow.tuning);
        assert!(wide.tuning.maximum_sensitivity <= SENSITIVITY);
        let kept = |feedback: &Feedback| margins(&wide.view.plants(feedback), feedback).maximum_sensitivity;
        assert!(kept(&feedback(&narrow.tuning)) > SENSITIVITY);
    }

    #[test]
    fn without_a_width_by_the_rate_nothing_is_later() {
        assert!(of("").iter().all(|slope| slope.sliding_s == [0.0; SWEEPS]));
    }
}
