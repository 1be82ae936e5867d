//! The muscle: a balance of forces, solved for the contraction at every step.
//!
//! ```text
//! braid(p, e) - skin stiffness * e - sum of bristles(e, limit(p)) - load = 0,    e = contraction / nominal length
//! ```
//!
//! Every term falls with the contraction, the skin strictly, so there is exactly one root; Newton's method
//! finds it inside a bracket that bisection keeps shrinking. Then the bristles settle at the root. Hysteresis
//! comes from the bristles alone. The core is rate-independent: it knows the order of the pressures, not
//! their times.
//!
//! What it is not: a Prandtl-Ishlinskii model. The friction's limits grow with pressure and the geometry is
//! nonlinear, so loops between the same pressures are not congruent (heights differ by some 3 %), and an
//! inner loop closes only to about 0.2 mm: as the pressure falls so do the limits, and bristles slip that
//! have hardly moved. A wider loop does wipe out what was inside it, to less than 1 µm.
//!
//! Limits: 0 to 6 bar, load 0 to [`LOAD_LIMIT_N`](crate::parameters::LOAD_LIMIT_N). A pressure path taken in
//! steps of 0.1 bar and one taken in far finer steps differ by less than 5 µm.

use crate::braid::Braid;
use crate::bristle::Bristle;
use crate::parameters::{
    BREAKAWAY_MM, BREAKAWAY_PRESSURE_BAR, FRICTION_N, FRICTION_N_PER_BAR, NOMINAL_LENGTH_MM, SKIN_STIFFNESS_N,
};

/// Bisection alone takes 43 steps from the widest bracket to the tolerance, Newton's method 3 to 6.
const ITERATION_LIMIT: usize = 100;

/// Smallest step in contraction ratio worth taking: 5e-11 mm.
const TOLERANCE_RATIO: f64 = 1e-13;

/// A muscle with its memory.
#[derive(Debug, Clone)]
pub struct Muscle {
    braid: Braid,
    bristles: [Bristle; BREAKAWAY_MM.len()],
    contraction_ratio: f64,
}

impl Muscle {
    /// A muscle that has hung at 0 bar under `load_n` until its bristles have relaxed.
    pub fn at_rest(load_n: f64) -> Self {
        let contraction_ratio = -load_n / SKIN_STIFFNESS_N;
        let bristles = BREAKAWAY_MM.map(|breakaway_mm| {
            let breakaway_ratio = breakaway_mm / NOMINAL_LENGTH_MM;
            Bristle::relaxed(bristle_limit_n(BREAKAWAY_PRESSURE_BAR) / breakaway_ratio, contraction_ratio)
        });
        Self { braid: Braid::new(), bristles, contraction_ratio }
    }

    /// The contraction, mm: positive when the muscle is shorter than its nominal length.
    pub fn contraction_mm(&self) -> f64 {
        self.contraction_ratio * NOMINAL_LENGTH_MM
    }

    /// Moves to the equilibrium at `pressure_bar` (0 bar and more) under `load_n` (0 N and more), however
    /// long that takes.
    pub fn step(&mut self, pressure_bar: f64, load_n: f64) {
        self.contraction_ratio = self.equilibrium_ratio(pressure_bar, load_n);
        let limit_n = bristle_limit_n(pressure_bar);
        for bristle in &mut self.bristles {
            bristle.settle(self.contraction_ratio, limit_n);
        }
    }

    /// What pulls minus what resists at `contraction_ratio`, N, and its slope, N: always negative.
    fn surplus_n(&self, contraction_ratio: f64, pressure_bar: f64, load_n: f64) -> (f64, f64) {
        let (pull_n, pull_slope_n) = self.braid.pull_n(pressure_bar, contraction_ratio);
        let elastic =
            (pull_n - SKIN_STIFFNESS_N * contraction_ratio - load_n, pull_slope_n - SKIN_STIFFNESS_N);
        let limit_n = bristle_limit_n(pressure_bar);
        self.bristles.iter().fold(elastic, |(force_n, slope_n), bristle| {
            let (resistance_n, stiffness_n) = bristle.resistance_n(contraction_ratio, limit_n);
            (force_n - resistance_n, slope_n - stiffness_n)
        })
    }

    /// The root of [`surplus_n`](Self::surplus_n).
    fn equilibrium_ratio(&self, pressure_bar: f64, load_n: f64) -> f64 {
        // Below, the skin alone outweighs load and friction; above, the braid no longer pulls and the skin
        // outweighs friction.
        let friction_n = friction_n(pressure_bar);
        let mut below = -(load_n + friction_n) / SKIN_STIFFNESS_N;
        let mut above = self.braid.neutral_ratio().max(friction_n / SKIN_STIFFNESS_N);
        let mut ratio = self.contraction_ratio.clamp(below, above);
        let mut last_step = above - below;
        for _ in 0..ITERATION_LIMIT {
            let (surplus_n, slope_n) = self.surplus_n(ratio, pressure_bar, load_n);
            if surplus_n > 0.0 {
                below = ratio;
            } else {
                above = ratio;
            }
            let newton = ratio - surplus_n / slope_n;
            // Bisect where Newton leaves the bracket, or hops between two bristles' kinks without converging.
            let converges = (newton - ratio).abs() <= 0.5 * last_step.abs();
            let next =
                if converges && below <= newton && newton <= above { newton } else { 0.5 * (below + above) };
            last_step = next - ratio;
            ratio = next;
            if last_step.abs() <= TOLERANCE_RATIO {
                break;
            }
        }
        ratio
    }
}

/// Friction of all bristles together where they slip, N.
fn friction_n(pressure_bar: f64) -> f64 {
    FRICTION_N + FRICTION_N_PER_BAR * pressure_bar
}

/// The largest force of one bristle, N: an equal share of the friction.
fn bristle_limit_n(pressure_bar: f64) -> f64 {
    friction_n(pressure_bar) / BREAKAWAY_MM.len() as f64
}

#[cfg(test)]
mod tests {
    use rand_chacha::ChaCha8Rng;
    use rand_chacha::rand_core::SeedableRng;
    use rand_distr::{Distribution, Uniform};

    use super::*;
    use crate::parameters::{LOAD_LIMIT_N, VALVE_RANGE_BAR};

    #[test]
    fn forces_balance_after_every_step_of_random_histories() {
        let mut rng = ChaCha8Rng::seed_from_u64(3);
        let pressures = Uniform::new_inclusive(0.0, VALVE_RANGE_BAR).unwrap();
        let loads = Uniform::new_inclusive(0.0, LOAD_LIMIT_N).unwrap();
        for _ in 0..50 {
            let mut muscle = Muscle::at_rest(loads.sample(&mut rng));
            for _ in 0..200 {
                let (pressure_bar, load_n) = (pressures.sample(&mut rng), loads.sample(&mut rng));
                muscle.step(pressure_bar, load_n);
                let (surplus_n, slope_n) = muscle.surplus_n(muscle.contraction_ratio, pressure_bar, load_n);
                assert!(surplus_n.abs() < 1e-8, "{surplus_n} N at {pressure_bar} bar under {load_n} N");
                assert!(slope_n < 0.0);
            }
        }
    }
}
