//! Made-up signals for tests.

use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, StandardNormal};

/// Seeded noise.
pub struct Noise(ChaCha8Rng);

impl Noise {
    pub fn new(seed: u64) -> Self {
        Self(ChaCha8Rng::seed_from_u64(seed))
    }

    /// One normal number of this standard deviation.
    pub fn white(&mut self, deviation: f64) -> f64 {
        let unit: f64 = StandardNormal.sample(&mut self.0);
        deviation * unit
    }

    /// A stationary autoregression of first order, each value `like` times the one before and a
    /// part of its own.
    pub fn autoregressive(&mut self, rows: usize, like: f64) -> Vec<f64> {
        let own = (1.0 - like * like).sqrt();
        let mut value = self.white(1.0);
        let mut next = || {
            value = like * value + self.white(own);
            value
        };
        (0..rows).map(|_| next()).collect()
    }
}

/// Equally spaced times from 0 s on.
pub fn times(rows: usize, step_s: f64) -> Vec<f64> {
    (0..rows).map(|row| row as f64 * step_s).collect()
}

/// Triangles between 0 and 6 of this period (s).
pub fn triangles(time_s: f64, period_s: f64) -> f64 {
    6.0 * (1.0 - (2.0 * (time_s / period_s).fract() - 1.0).abs())
}

/// Up from 0 to 4, hold, down, hold, each in `part_s`.
pub fn held_triangles(time_s: f64, part_s: f64) -> f64 {
    let phase = (time_s / part_s) % 4.0;
    4.0 * match phase {
        p if p < 1.0 => p,
        p if p < 2.0 => 1.0,
        p if p < 3.0 => 3.0 - p,
        _ => 0.0,
    }
}
