//! The noise of the converter, shown by the conversions of one tick.
//!
//! Within the 73 µs of a tick's conversions what is measured hardly moves: what they differ by is
//! noise, whatever the muscle does. The supervisor adds it up, below the tick.

/// Of pressure and of contraction, each tick.
pub const CONVERSIONS: usize = 8;

/// The codes of one input in one tick.
pub type Conversions = [u16; CONVERSIONS];

/// Of how many ticks the mean is, about.
const TICKS: f32 = 256.0;

/// Mean square of one input.
#[derive(Clone, Copy, Debug, Default)]
pub struct Noise {
    /// Unit: code squared.
    variance: f32,
}

impl Noise {
    /// Takes the conversions of a tick.
    pub fn take(&mut self, codes: &Conversions) {
        let count = CONVERSIONS as f32;
        let mean = codes.iter().map(|&code| f32::from(code)).sum::<f32>() / count;
        let square = |code: &u16| (f32::from(*code) - mean) * (f32::from(*code) - mean);
        let variance = codes.iter().map(square).sum::<f32>() / (count - 1.0);
        self.variance += (variance - self.variance) / TICKS;
    }

    /// One standard deviation of a single conversion. Unit: code.
    pub fn codes(&self) -> f32 {
        libm::sqrtf(self.variance)
    }
}
