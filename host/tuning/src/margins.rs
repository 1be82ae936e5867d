//! Gain margin, phase margin and largest sensitivity of a loop.
//!
//! The largest sensitivity is how much more a disturbance at the worst frequency is felt than
//! without feedback: one over the least distance of the open loop from -1. From 1.4 to 2 is usual;
//! at 2 the gain margin is at least 2/(2 - 1) = 2 and the phase margin at least 2 asin(1/4) = 29
//! degrees (Åström and Hägglund, Advanced PID Control, section 4.5).

use std::f64::consts::PI;

use num_complex::Complex;

use crate::response::{Corner, Dynamics, Feedback};

/// How many frequencies are looked at.
const FREQUENCIES: usize = 72;
/// The lowest of them. Unit: rad/s.
const LOWEST: f64 = 0.02;
/// A loop reaches as far as it lessens disturbances to this share of what they would be.
const LESSENED: f64 = std::f64::consts::FRAC_1_SQRT_2;

/// The margins of one loop or the least of several.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Margins {
    /// Unit: 1.
    pub maximum_sensitivity: f64,
    /// By how much the gain may grow; infinite where no growth is too much. Unit: 1.
    pub gain: f64,
    /// By how much the phase may fall. Unit: degree.
    pub phase_deg: f64,
}

impl Margins {
    /// Those of a loop without feedback.
    pub const NONE: Self = Self { maximum_sensitivity: 1.0, gain: f64::INFINITY, phase_deg: 180.0 };

    fn worse(self, other: Self) -> Self {
        Self {
            maximum_sensitivity: self.maximum_sensitivity.max(other.maximum_sensitivity),
            gain: self.gain.min(other.gain),
            phase_deg: self.phase_deg.min(other.phase_deg),
        }
    }

    /// Whether the loop is stable: the gain has to grow before it is not. (Muscle, valve and
    /// observer are stable or integrate once, so the loop is so at small gains.)
    pub fn is_stable(&self) -> bool {
        self.gain > 1.0 && self.phase_deg > 0.0
    }
}

/// The frequencies that margins are looked at, up to half the rate of ticks. Unit: rad/s.
pub fn frequencies(period_s: f64) -> Vec<f64> {
    let highest = PI / period_s;
    let ratio = (highest / LOWEST).powf(1.0 / (FREQUENCIES - 1) as f64);
    (0..FREQUENCIES).map(|k| LOWEST * ratio.powi(k as i32)).collect()
}

/// The least margins over all corners.
pub fn margins(dynamics: &Dynamics, corners: &[Corner], feedback: &Feedback) -> Margins {
    let frequencies = frequencies(dynamics.period_s);
    corners.iter().fold(Margins::NONE, |least, corner| {
        let open: Vec<Complex<f64>> =
            frequencies.iter().map(|&omega| dynamics.open_loop(corner, feedback, omega)).collect();
        least.worse(of_loop(&open))
    })
}

/// Whether no corner has a larger sensitivity than this: stops at the first that has.
pub fn holds(dynamics: &Dynamics, corners: &[Corner], feedback: &Feedback, largest: f64) -> bool {
    let frequencies = frequencies(dynamics.period_s);
    let least = 1.0 / largest;
    corners.iter().all(|corner| {
        frequencies.iter().all(|&omega| (1.0 + dynamics.open_loop(corner, feedback, omega)).norm() >= least)
    })
}

/// The margins of an open loop, a value a frequency, the lowest first.
fn of_loop(open: &[Complex<f64>]) -> Margins {
    let distance = open.iter().map(|value| (1.0 + value).norm()).fold(f64::INFINITY, f64::min);
    let mut margins = Margins { maximum_sensitivity: (1.0 / distance).max(1.0), ..Margins::NONE };
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

/// Up to where a loop lessens disturbances. Unit: Hz.
pub fn reach_hz(dynamics: &Dynamics, corner: &Corner, feedback: &Feedback) -> f64 {
    let frequencies = frequencies(dynamics.period_s);
    let lessens =
        |omega: &&f64| (1.0 + dynamics.open_loop(corner, feedback, **omega)).norm() >= 1.0 / LESSENED;
    frequencies.iter().take_while(lessens).last().map_or(0.0, |omega| omega / (2.0 * PI))
}

#[cfg(test)]
mod tests {
    use super::*;

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
        assert!(found.is_stable());
    }

    #[test]
    fn beyond_its_gain_margin_a_loop_is_not_stable() {
        assert!(!of_loop(&integrator(40.0, 0.05)).is_stable());
        assert!(of_loop(&integrator(25.0, 0.05)).is_stable());
    }
}
