//! Gain margin, phase margin and largest sensitivity of a loop.
//!
//! The largest sensitivity Ms is how much more a disturbance at the worst frequency is felt than
//! without feedback: one over the least distance of the open loop from -1. It bounds both margins:
//! gain at least Ms/(Ms - 1), phase at least 2 asin(1/(2 Ms)) (Åström and Hägglund, Advanced PID
//! Control, 2006, section 4.6).

use std::f64::consts::{FRAC_1_SQRT_2, PI};

use num_complex::Complex;

use crate::response::{Feedback, Plants};

/// A loop reaches as far as it lessens disturbances to 1/√2 of what they would be: half of their
/// power.
const LESSENED: f64 = FRAC_1_SQRT_2;

/// The margins of one loop or the least of several.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Margins {
    /// Unit: 1.
    pub maximum_sensitivity: f64,
    /// By how much the gain may grow; infinite where no growth is too much. Unit: 1.
    pub gain: f64,
    /// By how much the phase may fall. Unit: degree.
    pub phase_deg: f64,
    /// Whether every loop is stable.
    pub is_stable: bool,
}

impl Margins {
    /// Those of a loop without feedback.
    pub const NONE: Self =
        Self { maximum_sensitivity: 1.0, gain: f64::INFINITY, phase_deg: 180.0, is_stable: true };

    fn worse(self, other: Self) -> Self {
        Self {
            maximum_sensitivity: self.maximum_sensitivity.max(other.maximum_sensitivity),
            gain: self.gain.min(other.gain),
            phase_deg: self.phase_deg.min(other.phase_deg),
            is_stable: self.is_stable && other.is_stable,
        }
    }
}

/// The least margins over all plants.
pub fn margins(plants: &Plants, feedback: &Feedback) -> Margins {
    let controller = responses(plants, feedback);
    plants.responses.iter().fold(Margins::NONE, |least, plant| {
        let open: Vec<Complex<f64>> = plant.iter().zip(&controller).map(|(p, c)| p * c).collect();
        least.worse(of_loop(&open))
    })
}

/// Whether every plant is stable with no larger sensitivity than this: stops at the first that is
/// not.
pub fn holds(plants: &Plants, feedback: &Feedback, largest: f64) -> bool {
    let controller = responses(plants, feedback);
    let least = 1.0 / largest;
    plants.responses.iter().all(|plant| {
        let back = || plant.iter().zip(&controller).map(|(p, c)| 1.0 + p * c);
        back().all(|value| value.norm() >= least) && is_stable(back())
    })
}

fn responses(plants: &Plants, feedback: &Feedback) -> Vec<Complex<f64>> {
    plants.omegas.iter().map(|&omega| feedback.response(omega)).collect()
}

/// Nyquist's criterion for a stable plant and a controller that integrates once at most: from the
/// lowest frequency to the highest, where nothing is left of the loop, 1 + L goes through the
/// negative real axis as often one way as the other, and so does not turn round 0.
fn is_stable(mut back: impl Iterator<Item = Complex<f64>>) -> bool {
    let Some(mut last) = back.next() else { return true };
    let mut turns = 0;
    for value in back {
        if last.im * value.im < 0.0 {
            let share = last.im / (last.im - value.im);
            if last.re + share * (value.re - last.re) < 0.0 {
                turns += if value.im > 0.0 { 1 } else { -1 };
            }
        }
        last = value;
    }
    turns == 0
}

/// The margins of an open loop, a value a frequency, the lowest first.
fn of_loop(open: &[Complex<f64>]) -> Margins {
    let distance = open.iter().map(|value| (1.0 + value).norm()).fold(f64::INFINITY, f64::min);
    let mut margins = Margins {
        maximum_sensitivity: (1.0 / distance).max(1.0),
        is_stable: is_stable(open.iter().map(|value| 1.0 + value)),
        ..Margins::NONE
    };
    for pair in open.windows(2) {
        let (from, to) = (pair[0], pair[1]);
        // Through the negative real axis.
        if from.im * to.im < 0.0 {
            let share = from.im / (from.im - to.im);
            let real = from.re + share * (to.re - from.re);
            if real < 0.0 {
                margins.gain = margins.gain.min(-1.0 / real);
            }
        }
        // Out of or into the unit circle.
        let (inside, outside) = (from.norm() - 1.0, to.norm() - 1.0);
        if inside * outside < 0.0 {
            let share = inside / (inside - outside);
            let crossing = from + (to - from) * share;
            let above = (PI + crossing.arg()).to_degrees();
            // Behind -180 degrees there is none left.
            let above = if above > 180.0 { above - 360.0 } else { above };
            margins.phase_deg = margins.phase_deg.min(above);
        }
    }
    margins
}

/// Up to where a feedback lessens disturbances, for each plant. Unit: Hz.
pub fn reach_hz(plants: &Plants, feedback: &Feedback) -> Vec<f64> {
    let controller = responses(plants, feedback);
    let of = |plant: &Vec<Complex<f64>>| {
        let lessens = |k: &usize| (1.0 + plant[*k] * controller[*k]).norm() >= 1.0 / LESSENED;
        let last = (0..plant.len()).take_while(lessens).last();
        last.map_or(0.0, |k| plants.omegas[k] / (2.0 * PI))
    };
    plants.responses.iter().map(of).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::response::frequencies;

    /// The open loop of an integrator of this rate (1/s) and a dead time (s).
    fn integrator(rate: f64, late_s: f64) -> Vec<Complex<f64>> {
        let at = |omega: &f64| {
            let s = Complex::new(0.0, *omega);
            rate / s * (-s * late_s).exp()
        };
        frequencies(1e-3).iter().map(at).collect()
    }

    #[test]
    fn an_integrator_with_a_dead_time_has_the_margins_of_the_textbook() {
        let found = of_loop(&integrator(10.0, 0.05));
        // Phase at crossover: 90 degrees less 10 rad/s for 0.05 s; gain until pi/2 = rate times
        // time.
        assert!((found.phase_deg - (90.0 - 0.5_f64.to_degrees())).abs() < 1.0, "{found:?}");
        assert!((found.gain - PI).abs() < 0.1, "{found:?}");
        assert!(found.maximum_sensitivity > 1.5 && found.maximum_sensitivity < 1.8, "{found:?}");
        assert!(found.is_stable);
    }

    #[test]
    fn beyond_its_gain_margin_a_loop_is_not_stable() {
        assert!(of_loop(&integrator(25.0, 0.05)).is_stable);
        // pi/2 over 0.05 s is 31.4: above it, and where the loop has gone round -1 twice.
        for rate in [34.0, 70.0, 200.0] {
            assert!(!of_loop(&integrator(rate, 0.05)).is_stable, "{rate}");
        }
    }
}
