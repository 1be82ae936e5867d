//! The sensors: seeded white Gaussian noise on pressure and contraction, or none.

use crate::draw::{Draw, Stream};
use crate::parameters::{CONTRACTION_NOISE_MM, PRESSURE_NOISE_BAR};

/// What the sensors say at one instant.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Measurement {
    /// Pressure in the muscle, bar.
    pub pressure_bar: f64,
    /// Contraction of the muscle, mm.
    pub contraction_mm: f64,
    /// Load as far as it is recorded, N.
    pub load_n: f64,
    /// Temperature, °C.
    pub temperature_c: f64,
}

/// Which of a measurement's fields are handed on.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Columns {
    /// Pressure and contraction.
    Muscle,
    /// Load and temperature too.
    All,
}

/// Noise and steps of a sensor, in its unit.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Resolution {
    /// Standard deviation of the noise.
    pub noise: f64,
    /// What its readings are multiples of; 0 where they are not.
    pub step: f64,
}

impl Resolution {
    /// Standard deviation of what a reading is off by.
    pub fn deviation(&self) -> f64 {
        self.noise.hypot(self.step / 12.0f64.sqrt())
    }

    fn read(&self, truth: f64, noise: f64) -> f64 {
        let value = truth + self.noise * noise;
        if self.step > 0.0 { (value / self.step).round() * self.step } else { value }
    }
}

/// The sensors and the source of their noise.
#[derive(Debug, Clone)]
pub struct Sensors {
    noise: Option<Draw>,
    pressure: Resolution,
    contraction: Resolution,
}

impl Sensors {
    /// Sensors with noise: the same seed, the same noise.
    pub fn noisy(seed: u64) -> Self {
        let of = |noise| Resolution { noise, step: 0.0 };
        Self::with(of(PRESSURE_NOISE_BAR), of(CONTRACTION_NOISE_MM), seed)
    }

    /// Sensors of the stated noise and steps, bar and mm.
    pub fn with(pressure: Resolution, contraction: Resolution, seed: u64) -> Self {
        Self { noise: Some(Draw::new(seed, Stream::Noise)), pressure, contraction }
    }

    /// Sensors that tell the truth.
    pub fn ideal() -> Self {
        let exact = Resolution { noise: 0.0, step: 0.0 };
        Self { noise: None, pressure: exact, contraction: exact }
    }

    /// Measures once.
    pub fn measure(&mut self, truth: Measurement) -> Measurement {
        let Some(noise) = &mut self.noise else { return truth };
        Measurement {
            pressure_bar: self.pressure.read(truth.pressure_bar, noise.normal()),
            contraction_mm: self.contraction.read(truth.contraction_mm, noise.normal()),
            ..truth
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const TRUTH: Measurement =
        Measurement { pressure_bar: 3.0, contraction_mm: 90.0, load_n: 2.0, temperature_c: 20.0 };

    #[test]
    fn noise_is_unbiased_and_as_large_as_stated() {
        const COUNT: usize = 20_000;
        let mut sensors = Sensors::noisy(5);
        let noise: Vec<_> = (0..COUNT)
            .map(|_| sensors.measure(TRUTH))
            .map(|m| {
                (
                    (m.pressure_bar - TRUTH.pressure_bar) / PRESSURE_NOISE_BAR,
                    (m.contraction_mm - TRUTH.contraction_mm) / CONTRACTION_NOISE_MM,
                )
            })
            .collect();
        let mean = |of: &dyn Fn(&(f64, f64)) -> f64| noise.iter().map(of).sum::<f64>() / COUNT as f64;
        for figure in [mean(&|n| n.0), mean(&|n| n.1), mean(&|n| n.0 * n.1)] {
            assert!(figure.abs() < 0.03, "{figure} standard deviations");
        }
        for figure in [mean(&|n| n.0 * n.0), mean(&|n| n.1 * n.1)] {
            assert!((figure - 1.0).abs() < 0.05, "variance {figure} times the stated one");
        }
    }

    #[test]
    fn quantised_readings_are_multiples_of_the_step() {
        let (coarse, exact) = (Resolution { noise: 0.03, step: 0.125 }, Resolution { noise: 0.0, step: 0.0 });
        let mut sensors = Sensors::with(exact, coarse, 1);
        for _ in 0..100 {
            let steps = sensors.measure(TRUTH).contraction_mm / 0.125;
            assert!((steps - steps.round()).abs() < 1e-9);
        }
        assert!((coarse.deviation() - 0.0469).abs() < 1e-4);
    }

    #[test]
    fn seed_decides_the_noise_and_ideal_sensors_have_none() {
        assert_eq!(Sensors::noisy(1).measure(TRUTH), Sensors::noisy(1).measure(TRUTH));
        assert_ne!(Sensors::noisy(1).measure(TRUTH), Sensors::noisy(2).measure(TRUTH));
        assert_eq!(Sensors::ideal().measure(TRUTH), TRUTH);
    }
}
