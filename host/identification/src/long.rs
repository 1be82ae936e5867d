//! What is claimed of long recordings, which are searched thinned.

use std::f64::consts::TAU;

use levenberg_marquardt::TerminationReason;
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

use super::data::{Data, normalise};
use super::descent::{Limits, Reached, search};
use super::inner::Inner;
use super::plan::{best, better};
use super::search::{finalists, remove_repeated};
use super::tests::{data, fit, options, truth};
use super::{CONVERGED, Problem, simulate, starts};
use crate::progress::{Planned, Work};

/// Cycles of 40 rows, their amplitude changing, with some noise.
fn cycles(noise: f64) -> Vec<f64> {
    let mut random = ChaCha8Rng::seed_from_u64(8);
    let clean = |row: usize| 0.5 - 0.5 * (row as f64 / 40.0).cos() * (row as f64 * TAU / 40.0).cos();
    (0..60_000).map(|row| clean(row) + noise * random.random_range(-1.0..1.0)).collect()
}

#[test]
fn at_the_rows_of_a_thinned_recording_the_plays_are_where_all_rows_bring_them() {
    for noise in [0.0, 0.02] {
        let inputs = cycles(noise);
        // Every output is the number of its row.
        let outputs: Vec<f64> = (0..inputs.len()).map(|row| row as f64).collect();
        let scored: Vec<bool> = (0..inputs.len()).map(|row| row % 4 != 0).collect();
        let problem = Problem { input: &inputs, output: &outputs, scored: &scored };
        let whole = normalise(&[problem], &options()).expect("sound data");
        let thinned = whole.thinned(2000);
        let count = thinned.count();
        assert!((1000..=2000).contains(&count) && thinned.rows.len() < 10 * count, "{count} rows count");
        let weight: f64 = thinned.rows.iter().map(|row| f64::from(row.weight)).sum();
        assert!((weight / whole.count() as f64 - 1.0).abs() < 0.05, "they stand for {weight} rows");
        let inner = Inner::new(&whole.structure, &[0.8, -0.4, -3.0, 1.2, -0.3], whole.span);
        for preconditioned in [true, false] {
            let u = |data: &Data| -> Vec<f64> {
                let mut muscle = inner.at_rest::<8>(preconditioned);
                data.rows.iter().map(|row| muscle.step(row).u).collect()
            };
            let all = u(&whole);
            for (row, u) in thinned.rows.iter().zip(u(&thinned)).filter(|(row, _)| row.weight > 0.0) {
                let (place, u_of_all) = (row.output, all[row.output as usize]);
                assert!((u - u_of_all).abs() < 1e-12, "row {place}: {u} against {u_of_all}");
            }
        }
    }
}

#[test]
fn of_several_recordings_a_thinned_one_begins_where_each_begins() {
    let inputs = cycles(0.01);
    let outputs: Vec<f64> = (0..inputs.len()).map(|row| row as f64).collect();
    let scored = vec![true; inputs.len()];
    let parts = [0..20_000, 20_000..45_017, 45_017..60_000].map(|rows| Problem {
        input: &inputs[rows.clone()],
        output: &outputs[rows.clone()],
        scored: &scored[rows],
    });
    let whole = normalise(&parts, &options()).expect("sound data");
    let thinned = whole.thinned(2000);
    let inner = Inner::new(&whole.structure, &[0.8, -0.4, -3.0, 1.2, -0.3], whole.span);
    let u = |data: &Data| -> Vec<f64> {
        let mut muscle = inner.at_rest::<8>(true);
        data.rows.iter().map(|row| muscle.step(row).u).collect()
    };
    let all = u(&whole);
    for (row, u) in thinned.rows.iter().zip(u(&thinned)).filter(|(row, _)| row.weight > 0.0) {
        assert!((u - all[row.output as usize]).abs() < 1e-12, "row {}", row.output);
    }
    let weight: f64 = thinned.rows.iter().map(|row| f64::from(row.weight)).sum();
    assert!((weight / 60_000.0 - 1.0).abs() < 0.05, "they stand for {weight} rows");
}

#[test]
fn a_long_recording_has_the_model_that_a_search_on_all_its_rows_has() {
    let inputs: Vec<f64> = cycles(0.01).iter().map(|x| 6.0 * x).collect();
    let mut random = ChaCha8Rng::seed_from_u64(6);
    let clean = simulate(&truth(), &inputs.iter().map(|x| x.clamp(0.0, 6.0)).collect::<Vec<f64>>());
    let output: Vec<f64> =
        clean.iter().map(|y| y + 0.3 * (0.3 * y).sin() + random.random_range(-0.3..0.3)).collect();
    let fit = fit(&inputs, &output, &options()).expect("identified");
    let data = data(&inputs, &output, &options());
    let part = Work::new(1.0, &|_| ());
    let part = part.begin(Planned::default());
    let ends =
        starts::starts(&data.coordinates, 4, 1).into_iter().flat_map(|start| [start.of_other_kind(), start]);
    let ends = ends.map(|start| search::<8>(&data, &start, Limits::to_the_end(CONVERGED), &part));
    let least = ends.map(|(_, reached)| reached.cost).fold(f64::INFINITY, f64::min);
    let squares: f64 = fit.simulated.iter().zip(&output).map(|(model, y)| (model - y).powi(2)).sum();
    // A share of one over the rows is one standard error of one parameter.
    assert!(squares < least * (1.0 + 1.0 / output.len() as f64), "{squares} with thinning, {least} without");
}

#[test]
fn of_a_long_recording_all_starts_go_to_their_ends_and_a_minimum_takes_one_place_among_the_finalists() {
    assert_eq!((best(24, 12_000), best(24, 1_000_000), better(24, 1_000_000)), (6, 24, 24));
    let data = data(&cycles(0.0), &cycles(0.01), &options()).thinned(1000).into_owned();
    let start = starts::starts(&data.coordinates, 1, 1).remove(0);
    let reached = |cost| Reached { cost, reason: TerminationReason::Converged { ftol: true, xtol: false } };
    // A minimum that four searches came to, within a hundredth of a standard error, and four that
    // are as good as it.
    let costs = [1.0, 1.000_01, 1.000_01, 1.000_01, 1.01, 1.02, 1.03, 1.04, 2.0];
    let mut ends: Vec<_> = costs.map(|cost| (start.clone(), reached(cost))).into();
    remove_repeated(&mut ends, &data);
    let left: Vec<f64> = ends.iter().map(|(_, reached)| reached.cost).collect();
    assert_eq!(left, [1.0, 1.01, 1.02, 1.03, 1.04, 2.0]);
    assert_eq!((finalists(&ends, 12_000), finalists(&ends, 1_000_000)), (4, 5));
}
