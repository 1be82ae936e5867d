//! What the identification claims, on models whose truth is known.

use super::descent::{Limits, search};
use super::problem::Problem as Reduced;
use super::*;
use crate::progress::Planned;
use levenberg_marquardt::LeastSquaresProblem;
use model_core::List;
use model_core::dead_zone::DeadZoneParameters;
use model_core::envelope::{EnvelopeParameters, TanhParameters};
use model_core::mgpi::MgpiParameters;
use model_core::play::PlayParameters;
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

/// Triangles of decreasing amplitude, 0 to 6 bar: major and minor loops.
pub fn triangles() -> Vec<f64> {
    let turns = [0.0, 6.0, 0.0, 5.0, 0.0, 4.0, 0.0, 3.0, 1.0, 4.5, 2.0, 5.5, 0.0];
    turns
        .windows(2)
        .flat_map(|ends| (0..150).map(move |k| ends[0] + (ends[1] - ends[0]) * f64::from(k) / 150.0))
        .collect()
}

/// A model of the very class that is searched: γ from 0 to 1, knots over all of u.
pub fn truth() -> HostModel {
    truth_with_decay(0.7)
}

/// The same, the weights of the plays falling from play to play by a factor of exp `beta`.
fn truth_with_decay(beta: f64) -> HostModel {
    HostModel::try_new(&truth_parameters(beta)).expect("valid")
}

fn truth_parameters(beta: f64) -> HostParameters {
    let (a, b): (f64, f64) = (2.2, -0.4);
    let (g0, g1) = (b.tanh(), (a + b).tanh());
    let weights = [0.9, 0.06, 0.03, 0.01];
    let mut plays = PlayParameters { q: 0.4, thresholds: List::new(), weights: List::new() };
    let sum: f64 = (1..=4).map(|i| f64::exp(-beta * f64::from(i))).sum();
    let mut u_max = 0.4;
    for i in 1..=weights.len() {
        let (r, p) = (0.06 * i as f64, 0.6 * f64::exp(-beta * i as f64) / sum);
        u_max += p * (1.0 - r);
        plays.thresholds.push(r).expect("fits");
        plays.weights.push(p).expect("fits");
    }
    HostParameters::Cascade(MgpiParameters {
        envelope: EnvelopeParameters::Tanh(TanhParameters {
            c0: 1.0 / (g1 - g0),
            c1: a / 6.0,
            c2: b,
            c3: -g0 / (g1 - g0),
        }),
        plays,
        dead_zones: DeadZoneParameters {
            thresholds: (0..4).map(|j| f64::from(j) * u_max / 4.0).collect(),
            weights: [60.0, 40.0, 30.0, -50.0].into_iter().collect(),
            offset: -3.0,
        },
        input_min: 0.0,
        input_max: 6.0,
        preconditioned: false,
    })
}

pub fn options() -> Options {
    Options {
        model: Kind::Mgpi,
        knots: None,
        weights: Weights::Exponential,
        loss: Loss::Squares,
        plays: 4,
        dead_zones: 4,
        starts: 8,
        seed: 1,
        threads: 1,
        tolerance: CONVERGED,
    }
}

fn rms(differences: impl Iterator<Item = f64>) -> f64 {
    let squares: Vec<f64> = differences.map(|d| d * d).collect();
    (squares.iter().sum::<f64>() / squares.len() as f64).sqrt()
}

pub fn fit(input: &[f64], output: &[f64], options: &Options) -> Result<Fit, IdentificationError> {
    identify(&Problem { input, output, scored: &vec![true; input.len()] }, options, &|_| ())
}

pub fn data(input: &[f64], output: &[f64], options: &Options) -> Data {
    let scored = vec![true; input.len()];
    normalise(&[Problem { input, output, scored: &scored }], options).expect("sound data")
}

#[test]
fn a_model_of_the_class_is_recovered_from_its_own_output() {
    let input = triangles();
    let output = simulate(&truth(), &input);
    let fit = fit(&input, &output, &options()).expect("identified");
    let error = rms(fit.simulated.iter().zip(&output).map(|(model, truth)| model - truth));
    assert!(error < 1e-4, "RMSE {error} mm");
    assert!(fit.termination.converged(), "{:?}", fit.termination);
    let estimate = |name: &str| {
        fit.uncertainty
            .estimates
            .iter()
            .find(|e| e.parameter.name == name)
            .expect("estimated")
            .parameter
            .value
    };
    for (name, value) in [("alpha", 0.06), ("q", 0.4), ("offset", -3.0), ("w1", 40.0), ("c1", 2.2 / 6.0)] {
        assert!(
            (estimate(name) - value).abs() < 1e-3 * value.abs(),
            "{name} = {}, truth {value}",
            estimate(name)
        );
    }
}

#[test]
fn weights_that_grow_from_play_to_play_are_recovered() {
    let input = triangles();
    let output = simulate(&truth_with_decay(-0.4), &input);
    let fit = fit(&input, &output, &options()).expect("identified");
    let error = rms(fit.simulated.iter().zip(&output).map(|(model, truth)| model - truth));
    assert!(error < 1e-4, "RMSE {error} mm");
    let Density::Exponential { tau, .. } = fit.density else { panic!("{:?}", fit.density) };
    assert!((tau + 0.4 / 0.06).abs() < 1e-2, "tau {tau}");
}

#[test]
fn at_the_end_nothing_is_left_for_a_joint_polish() {
    let input = triangles();
    let output: Vec<f64> = simulate(&truth(), &input).iter().map(|y| y + 0.5 * (0.3 * y).sin()).collect();
    for model in Kind::ALL {
        let options = Options { model, ..options() };
        let data = data(&input, &output, &options);
        let work = Work::new(1.0, &|_| ());
        let searches = Searches { options: &options, plan: Plan::new(data.count(), &options), work: &work };
        let (start, _) = searches.everywhere::<16>(&data).swap_remove(0);
        let point = Point::<16>::new(&data, start, None);
        let jacobian = jacobian(&data, &point);
        let residuals = nalgebra::DVector::from_vec(point.residuals(&data));
        let at = data.coordinates.iter().zip(&point.at.coordinates);
        let is_free = at.map(|(coordinate, value)| !coordinate.is_at_bound(*value));
        for (place, is_free) in is_free.chain(point.linear.free.iter().copied()).enumerate() {
            let row = jacobian.row(place);
            let cosine = (row * &residuals)[0] / (row.norm() * residuals.norm());
            assert!(!is_free || cosine.abs() < 1e-3, "{model}, unknown {place}: {cosine}");
        }
    }
}

/// The Jacobian at all unknowns, a row each; a column for each row of the recording that counts.
fn jacobian<const K: usize>(data: &Data, point: &Point<K>) -> nalgebra::DMatrix<f64> {
    let unknowns: Vec<usize> = (0..point.all_derivatives().len()).collect();
    let turn = nalgebra::DMatrix::identity(unknowns.len(), unknowns.len());
    let mut values = Vec::new();
    point.derivatives_along(data, &unknowns, &turn, |row| values.extend_from_slice(row));
    nalgebra::DMatrix::from_vec(unknowns.len(), data.count(), values)
}

#[test]
fn the_sums_are_those_of_the_rows_one_by_one() {
    let input = triangles();
    let output: Vec<f64> = simulate(&truth(), &input).iter().map(|y| y + 0.5 * (0.3 * y).sin()).collect();
    for model in Kind::ALL {
        let data = data(&input, &output, &Options { model, ..options() });
        for start in starts::starts(&data.coordinates, 4, 3) {
            let point = Point::<16>::new(&data, start, None);
            let (jacobian, residuals) = (jacobian(&data, &point), point.residuals(&data));
            let products = &jacobian * jacobian.transpose();
            let error = (point.information() - &products).amax() / products.amax();
            assert!(error < 1e-12, "{model}: JᵀJ is wrong by {error}");
            let squares: f64 = residuals.iter().map(|r| r * r).sum();
            assert!((point.cost / squares - 1.0).abs() < 1e-9, "{model}: {} for {squares}", point.cost);
        }
    }
}

#[test]
fn huber_finds_the_outliers_and_is_not_moved_by_them() {
    let input = triangles();
    let truth = simulate(&truth(), &input);
    let mut random = ChaCha8Rng::seed_from_u64(4);
    let mut output: Vec<f64> = truth.iter().map(|y| y + random.random_range(-0.1..0.1)).collect();
    // A sensor that drops out now and then, and always to the same side.
    let spoilt: Vec<usize> = (0..input.len()).filter(|row| row % 37 == 5).collect();
    spoilt.iter().for_each(|&row| output[row] += 20.0);
    let of = |loss| fit(&input, &output, &Options { loss, ..options() }).expect("identified");
    let error = |fit: &Fit| rms(fit.simulated.iter().zip(&truth).map(|(model, truth)| model - truth));
    let (squares, huber) = (of(Loss::Squares), of(Loss::Huber));
    println!("RMSE from the truth {} mm by squares, {} mm by Huber", error(&squares), error(&huber));
    assert!(squares.outliers.is_empty());
    assert_eq!(huber.outliers, spoilt);
    assert!(error(&huber) < 0.1 * error(&squares) && error(&huber) < 0.05);
}

#[test]
fn free_weights_fit_at_least_as_well_and_recover_those_of_no_density() {
    let mut truth = truth_parameters(0.7);
    let HostParameters::Cascade(cascade) = &mut truth else { panic!("a cascade") };
    let free = [0.05, 0.3, 0.02, 0.23];
    cascade.plays.weights.iter_mut().zip(free).for_each(|(weight, value)| *weight = value);
    // The knots are to lie over all of u, as those of the models searched do.
    let driven = cascade.plays.thresholds.iter().zip(free).map(|(r, p)| p * (1.0 - r));
    let u_max = cascade.plays.q + driven.sum::<f64>();
    cascade.dead_zones.thresholds.iter_mut().enumerate().for_each(|(j, d)| *d = j as f64 * u_max / 4.0);
    let input = triangles();
    let output = simulate(&HostModel::try_new(&truth).expect("valid"), &input);
    let of = |weights| fit(&input, &output, &Options { weights, ..options() }).expect("identified");
    let error = |fit: &Fit| rms(fit.simulated.iter().zip(&output).map(|(model, truth)| model - truth));
    let (exponential, freed) = (of(Weights::Exponential), of(Weights::Free));
    println!("RMSE {} mm with a density, {} mm with free weights", error(&exponential), error(&freed));
    assert!(error(&freed) < 0.1 * error(&exponential));
}

/// Searches and models must see the same muscle: fresh or preconditioned, with one envelope or two.
#[test]
fn u_is_that_of_the_model_which_the_search_ends_in() {
    let mut random = ChaCha8Rng::seed_from_u64(3);
    let input: Vec<f64> = (0..2000).map(|_| random.random_range(-1.0..4.0)).collect();
    let output: Vec<f64> = input.iter().map(|x| 10.0 * x + x * x).collect();
    for model in Kind::ALL {
        let options = Options { model, ..options() };
        let data = data(&input, &output, &options);
        let work = Work::new(1.0, &|_| ());
        let searches = Searches { options: &options, plan: Plan::new(data.count(), &options), work: &work };
        for start in starts::starts(&data.coordinates, 8, 2) {
            for start in [start.of_other_kind(), start] {
                let limits = Limits { patience: 1, tolerance: CONVERGED };
                let end = search::<16>(&data, &start, limits, &work.begin(Planned::default()));
                let point = Point::<16>::new(&data, end.0.clone(), None);
                let problem = Problem { input: &input, output: &output, scored: &vec![true; input.len()] };
                let Ok(fit) = searches.finish::<16>(&[problem], &data, end) else { continue };
                for (row, (y, residual)) in fit.simulated.iter().zip(point.residuals(&data)).enumerate() {
                    let searched = output[row] + residual;
                    assert!((y - searched).abs() < 1e-7, "{model}, row {row}: {y} against {searched}");
                }
            }
        }
    }
}

#[test]
fn the_projected_gradient_is_that_of_the_cost() {
    let input = triangles();
    let output: Vec<f64> = simulate(&truth(), &input).iter().map(|y| y + 0.8 * (0.3 * y).sin()).collect();
    for (model, knots) in [
        (Kind::Cpi, None),
        (Kind::Sgpi, None),
        (Kind::Agpi, None),
        (Kind::Mpi, None),
        (Kind::Egpi, None),
        (Kind::Mgpi, None),
        (Kind::Mgpi, Some(6)),
    ] {
        let options = Options { model, knots, ..options() };
        check_gradient(&data(&input, &output, &options), &options);
    }
    check_gradient_of_free_weights(data(&input, &output, &options()), &options());
    // Inputs of both signs, and inputs above 0 only: the knots of the dead zones move with them.
    for shift in [-2.5, 1.0] {
        let input: Vec<f64> = input.iter().map(|x| x + shift).collect();
        let options = Options { model: Kind::Mpi, ..options() };
        check_gradient(&data(&input, &output, &options), &options);
    }
}

fn check_gradient_of_free_weights(data: Data, options: &Options) {
    check_gradient(&data.with_free_weights(), options);
}

fn check_gradient(data: &Data, options: &Options) {
    for start in starts::starts(&data.coordinates, options.starts, options.seed) {
        let work = Work::new(1.0, &|_| ());
        let part = work.begin(Planned::default());
        let mut problem = Reduced::<16>::new(data, &start, &part);
        let variables = problem.params();
        let residuals = problem.residuals().expect("residuals");
        let gradient = problem.jacobian().expect("Jacobian").tr_mul(&residuals);
        for c in 0..data.coordinates.len() {
            let mut half_cost = |by: f64| {
                let mut moved = variables.clone();
                moved[c] += by;
                problem.set_params(&moved);
                problem.residuals().expect("residuals").norm_squared() / 2.0
            };
            let numeric = (half_cost(1e-6) - half_cost(-1e-6)) / 2e-6;
            // Rows at a kink of a play or knot see one side only: a few in two thousand.
            let tolerance = 1e-3 * gradient.amax();
            assert!(
                (gradient[c] - numeric).abs() < tolerance,
                "{:?}, coordinate {c}: {} against {numeric}",
                options.model,
                gradient[c]
            );
        }
    }
}

#[test]
fn the_result_depends_on_the_seed_and_not_on_the_threads() {
    let input = triangles();
    let output: Vec<f64> = simulate(&truth(), &input).iter().map(|y| y + 0.5 * (0.3 * y).sin()).collect();
    let one = fit(&input, &output, &options()).expect("identified");
    let many = fit(&input, &output, &Options { threads: 4, ..options() }).expect("identified");
    assert_eq!(one.parameters, many.parameters);
}

#[test]
fn noise_cannot_make_the_model_non_invertible() {
    let mut random = ChaCha8Rng::seed_from_u64(5);
    let input = triangles();
    for _ in 0..5 {
        // Nothing but noise: the worst there is for positive slopes.
        let output: Vec<f64> = input.iter().map(|_| random.random_range(-1.0..1.0)).collect();
        let fit = fit(&input, &output, &options()).expect("identified");
        assert!(fit.model.smallest_output_slope() > 0.0);
        assert!(fit.model.inverse().is_ok());
    }
}

#[test]
fn rows_that_do_not_count_drive_the_model_and_are_not_fitted() {
    let input = triangles();
    let truth = simulate(&truth(), &input);
    let scored: Vec<bool> = (0..input.len()).map(|row| !(300..500).contains(&row)).collect();
    let output: Vec<f64> = truth.iter().zip(&scored).map(|(y, &ok)| if ok { *y } else { 1e3 }).collect();
    let fit = identify(&Problem { input: &input, output: &output, scored: &scored }, &options(), &|_| ());
    let error =
        rms(fit.expect("identified").simulated.iter().zip(&truth).map(|(model, truth)| model - truth));
    assert!(error < 1e-4, "RMSE {error} mm");
}

#[test]
fn standard_errors_are_those_of_repeated_experiments() {
    let input = triangles();
    let clean = simulate(&truth(), &input);
    let mut random = ChaCha8Rng::seed_from_u64(9);
    let mut values: Vec<Vec<f64>> = Vec::new();
    let mut claimed = Vec::new();
    for _ in 0..40 {
        // Uniform noise of ±0.2 mm.
        let output: Vec<f64> = clean.iter().map(|y| y + random.random_range(-0.2..0.2)).collect();
        let fit = fit(&input, &output, &options()).expect("identified");
        values.push(fit.uncertainty.estimates.iter().map(|e| e.parameter.value).collect());
        claimed = fit.uncertainty.estimates;
    }
    for name in ["alpha", "q", "w0", "w3", "offset"] {
        let place = claimed.iter().position(|e| e.parameter.name == name).expect("estimated");
        let mean = values.iter().map(|v| v[place]).sum::<f64>() / values.len() as f64;
        let spread = rms(values.iter().map(|v| v[place] - mean));
        let ratio = claimed[place].standard_error.expect("free") / spread;
        // 40 repetitions know a spread to about ±25 % (two sigma); a factor is what is claimed
        // here.
        assert!((0.6..1.6).contains(&ratio), "{name}: claimed over observed {ratio}");
    }
}

#[test]
fn unusable_problems_are_typed_errors() {
    let input = triangles();
    let output = simulate(&truth(), &input);
    let error = |input: &[f64], output: &[f64], options: Options| fit(input, output, &options).err();
    let few = IdentificationError::TooFewRows { rows: 8, parameters: 10 };
    assert_eq!(error(&input[..8], &output[..8], options()), Some(few));
    assert_eq!(error(&[1.0; 50], &output[..50], options()), Some(IdentificationError::ConstantInput(1.0)));
    assert_eq!(error(&input[..50], &[2.0; 50], options()), Some(IdentificationError::ConstantOutput(2.0)));
    assert_eq!(error(&input, &output[1..], options()), Some(IdentificationError::Lengths));
    let size = IdentificationError::Size("plays", 129, [1, 128]);
    assert_eq!(error(&input, &output, Options { plays: 129, ..options() }), Some(size));
    let mut broken = output.clone();
    broken[7] = f64::NAN;
    assert_eq!(error(&input, &broken, options()), Some(IdentificationError::NotFinite("output", 7)));
}

/// The answers of the true muscle to the two parts of an input, from rest each; where they part.
fn two_parts() -> (Vec<f64>, Vec<f64>, usize) {
    let input = triangles();
    // From 3 bar on the way down to 0: from rest it is elsewhere than if it has come there.
    let part = 1125;
    let answers = [&input[..part], &input[part..]].map(|input| simulate(&truth(), input));
    (input, answers.concat(), part)
}

#[test]
fn of_two_recordings_each_begins_from_rest() {
    let (input, output, part) = two_parts();
    let scored = vec![true; input.len()];
    let parts = [0..part, part..input.len()].map(|rows| Problem {
        input: &input[rows.clone()],
        output: &output[rows.clone()],
        scored: &scored[rows],
    });
    let error = |fit: &Fit| rms(fit.simulated.iter().zip(&output).map(|(model, truth)| model - truth));
    let together = identify_several(&parts, &options(), &|_| ()).expect("identified");
    assert!(error(&together) < 1e-4, "RMSE {} mm", error(&together));
    let as_one = fit(&input, &output, &options()).expect("identified");
    assert!(error(&as_one) > 1e-2, "one recording of both has a past that the second part has not had");
}
