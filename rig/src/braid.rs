//! Pulling force of the inflated braid.
//!
//! Inextensible fibres wound at an angle turn radial pressure into a pull (Chou and Hannaford
//! 1996): `F = A p_eff (a (1 - k e)^2 - b)` with `a = 3/tan²`, `b = 1/sin²` of the fibre angle,
//! contraction ratio `e` and the end correction `k` of Tondu and Lopez (2000). The tube bears on
//! the fibres only beyond a threshold, and not everywhere at once, so the effective pressure is a
//! smooth hinge that is 0 at 0 bar.

use crate::parameters::{
    BORE_FORCE_N_PER_BAR, END_CORRECTION, FIBRE_ANGLE_DEG, THRESHOLD_PRESSURE_BAR, THRESHOLD_WIDTH_BAR,
};

/// The geometry of the braid, as the two coefficients of its force.
#[derive(Debug, Clone)]
pub(crate) struct Braid {
    a: f64,
    b: f64,
}

impl Braid {
    pub(crate) fn new() -> Self {
        let (sin, cos) = FIBRE_ANGLE_DEG.to_radians().sin_cos();
        Self { a: 3.0 * cos * cos / (sin * sin), b: 1.0 / (sin * sin) }
    }

    /// Pull in N, and its derivative by the contraction ratio in N.
    pub(crate) fn pull_n(&self, pressure_bar: f64, contraction_ratio: f64) -> (f64, f64) {
        let force_n = BORE_FORCE_N_PER_BAR * effective_pressure_bar(pressure_bar);
        let length_ratio = 1.0 - END_CORRECTION * contraction_ratio;
        (
            force_n * (self.a * length_ratio * length_ratio - self.b),
            force_n * -2.0 * END_CORRECTION * self.a * length_ratio,
        )
    }

    /// The contraction ratio at which no pressure pulls any more.
    pub(crate) fn neutral_ratio(&self) -> f64 {
        (1.0 - (self.b / self.a).sqrt()) / END_CORRECTION
    }
}

/// The part of the pressure that reaches the fibres, bar: 0 at 0 bar, parallel to the pressure far
/// above the threshold.
fn effective_pressure_bar(pressure_bar: f64) -> f64 {
    let hinge = |above_bar: f64| 0.5 * (above_bar + above_bar.hypot(THRESHOLD_WIDTH_BAR));
    hinge(pressure_bar - THRESHOLD_PRESSURE_BAR) - hinge(-THRESHOLD_PRESSURE_BAR)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn threshold_takes_its_pressure_from_the_pull() {
        assert_eq!(effective_pressure_bar(0.0), 0.0);
        assert!(effective_pressure_bar(0.5) < 0.15);
        let lost_bar = 6.0 - effective_pressure_bar(6.0);
        assert!((lost_bar - THRESHOLD_PRESSURE_BAR).abs() < 0.1, "{lost_bar} bar lost");
    }

    #[test]
    fn pull_at_six_bar_is_the_data_sheets_fifteen_hundred_newton_less_the_threshold() {
        let (pull_n, _) = Braid::new().pull_n(6.0, 0.0);
        let share = effective_pressure_bar(6.0) / 6.0;
        assert!((pull_n / share - 1500.0).abs() < 50.0, "{} N", pull_n / share);
    }

    #[test]
    fn slope_is_the_derivative_of_the_pull_and_the_pull_ends_at_the_neutral_ratio() {
        let braid = Braid::new();
        let h = 1e-6;
        for ratio in [-0.05, 0.0, 0.1, 0.25] {
            let numeric_n = (braid.pull_n(4.0, ratio + h).0 - braid.pull_n(4.0, ratio - h).0) / (2.0 * h);
            assert!((numeric_n - braid.pull_n(4.0, ratio).1).abs() < 1e-4);
        }
        assert!(braid.pull_n(4.0, braid.neutral_ratio()).0.abs() < 1e-9);
    }
}
