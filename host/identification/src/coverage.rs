//! Whether the 95 % intervals hold the truth as often as they say, by Monte Carlo.

use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

use super::tests::{fit, options, triangles, truth};
use super::{Options, simulate};
use recording::model::named::Named;

/// Recordings of each kind of noise.
const RECORDINGS: usize = 50;
/// Standard deviation of the noise. Unit: mm.
const SIGMA: f64 = 0.2;

/// Noise of which each value is `memory` times the last one and something new, of standard
/// deviation [`SIGMA`].
fn noise(random: &mut ChaCha8Rng, memory: f64, count: usize) -> Vec<f64> {
    // The sum of twelve uniform numbers is as good as normal of variance 1.
    let mut normal = || (0..12).map(|_| random.random_range(-0.5..0.5)).sum::<f64>();
    let mut last = SIGMA * normal();
    let mut next = || {
        last = memory * last + SIGMA * (1.0 - memory * memory).sqrt() * normal();
        last
    };
    (0..count).map(|_| next()).collect()
}

/// How often the interval of a parameter was given, how often it held the truth, and the sum of its
/// reach.
#[derive(Clone, Default)]
struct Count {
    cases: usize,
    covered: usize,
    reach: f64,
}

#[test]
fn coverage_of_the_intervals_is_what_they_claim() {
    let input = triangles();
    let clean = simulate(&truth(), &input);
    let options = Options { starts: 4, ..options() };
    // Without noise the search ends in the truth.
    let truth = fit(&input, &clean, &options).expect("identified").uncertainty.estimates;
    for memory in [0.0, 0.9] {
        let mut random = ChaCha8Rng::seed_from_u64(21);
        let mut counts = vec![Count::default(); truth.len()];
        for _ in 0..RECORDINGS {
            let noise = noise(&mut random, memory, input.len());
            let output: Vec<f64> = clean.iter().zip(noise).map(|(y, noise)| y + noise).collect();
            let known = fit(&input, &output, &options).expect("identified").uncertainty;
            for ((estimate, truth), count) in known.estimates.iter().zip(&truth).zip(&mut counts) {
                let Some([low, high]) = estimate.interval else { continue };
                if known.is_identifiable(estimate) {
                    count.cases += 1;
                    count.covered += usize::from((low..=high).contains(&truth.parameter.value));
                    count.reach += (high - low) / 2.0;
                }
            }
        }
        println!("noise of {SIGMA} mm, each value {memory} times the last one and something new:");
        let mut all = Count::default();
        for (truth, Count { cases, covered, reach }) in truth.iter().zip(&counts) {
            let Named { name, value, .. } = &truth.parameter;
            if *cases == 0 {
                println!("{name:>7} {value:9.4} is not identifiable");
                continue;
            }
            let reach = reach / *cases as f64;
            println!("{name:>7} {value:9.4} ± {reach:.4} covers in {covered:2} of {cases:2}");
            assert!(*covered as f64 >= 0.85 * *cases as f64, "{name}: {covered} of {cases}");
            all.cases += cases;
            all.covered += covered;
        }
        let share = all.covered as f64 / all.cases as f64;
        println!("    all: {:.1} % of {} cases", 100.0 * share, all.cases);
        // Intervals that always hold the truth would be too wide. At least half of the parameters
        // are identifiable.
        assert!((0.85..0.995).contains(&share) && all.cases > RECORDINGS * truth.len() / 2);
    }
}
