//! What a muscle reaches between the ends of its command: one that has contracted does not come
//! back to where it began by itself, and what is asked for beyond no controller follows.

use model_core::Hysteresis;
use recording::model_file::ModelFile;

use super::subject::Subject;
use crate::PERIOD_S;

/// How long the command takes from end to end. A choice: twice as long as the benchmark's reference
/// of 20 s, so that no lag adds to what is reached. Unit: s.
const SWEEP_S: f64 = 20.0;

/// Of so many samples the middle one counts: a twentieth of a second. Unit: tick.
const MEDIAN: usize = 50;

/// Where a model comes back to, and how far it goes. Unit: mm.
pub fn of_model(model: &ModelFile) -> (f64, f64) {
    let (low, high) = ends(model);
    let mut state = model.model.rest_state();
    // Inputs within the range are finite: no step is refused.
    let mut at = |input: f64| model.model.step(&mut state, input).unwrap_or_default();
    let (_, highest, back) = (at(low), at(high), at(low));
    (back, highest)
}

/// The same of a plant, whose command goes up and down twice between the ends that a model gives it.
/// Unit: mm.
pub fn of_plant(subject: &Subject, model: &ModelFile) -> (f64, f64) {
    let (low, high) = ends(model);
    let mut plant = subject.plant(false);
    let mut seen_mm: Vec<f64> = (0..(4.0 * SWEEP_S / PERIOD_S) as usize)
        .map(|tick| {
            let time_s = tick as f64 * PERIOD_S;
            let share = 1.0 - ((time_s / SWEEP_S).rem_euclid(2.0) - 1.0).abs();
            plant.step(low + share * (high - low), if tick == 0 { 0.0 } else { PERIOD_S });
            plant.exact_mm()
        })
        .collect();
    let contracted = seen_mm.split_off((SWEEP_S / PERIOD_S) as usize);
    // An outlier of the sensor is no contraction.
    let middles = contracted.chunks(MEDIAN).map(|chunk| {
        let mut sorted = chunk.to_vec();
        sorted.sort_by(f64::total_cmp);
        sorted[sorted.len() / 2]
    });
    middles.fold((f64::INFINITY, f64::NEG_INFINITY), |(least, most), mm| (least.min(mm), most.max(mm)))
}

/// The ends of the command. Unit: bar.
fn ends(model: &ModelFile) -> (f64, f64) {
    let (low, high) = model.parameters.input();
    (low.max(0.0), high)
}

/// What is left of a reference, RMSE in mm, by a controller that follows it wherever the muscle
/// reaches.
pub fn beyond_mm(reference_mm: &[f64], (low, high): (f64, f64)) -> f64 {
    let squares: f64 = reference_mm.iter().map(|mm| (mm - mm.clamp(low, high)).powi(2)).sum();
    (squares / reference_mm.len() as f64).sqrt()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_sound_muscle_comes_back_to_where_its_model_says_and_not_to_where_it_began() {
        let subject = Subject::Rig { effects: Vec::new(), rich: false, seed: 5 };
        let text = include_str!("../../../examples/paper-tables-1-2.toml");
        let model = ModelFile::parse(std::path::Path::new("model.toml"), text).expect("valid");
        let (back, highest) = of_model(&model);
        let (low, _) = model.model.output_range();
        assert!(back > low && highest > back, "{low}, {back}, {highest}");
        let (from, to) = of_plant(&subject, &model);
        let near = 0.01 * (highest - back);
        assert!(
            (from - back).abs() < near && (to - highest).abs() < near,
            "{from} to {to}, {back} to {highest}"
        );
        assert!(from > low + near, "{low}, {from}");
    }

    #[test]
    fn a_reference_within_reach_has_nothing_beyond() {
        assert_eq!(beyond_mm(&[1.0, 2.0, 3.0], (1.0, 3.0)), 0.0);
        assert!((beyond_mm(&[0.0, 2.0, 6.0, 2.0], (0.0, 4.0)) - 1.0).abs() < 1e-12);
    }
}
