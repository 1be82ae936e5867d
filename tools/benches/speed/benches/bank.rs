//! The bank of plays beside the paper's sums: time per sample over a smooth reference, n = 10,
//! 100, 1000.
//!
//! More than ten plays are kept by turning points, up to ten by their outputs, which is faster for
//! those. The claim behind the turning points: their time hardly grows with n. So ten plays are
//! measured kept by either. Run with `cargo bench --manifest-path
//! tools/benches/speed/Cargo.toml --bench bank`.

#[path = "../../../../model-core/tests/reference/mod.rs"]
mod reference;

use std::hint::black_box;

use criterion::{BenchmarkId, Criterion, Throughput, criterion_group, criterion_main};
use model_core::play::{PlayBank, PlayParameters};
use reference::PlainBank;

const SAMPLES: usize = 10_000;

/// Raised cosines of changing height: major and minor loops, smooth.
fn reference() -> Vec<f64> {
    let angle = |k: usize| std::f64::consts::TAU * k as f64 / 2000.0;
    (0..SAMPLES).map(|k| (0.7 + 0.3 * (angle(k) / 7.3).cos()) * (1.0 - angle(k).cos()) / 2.0).collect()
}

fn parameters<const N: usize>(plays: usize) -> PlayParameters<f64, N> {
    let alpha = 0.8 / plays as f64;
    PlayParameters::exponential(plays, 0.3, 1.4 / plays as f64, 2.0, alpha).expect("they fit")
}

/// `PLAYS` of them, in banks with room for one more: only with room for more than ten are plays
/// kept by turning points.
fn banks<const PLAYS: usize, const N: usize>(criterion: &mut Criterion) {
    let reference = reference();
    let mut group = criterion.benchmark_group("bank");
    group.throughput(Throughput::Elements(SAMPLES as u64));
    let bank = PlayBank::<f64, N>::try_new(&parameters(PLAYS)).expect("valid");
    let rest = bank.rest_state(0.0);
    let mut kept = vec![("turning points", bank.by_turning_points(&rest))];
    if kept[0].1 != rest {
        kept.push(("outputs", rest));
    }
    for (name, mut state) in kept {
        group.bench_function(BenchmarkId::new(name, PLAYS), |bencher| {
            bencher.iter(|| {
                reference.iter().map(|&v| bank.step(&mut state, black_box(v)).unwrap_or(0.0)).sum::<f64>()
            });
        });
    }
    let mut plain = PlainBank::<f64, PLAYS>::new(&parameters(PLAYS));
    group.bench_function(BenchmarkId::new("plain", PLAYS), |bencher| {
        bencher.iter(|| reference.iter().map(|&v| plain.step(black_box(v))).sum::<f64>());
    });
    group.finish();
}

criterion_group!(benches, banks::<10, 11>, banks::<100, 101>, banks::<1000, 1001>);
criterion_main!(benches);
