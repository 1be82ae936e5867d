//! Where the searches begin: a Halton sequence over the plausible part of the coordinates, shifted at
//! random by the seed (Cranley and Patterson), so that any number of starts covers it evenly.

use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

use super::Options;
use super::coordinates::COUNT;

/// The first primes: the bases of the sequence.
const BASES: [u32; COUNT] = [2, 3, 5, 7, 11];

/// The starting coordinates.
pub fn starts(options: &Options) -> Vec<[f64; COUNT]> {
    let mut random = ChaCha8Rng::seed_from_u64(options.seed);
    let shift: [f64; COUNT] = std::array::from_fn(|_| random.random());
    (1..=options.starts).map(|i| start(options.plays as f64, i as u32, &shift)).collect()
}

fn start(plays: f64, index: u32, shift: &[f64; COUNT]) -> [f64; COUNT] {
    // Lower and upper end of: ln a, b, ln of the largest threshold, ln of the total decay, logit s.
    let ranges = [
        (0.4_f64.ln(), 4_f64.ln()),
        (-2.0, 1.0),
        (0.15_f64.ln(), 1.2_f64.ln()),
        (0.5_f64.ln(), 8_f64.ln()),
        (-3.0, 1.5),
    ];
    let mut coordinates = std::array::from_fn(|c| {
        let share = (radical_inverse(index, BASES[c]) + shift[c]).fract();
        ranges[c].0 + share * (ranges[c].1 - ranges[c].0)
    });
    // From the whole bank to a single step of it.
    coordinates[2] -= plays.ln();
    coordinates[3] -= plays.ln();
    coordinates
}

/// The digits of `index` in `base`, mirrored at the point.
fn radical_inverse(mut index: u32, base: u32) -> f64 {
    let (mut value, mut place) = (0.0, 1.0 / f64::from(base));
    while index > 0 {
        value += f64::from(index % base) * place;
        index /= base;
        place /= f64::from(base);
    }
    value
}
