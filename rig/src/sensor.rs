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

/// The sensors and the source of their noise.
#[derive(Debug, Clone)]
pub struct Sensors {
    noise: Option<Draw>,
}

impl Sensors {
    /// Sensors with noise: the same seed, the same noise.
    pub fn noisy(seed: u64) -> Self {
        Self { noise: Some(Draw::new(seed, Stream::Noise)) }
    }

    /// Sensors that tell the truth.
    pub fn ideal() -> Self {
        Self { noise: None }
    }

    /// Measures once.
    pub fn measure(&mut self, truth: Measurement) -> Measurement {
        let Some(noise) = &mut self.noise else { return truth };
        Measurement {
            pressure_bar: truth.pressure_bar + PRESSURE_NOISE_BAR * noise.normal(),
            contraction_mm: truth.contraction_mm + CONTRACTION_NOISE_MM * noise.normal(),
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
    fn seed_decides_the_noise_and_ideal_sensors_have_none() {
        assert_eq!(Sensors::noisy(1).measure(TRUTH), Sensors::noisy(1).measure(TRUTH));
        assert_ne!(Sensors::noisy(1).measure(TRUTH), Sensors::noisy(2).measure(TRUTH));
        assert_eq!(Sensors::ideal().measure(TRUTH), TRUTH);
    }
}
