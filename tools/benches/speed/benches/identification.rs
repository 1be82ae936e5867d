//! How long an identification takes by the number of rows: cycles of falling height of the paper's
//! model with noise on both columns, 12,000 to a million rows. The claim: beyond some hundred
//! thousand rows no more than in proportion, since searches are made on a thinned recording and
//! only their ends on all rows. Run with `cargo bench
//! --manifest-path tools/benches/speed/Cargo.toml --bench identification`, on quiet cores.

use std::time::Duration;

use criterion::{BenchmarkId, Criterion, Throughput, criterion_group, criterion_main};
use identification::{CONVERGED, Loss, Options, Problem, Weights, identify, simulate};
use model_core::{Kind, Model, ModelParameters};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

const ROWS: [usize; 3] = [12_000, 100_000, 1_000_000];
/// Noise of the pressure and of the contraction, to either side. Units: bar, mm.
const NOISE: (f64, f64) = (0.003, 0.05);
/// Identifications of each length, and the time that is expected to be enough for them.
const SAMPLES: usize = 10;
const ENOUGH: Duration = Duration::from_secs(60);

/// Input and output of so many rows.
fn recording(rows: usize) -> (Vec<f64>, Vec<f64>) {
    let truth = model_core::paper::mgpi().and_then(|parameters| parameters.convert()).expect("valid");
    let truth = Model::try_new(&ModelParameters::Cascade(truth)).expect("valid");
    let mut random = ChaCha8Rng::seed_from_u64(1);
    let triangle = |share: f64| {
        let cycle = share * 12.0;
        (6.0 - (cycle % 6.0).floor()) * (1.0 - (2.0 * cycle.fract() - 1.0).abs())
    };
    let input: Vec<f64> = (0..rows).map(|row| triangle(row as f64 / rows as f64)).collect();
    let mut noise = |value: &f64, size: f64| value + size * random.random_range(-1.0..1.0);
    let output = simulate(&truth, &input).iter().map(|y| noise(y, NOISE.1)).collect();
    (input.iter().map(|x| noise(x, NOISE.0)).collect(), output)
}

fn identifications(criterion: &mut Criterion) {
    let options = Options {
        model: Kind::Mgpi,
        knots: None,
        plays: 10,
        weights: Weights::Exponential,
        dead_zones: 10,
        loss: Loss::Squares,
        starts: 24,
        seed: 1,
        threads: 0,
        tolerance: CONVERGED,
    };
    let mut group = criterion.benchmark_group("identification");
    group.sample_size(SAMPLES).measurement_time(ENOUGH);
    for rows in ROWS {
        let (input, output) = recording(rows);
        let problem = Problem { input: &input, output: &output, scored: &vec![true; rows] };
        group.throughput(Throughput::Elements(rows as u64));
        group.bench_function(BenchmarkId::from_parameter(rows), |bencher| {
            bencher.iter(|| identify(&problem, &options, &|_| ()).is_ok());
        });
    }
    group.finish();
}

criterion_group!(benches, identifications);
criterion_main!(benches);
