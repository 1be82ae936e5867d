//! Seeded randomness. Every user has a stream of its own, so that hiding one effect changes no
//! other draw.

use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::SeedableRng;
use rand_distr::{Distribution, StandardNormal, StandardUniform};

/// Who draws. Effects follow [`Stream::Parameters`] and [`Stream::Course`] by their number.
#[derive(Debug, Clone, Copy)]
pub(crate) enum Stream {
    /// Noise of the sensors.
    Noise,
    /// Waveform of the command.
    Protocol,
    /// Temperature of the room.
    Temperature,
    /// Which effects are hidden.
    Choice,
    /// Parameters of the operator plant.
    Operator,
    /// Constants of a joint.
    Joint,
    /// A part of a plant of the zoo.
    Part(u64),
    /// Parameters of an effect.
    Parameters(u64),
    /// Course of an effect over time.
    Course(u64),
}

impl Stream {
    fn number(self) -> u64 {
        match self {
            Self::Noise => 0,
            Self::Protocol => 1,
            Self::Temperature => 2,
            Self::Choice => 3,
            Self::Operator => 4,
            Self::Joint => 5,
            Self::Part(part) => 1024 + part,
            Self::Parameters(effect) => 16 + 2 * effect,
            Self::Course(effect) => 17 + 2 * effect,
        }
    }
}

/// A source of random numbers.
#[derive(Debug, Clone)]
pub(crate) struct Draw(ChaCha8Rng);

impl Draw {
    /// The source of `stream` under `seed`.
    pub(crate) fn new(seed: u64, stream: Stream) -> Self {
        let mut rng = ChaCha8Rng::seed_from_u64(seed);
        rng.set_stream(stream.number());
        Self(rng)
    }

    /// From `low` to `high`, all alike likely.
    pub(crate) fn uniform(&mut self, low: f64, high: f64) -> f64 {
        let unit: f64 = StandardUniform.sample(&mut self.0);
        low + (high - low) * unit
    }

    /// From `low` to `high`, both positive, all ratios alike likely.
    pub(crate) fn log_uniform(&mut self, low: f64, high: f64) -> f64 {
        self.uniform(low.ln(), high.ln()).exp()
    }

    /// Within a factor of 1.3 of a nominal value.
    pub(crate) fn around(&mut self, nominal: f64) -> f64 {
        nominal * self.log_uniform(1.0 / 1.3, 1.3)
    }

    /// 1 or -1.
    pub(crate) fn sign(&mut self) -> f64 {
        self.uniform(-1.0, 1.0).signum()
    }

    /// Mean 0, standard deviation 1.
    pub(crate) fn normal(&mut self) -> f64 {
        StandardNormal.sample(&mut self.0)
    }

    /// An index below `count`, which is not 0.
    pub(crate) fn index(&mut self, count: usize) -> usize {
        (self.uniform(0.0, count as f64) as usize).min(count - 1)
    }

    /// Brings `items` into a random order.
    pub(crate) fn shuffle<T>(&mut self, items: &mut [T]) {
        for last in (1..items.len()).rev() {
            items.swap(last, self.index(last + 1));
        }
    }
}
