//! Where the searches begin: a Halton sequence over the plausible part of the coordinates, shifted
//! at random by the seed (Cranley and Patterson), so that any number of starts covers it evenly.

use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

use super::coordinates::Coordinate;
use super::data::Data;
use super::inner::Inner;

/// Where a search begins.
#[derive(Clone, Debug)]
pub struct Start {
    /// The coordinates.
    pub coordinates: Vec<f64>,
    /// Whether the muscle has been through its whole range before the recording.
    pub preconditioned: bool,
}

impl Start {
    /// The same point for the other kind of muscle.
    pub fn of_other_kind(&self) -> Self {
        Self { preconditioned: !self.preconditioned, ..self.clone() }
    }

    /// The same point of a model with exponential weights among those with free ones.
    pub fn freed(&self, data: &Data) -> Self {
        let mut coordinates = self.coordinates[..data.structure.shape.coordinates().len()].to_vec();
        let inner = Inner::new(&data.structure, &self.coordinates, data.span);
        coordinates.extend(inner.plays.free_coordinates());
        Self { coordinates, ..*self }
    }
}

/// The starts at `count` points, for a preconditioned muscle: which kind it is, a search tells when
/// it has come nearer.
pub fn starts(coordinates: &[Coordinate], count: usize, seed: u64) -> Vec<Start> {
    let mut random = ChaCha8Rng::seed_from_u64(seed);
    let shifts: Vec<f64> = coordinates.iter().map(|_| random.random()).collect();
    let bases: Vec<u32> = primes().take(coordinates.len()).collect();
    let start = |point: usize| {
        let one = |((coordinate, shift), base): ((&Coordinate, &f64), &u32)| {
            let (low, high) = coordinate.starts;
            low + (radical_inverse(point, *base) + shift).fract() * (high - low)
        };
        let coordinates = coordinates.iter().zip(&shifts).zip(&bases).map(one).collect();
        Start { coordinates, preconditioned: true }
    };
    (1..=count).map(start).collect()
}

/// The primes: the bases of the sequence.
fn primes() -> impl Iterator<Item = u32> {
    (2..).filter(|&n| (2..n).take_while(|k| k * k <= n).all(|k| n % k != 0))
}

/// The digits of `index` in `base`, mirrored at the point.
fn radical_inverse(mut index: usize, base: u32) -> f64 {
    let (mut value, mut place) = (0.0, 1.0 / f64::from(base));
    while index > 0 {
        value += (index % base as usize) as f64 * place;
        index /= base as usize;
        place /= f64::from(base);
    }
    value
}
