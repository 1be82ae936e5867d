//! The bank of plays beside the paper's sums: time per sample over a smooth reference, n = 10,
//! 100, 1000.
//!
//! More than ten plays are kept by turning points, up to ten by their outputs, which is faster for
//! those. The claim behind the turning points: their time hardly grows with n. So ten plays are
//! measured kept by either. Run with `cargo bench -p model-core`.

#[path = "../tests/reference/mod.rs"]
mod reference;

use std::hint::black_box;

use divan::Bencher;
use divan::counter::ItemsCount;
use model_core::play::{PlayBank, PlayParameters, PlayState};
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

fn main() {
    divan::main();
}

/// A bank with room for one play more than it has: only with room for more than ten are plays kept
/// by turning points.
fn bank<const ROOM: usize>() -> PlayBank<f64, ROOM> {
    PlayBank::try_new(&parameters(ROOM - 1)).expect("valid")
}

/// Measures a course through a bank. `state`: at rest.
fn run<const ROOM: usize>(bencher: Bencher, bank: &PlayBank<f64, ROOM>, mut state: PlayState<f64, ROOM>) {
    let reference = reference();
    bencher.counter(ItemsCount::new(SAMPLES)).bench_local(|| {
        reference.iter().map(|&v| bank.step(&mut state, black_box(v)).unwrap_or(0.0)).sum::<f64>()
    });
}

#[divan::bench(consts = [11, 101, 1001])]
fn by_turning_points<const ROOM: usize>(bencher: Bencher) {
    let bank = bank::<ROOM>();
    let state = bank.by_turning_points(&bank.rest_state(0.0));
    run(bencher, &bank, state);
}

/// Ten plays only: more are always kept by turning points.
#[divan::bench]
fn by_outputs(bencher: Bencher) {
    let bank = bank::<11>();
    let state = bank.rest_state(0.0);
    run(bencher, &bank, state);
}

#[divan::bench(consts = [11, 101, 1001])]
fn plain<const ROOM: usize>(bencher: Bencher) {
    let reference = reference();
    let mut plain = PlainBank::<f64, ROOM>::new(&parameters(ROOM - 1));
    bencher
        .counter(ItemsCount::new(SAMPLES))
        .bench_local(|| reference.iter().map(|&v| plain.step(black_box(v))).sum::<f64>());
}
