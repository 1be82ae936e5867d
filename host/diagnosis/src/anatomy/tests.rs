//! What the shares and p-values of the axes claim: what is there is found, and what is not is found no oftener than said.

use std::collections::BTreeMap;

use rayon::prelude::*;

use super::axis::{Axis, AxisMean, LEVEL, axes};
use super::*;
use crate::synthetic::{Noise, held_triangles, times, triangles};

/// A recording of 120 s whose output follows its input, with a temperature that wanders, and a residual.
struct Bench {
    time_s: Vec<f64>,
    input: Vec<f64>,
    output: Vec<f64>,
    temperature: Vec<f64>,
    residual: Vec<f64>,
}

impl Bench {
    fn new(rows: usize, seed: u64, input: impl Fn(f64) -> f64) -> Self {
        let time_s = times(rows, 120.0 / rows as f64);
        let phase = Noise::new(1_000_000 + seed).white(3.0);
        let wander = |t: &f64| (t / 9.0 + phase).sin() + 0.5 * (t / 5.0).sin();
        let input: Vec<f64> = time_s.iter().map(|&t| input(t)).collect();
        Self {
            output: input.iter().map(|u| 20.0 * u).collect(),
            temperature: time_s.iter().map(wander).collect(),
            residual: vec![0.0; rows],
            input,
            time_s,
        }
    }

    /// A residual of half an effect, half autoregressive noise of this seed (by energy).
    fn with(mut self, seed: u64, effect: impl Fn(&Self) -> Vec<f64>) -> Self {
        let rows = self.time_s.len();
        let noise = Noise::new(seed).autoregressive(rows, 0.9);
        let effect = effect(&self);
        let mean = effect.iter().sum::<f64>() / rows as f64;
        let size = root_mean_square(&effect.iter().map(|e| e - mean).collect::<Vec<_>>());
        self.residual = effect.iter().zip(noise).map(|(e, own)| (e - mean) / size + own).collect();
        self
    }

    fn view(&self) -> Residual<'_> {
        Residual {
            time_s: &self.time_s,
            residual: &self.residual,
            input: &self.input,
            output: &self.output,
            load: None,
            temperature: Some(&self.temperature),
        }
    }

    fn axes(&self) -> Vec<AxisMean> {
        let residual = self.view();
        axes(&residual, &Motion::of(&residual), &Cells::of(&self.time_s, &self.residual), 1)
    }

    fn axis(&self, axis: Axis) -> AxisMean {
        self.axes().into_iter().find(|mean| mean.axis == axis).expect("the axis varies")
    }
}

#[test]
fn every_axis_raises_an_alarm_in_3_to_7_of_100_runs_on_white_and_autoregressive_residuals() {
    const RUNS: u64 = 1200;
    // A memory of 15 rows, a fiftieth of the recording, is the longest that is documented.
    for like in [0.0, 0.87] {
        let alarms = |seed: u64| -> Vec<(Axis, bool)> {
            let mut bench = Bench::new(750, seed, |t| held_triangles(t, 3.7));
            bench.residual = Noise::new(seed).autoregressive(750, like);
            bench.axes().iter().map(|mean| (mean.axis, mean.p_value <= LEVEL)).collect()
        };
        let runs: Vec<Vec<(Axis, bool)>> = (0..RUNS).into_par_iter().map(alarms).collect();
        let mut counts: BTreeMap<Axis, u64> = BTreeMap::new();
        runs.into_iter().flatten().for_each(|(axis, alarm)| {
            *counts.entry(axis).or_default() += u64::from(alarm);
        });
        assert_eq!(counts.len(), 9, "load alone is missing: {counts:?}");
        for (axis, count) in counts {
            let share = count as f64 / RUNS as f64;
            assert!((0.03..=0.07).contains(&share), "likeness {like}, {axis}: {share}");
        }
    }
}

#[test]
fn half_of_the_energy_that_goes_with_an_axis_is_found_as_such() {
    let held = |t: f64| held_triangles(t, 3.7);
    for seed in 0..5 {
        let bench = || Bench::new(3000, seed, held);
        let of_input = bench().with(seed, |bench| bench.input.iter().map(|u| (1.5 * u).sin()).collect());
        let of_direction = bench().with(seed, |bench| Motion::of(&bench.view()).direction);
        let of_temperature = bench().with(seed, |bench| bench.temperature.clone());
        let of_time = bench().with(seed, |bench| bench.time_s.clone());
        let of_travel = bench().with(seed, |bench| bench.time_s.iter().map(|t| (-t / 30.0).exp()).collect());
        for (bench, axis) in [
            (of_input, Axis::Input),
            (of_direction, Axis::Direction),
            (of_temperature, Axis::Temperature),
            (of_time, Axis::Time),
            (of_travel, Axis::Travel),
        ] {
            let found = bench.axis(axis);
            assert!((0.38..0.62).contains(&found.share), "seed {seed}, {axis}: {}", found.share);
            assert!(found.p_value <= LEVEL, "seed {seed}, {axis}: {}", found.p_value);
        }
    }
}

#[test]
fn a_regular_excitation_hides_nothing() {
    let bench = Bench::new(3000, 2, |t| triangles(t, 20.0)).with(2, |bench| bench.input.clone());
    let input = bench.axis(Axis::Input);
    assert!(input.share > 0.4 && input.p_value <= 0.01, "{} {}", input.share, input.p_value);
}

#[test]
fn what_goes_with_the_input_is_not_laid_to_the_temperature_or_time() {
    let bench = Bench::new(3000, 1, |t| triangles(t, 9.3)).with(1, |bench| bench.input.clone());
    for axis in [Axis::Temperature, Axis::Time, Axis::Direction] {
        assert_eq!(bench.axis(axis).share, 0.0, "{axis}");
    }
    assert!(bench.axis(Axis::Input).share > 0.4);
}

#[test]
fn creep_shows_over_the_time_since_the_last_change_and_a_lag_over_the_rate() {
    let held = |t: f64| held_triangles(t, 7.5);
    let since = |bench: &Bench| Motion::of(&bench.view()).since_change_s;
    let creep = Bench::new(3000, 2, held).with(2, |bench| since(bench).iter().map(|s| s.min(5.0)).collect());
    let lag = Bench::new(3000, 2, held).with(2, |bench| Motion::of(&bench.view()).rate);
    assert!(creep.axis(Axis::SinceChange).share > 0.4);
    assert!(creep.axis(Axis::Rate).share < 0.3);
    assert!(lag.axis(Axis::Rate).share > 0.4);
}

#[test]
fn the_true_mean_of_a_bin_lies_within_two_standard_errors_in_at_least_nine_of_ten_cases() {
    let cases: Vec<bool> = (0..200_u64)
        .into_par_iter()
        .flat_map(|seed| {
            let mut bench = Bench::new(2000, seed, |t| held_triangles(t, 3.7));
            bench.residual = Noise::new(seed).autoregressive(2000, 0.9);
            let bins = bench.axis(Axis::Input).bins;
            bins.iter().map(|bin| bin.mean.abs() < 2.0 * bin.standard_error).collect::<Vec<_>>()
        })
        .collect();
    let share = cases.iter().filter(|&&within| within).count() as f64 / cases.len() as f64;
    assert!((0.9..0.999).contains(&share), "{share}");
}

#[test]
fn the_same_seed_gives_the_same_anatomy_and_few_rows_none() {
    let bench = Bench::new(1000, 3, |t| triangles(t, 20.0)).with(3, |bench| bench.input.clone());
    let json = || serde_json::to_string(&Anatomy::of(&bench.view(), 7).expect("long enough")).expect("JSON");
    assert_eq!(json(), json());
    let short = Bench::new(99, 3, |t| triangles(t, 20.0));
    let refusal = Anatomy::of(&short.view(), 7).expect_err("too short").to_string();
    assert!(refusal.starts_with("99 scored rows are too few"), "{refusal}");
}

#[test]
fn nothing_breaks_on_a_still_recording_or_one_with_a_single_step_of_time() {
    let still = Bench::new(500, 4, |_| 2.0);
    let anatomy = Anatomy::of(&still.view(), 1).expect("long enough");
    assert_eq!(anatomy.rms, 0.0);
    let mut gap = Bench::new(500, 4, |t| triangles(t, 20.0)).with(4, |bench| bench.input.clone());
    gap.time_s[499] += 1e7;
    assert!(Anatomy::of(&gap.view(), 1).expect("long enough").rms.is_finite());
}

#[test]
fn single_rows_that_are_missing_all_over_make_no_gaps_and_an_hour_does() {
    let mut time_s = times(6000, 0.01);
    let mut row = 0u32;
    // Two of five, in runs of up to five.
    time_s.retain(|_| {
        row = row.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        row >> 16 > 26_000
    });
    let longest_s = time_s.windows(2).map(|pair| pair[1] - pair[0]).fold(0.0, f64::max);
    assert!(longest_s > 0.055, "{longest_s}");
    assert!(recording::noise::steps(&time_s).1 > longest_s);
    time_s.extend(times(6000, 0.01).iter().map(|t| t + 3600.0));
    assert!(recording::noise::steps(&time_s).1 < 0.3);
}
