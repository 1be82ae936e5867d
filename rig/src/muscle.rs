//! The muscle: a balance of forces, solved for the contraction at every step.
//!
//! ```text
//! braid(p, e) - skin stiffness * e - sum of bristles(e, limit(p)) - load = 0,    e = contraction / nominal length
//! ```
//!
//! Every term falls with the contraction, the skin strictly, so there is exactly one root; Newton's
//! method finds it inside a bracket that bisection keeps shrinking. Then the bristles settle at the
//! root. Hysteresis comes from the bristles alone. The core is rate-independent: it knows the order
//! of the pressures, not their times. A mass and a viscous force ([`Dynamics`]) stand on the
//! right-hand side where there are any, and sliding may strengthen the friction. Time is then
//! stepped by Newmark's average acceleration, which neither damps nor grows, and the rest of the
//! balance stays as it is: the terms that are added fall with the contraction too.
//!
//! What it is not: a Prandtl-Ishlinskii model. The friction's limits grow with pressure and the
//! geometry is nonlinear, so loops between the same pressures are not congruent (heights differ by
//! some 3 %), and an inner loop closes only to about 0.2 mm: as the pressure falls so do the
//! limits, and bristles slip that have hardly moved. A wider loop does wipe out what was inside it,
//! to less than 1 µm.
//!
//! Limits: 0 to 6 bar, load 0 to [`LOAD_LIMIT_N`](crate::parameters::LOAD_LIMIT_N). A pressure path
//! taken in steps of 0.1 bar and one taken in far finer steps differ by less than 5 µm; with
//! dynamics steps of 1 ms.

use crate::braid::Braid;
use crate::bristle::Bristle;
use crate::dynamics::{Dynamics, Motion, Step};
use crate::parameters::{
    BREAKAWAY_MM, BREAKAWAY_PRESSURE_BAR, FRICTION_N, FRICTION_N_PER_BAR, NOMINAL_LENGTH_MM, SKIN_STIFFNESS_N,
};

/// Bisection alone takes 43 steps from the widest bracket to the tolerance, Newton's method 3 to 6.
const ITERATION_LIMIT: usize = 100;

/// Smallest step in contraction ratio worth taking: 5e-11 mm.
const TOLERANCE_RATIO: f64 = 1e-13;

/// What acts on a muscle at one instant, and the state its parts are in.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Condition {
    /// Pressure, 0 bar and more.
    pub pressure_bar: f64,
    /// Load, 0 N and more.
    pub load_n: f64,
    /// Factor on the skin's stiffness, positive.
    pub skin: f64,
    /// Factor on the friction, 0 and more.
    pub friction: f64,
}

impl Condition {
    /// A sound muscle.
    pub fn sound(pressure_bar: f64, load_n: f64) -> Self {
        Self { pressure_bar, load_n, skin: 1.0, friction: 1.0 }
    }

    fn skin_stiffness_n(&self) -> f64 {
        self.skin * SKIN_STIFFNESS_N
    }

    /// Friction of all bristles together where they slip slowly, N.
    fn friction_n(&self) -> f64 {
        self.friction * (FRICTION_N + FRICTION_N_PER_BAR * self.pressure_bar)
    }

    /// The largest force of one bristle, N: an equal share of the friction.
    fn bristle_limit_n(&self) -> f64 {
        self.friction_n() / BREAKAWAY_MM.len() as f64
    }
}

/// A muscle with its memory.
#[derive(Debug, Clone)]
pub struct Muscle {
    braid: Braid,
    bristles: [Bristle; BREAKAWAY_MM.len()],
    dynamics: Dynamics,
    motion: Motion,
}

impl Muscle {
    /// A muscle that has hung at 0 bar under `load_n` until its bristles have relaxed.
    pub fn at_rest(load_n: f64) -> Self {
        Self::with_dynamics(load_n, Dynamics::default())
    }

    /// The same with forces that depend on motion.
    pub fn with_dynamics(load_n: f64, dynamics: Dynamics) -> Self {
        let contraction_ratio = -load_n / SKIN_STIFFNESS_N;
        let stick_n = Condition::sound(BREAKAWAY_PRESSURE_BAR, load_n).bristle_limit_n();
        let bristles = BREAKAWAY_MM.map(|breakaway_mm| {
            Bristle::relaxed(stick_n / (breakaway_mm / NOMINAL_LENGTH_MM), contraction_ratio)
        });
        Self { braid: Braid::new(), bristles, dynamics, motion: Motion::resting(contraction_ratio) }
    }

    /// The contraction, mm: positive when the muscle is shorter than its nominal length.
    pub fn contraction_mm(&self) -> f64 {
        self.motion.ratio * NOMINAL_LENGTH_MM
    }

    /// Moves a sound muscle to the equilibrium at `pressure_bar` (0 bar and more) under `load_n` (0
    /// N and more), however long that takes.
    pub fn step(&mut self, pressure_bar: f64, load_n: f64) {
        self.advance(&Condition::sound(pressure_bar, load_n), f64::INFINITY);
    }

    /// Lets `dt_s` (above 0 s) pass under `condition`.
    pub fn advance(&mut self, condition: &Condition, dt_s: f64) {
        let step = self.dynamics.step(&self.motion, dt_s);
        let ratio = self.balance_ratio(condition, &step);
        let limits_n = step.limits_n(condition.bristle_limit_n(), ratio);
        for bristle in &mut self.bristles {
            bristle.settle(ratio, &limits_n);
        }
        self.motion = step.arrive(ratio);
    }

    /// What a muscle without load or motion pulls with where something else holds it at `ratio`, N,
    /// and the slope, N.
    pub(crate) fn pull_n(&self, ratio: f64, condition: &Condition) -> (f64, f64) {
        self.surplus_n(ratio, condition, &self.dynamics.step(&self.motion, f64::INFINITY))
    }

    /// Holds it there.
    pub(crate) fn hold(&mut self, ratio: f64, condition: &Condition) {
        let still = self.dynamics.step(&self.motion, f64::INFINITY);
        let limits_n = still.limits_n(condition.bristle_limit_n(), ratio);
        for bristle in &mut self.bristles {
            bristle.settle(ratio, &limits_n);
        }
        self.motion = Motion::resting(ratio);
    }

    /// What pulls minus what resists at `ratio`, N, and its slope, N: always negative.
    fn surplus_n(&self, ratio: f64, condition: &Condition, step: &Step) -> (f64, f64) {
        let (pull_n, pull_slope_n) = self.braid.pull_n(condition.pressure_bar, ratio);
        let skin_n = condition.skin_stiffness_n();
        let smooth = (
            pull_n - skin_n * ratio - condition.load_n - step.stiffness_n * (ratio - step.free_ratio),
            pull_slope_n - skin_n - step.stiffness_n,
        );
        let limits_n = step.limits_n(condition.bristle_limit_n(), ratio);
        self.bristles.iter().fold(smooth, |(force_n, slope_n), bristle| {
            let (resistance_n, stiffness_n) = bristle.resistance_n(ratio, &limits_n);
            (force_n - resistance_n, slope_n - stiffness_n)
        })
    }

    /// The root of [`surplus_n`](Self::surplus_n).
    fn balance_ratio(&self, condition: &Condition, step: &Step) -> f64 {
        // Below, the skin alone outweighs load and friction; above, the braid no longer pulls and
        // the skin outweighs friction. On the far side of where the step begins friction does not
        // grow with speed, on the far side of the free flight the mass helps.
        let (start, friction_n) = (step.start_ratio(), condition.friction_n());
        let lowest = -(condition.load_n + friction_n) / condition.skin_stiffness_n();
        let highest = self.braid.neutral_ratio().max(friction_n / condition.skin_stiffness_n());
        let mut below = lowest.min(start).min(step.free_ratio);
        let mut above = highest.max(start).max(step.free_ratio);
        let mut ratio = start;
        let mut last_step = above - below;
        for _ in 0..ITERATION_LIMIT {
            let (surplus_n, slope_n) = self.surplus_n(ratio, condition, step);
            if surplus_n > 0.0 {
                below = ratio;
            } else {
                above = ratio;
            }
            let newton = ratio - surplus_n / slope_n;
            // Bisect where Newton leaves the bracket, or hops between two bristles' kinks without
            // converging.
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
                let still = muscle.dynamics.step(&muscle.motion, f64::INFINITY);
                muscle.step(pressure_bar, load_n);
                let condition = Condition::sound(pressure_bar, load_n);
                let (surplus_n, slope_n) = muscle.surplus_n(muscle.motion.ratio, &condition, &still);
                assert!(surplus_n.abs() < 1e-8, "{surplus_n} N at {pressure_bar} bar under {load_n} N");
                assert!(slope_n < 0.0);
            }
        }
    }
}
