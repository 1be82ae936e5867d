//! A joint as a plant: two muscles that pull at one pulley from both sides, each behind a valve.
//!
//! ```text
//! inertia φ'' = R (F_a - F_b) - damping φ' - bearing + load
//! contraction a = mounted a + R φ,  contraction b = mounted b - R φ
//! ```
//!
//! Each muscle is the rig's ([`crate::muscle`]) with a size of its own: strength, skin, friction,
//! length and where it is mounted are drawn by the seed, and so are pulley, inertia, damping,
//! bearing and valves. A tendon does not push: a slack muscle has no force, and its friction stays
//! as it is.

pub mod command;
pub mod protocol;
pub mod recording;
pub mod side;

use std::f64::consts::PI;

use crate::bristle::Bristle;
use crate::draw::{Draw, Stream};
use crate::dynamics::{Dynamics, Limits, Motion};
use crate::parameters::PRESSURE_NOISE_BAR;
use crate::plant::SUBSTEP_S;
use side::Side;

/// Radius of the pulley, mm. Assumed: a quarter of the muscles' stroke turns it by 40 degrees.
pub const RADIUS_MM: f64 = 40.0;

/// Inertia of the joint and what moves with it, kg m². Assumed: a forearm of 0.3 kg and 0.4 m.
pub const INERTIA_KG_M2: f64 = 0.02;

/// Torque against the speed, N m s/rad. Assumed: a damping ratio of 0.2 where the joint is stiff.
pub const DAMPING_NM_S: f64 = 0.5;

/// Dry friction of the bearing, N m. Assumed: 1 % of what a muscle turns with at mid-range.
pub const BEARING_NM: f64 = 0.1;

/// Angle that the bearing gives by before it slips, rad. Assumed.
const BEARING_RAD: f64 = 0.004;

/// Standard deviation of the angle measurement, degrees. Assumed: the noise of a magnetic encoder
/// of 14 bits.
pub const ANGLE_NOISE_DEG: f64 = 0.02;

/// Widest that constants of a joint are drawn: a factor.
const SPREAD: f64 = 1.15;

/// Farthest from 0 that the joint turns before it is at its stop, rad.
const STOP_RAD: f64 = 1.2;

/// The angle has been found where it moves by less than this, rad.
const TOLERANCE_RAD: f64 = 1e-12;

/// Bisection alone takes 41 steps from the widest bracket to the tolerance.
const ITERATION_LIMIT: usize = 100;

/// What the sensors of a joint say.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct JointMeasurement {
    /// Pressure in either muscle, bar.
    pub pressures_bar: [f64; 2],
    /// Angle, degrees.
    pub angle_deg: f64,
}

/// A joint with its valves and sensors.
#[derive(Debug, Clone)]
pub struct JointPlant {
    sides: [Side; 2],
    radius_mm: f64,
    dynamics: Dynamics,
    /// Of the angle, rad.
    motion: Motion,
    bearing: Bristle,
    bearing_nm: f64,
    load_nm: f64,
    noise: Option<Draw>,
}

impl JointPlant {
    /// The joint of a seed, vented and at rest.
    pub fn new(seed: u64, noise: bool) -> Self {
        let mut draw = Draw::new(seed, Stream::Joint);
        let mut around = |nominal: f64| nominal * draw.log_uniform(1.0 / SPREAD, SPREAD);
        let dynamics = Dynamics {
            mass_n_s2: around(INERTIA_KG_M2),
            viscosity_n_s: around(DAMPING_NM_S),
            ..Dynamics::default()
        };
        let bearing_nm = around(BEARING_NM);
        Self {
            sides: [(); 2].map(|()| Side::drawn(&mut around)),
            radius_mm: around(RADIUS_MM),
            dynamics,
            motion: Motion::resting(0.0),
            bearing: Bristle::relaxed(bearing_nm / BEARING_RAD, 0.0),
            bearing_nm,
            load_nm: 0.0,
            noise: noise.then(|| Draw::new(seed, Stream::Noise)),
        }
    }

    /// Puts a torque (N m) on the joint from now on, towards larger angles.
    pub fn put_on(&mut self, load_nm: f64) {
        self.load_nm = load_nm;
    }

    /// Holds the commands (bar) for `dt_s` (0 s and more), then measures.
    pub fn step(&mut self, commands_bar: [f64; 2], dt_s: f64) -> JointMeasurement {
        let steps = (dt_s / SUBSTEP_S).ceil().max(1.0);
        if dt_s > 0.0 {
            for _ in 0..steps as u64 {
                self.advance(commands_bar, dt_s / steps);
            }
        }
        self.measure()
    }

    /// The angle as an exact sensor would read it, degrees.
    pub fn exact_deg(&self) -> f64 {
        self.motion.ratio * 180.0 / PI
    }

    /// What either tendon is pulled with now, N; 0 where it is slack.
    pub fn tensions_n(&self) -> [f64; 2] {
        let angle = self.motion.ratio;
        [0, 1].map(|place| self.pull_n(place, angle).0)
    }

    /// The torque against a slow swing by `swing_rad` to either side, for each radian, N m/rad, the
    /// pressures held: what a second swing finds, as the first has brought the friction to.
    pub fn stiffness_nm_per_rad(&self, swing_rad: f64) -> f64 {
        let mut held = self.clone();
        let middle = self.motion.ratio;
        let mut at_end_nm = |end: f64| {
            held.settle(middle + end);
            held.torque_nm(middle + end).0
        };
        at_end_nm(swing_rad);
        at_end_nm(-swing_rad);
        (at_end_nm(-swing_rad) - at_end_nm(swing_rad)) / (2.0 * swing_rad)
    }

    /// The contraction of a muscle at an angle (rad), mm.
    fn contraction_mm(&self, place: usize, angle: f64) -> f64 {
        let direction = if place == 0 { 1.0 } else { -1.0 };
        self.sides[place].mounted_mm + direction * self.radius_mm * angle
    }

    /// The tension of a tendon at an angle (rad), N, and its slope by the contraction, N/mm.
    fn pull_n(&self, place: usize, angle: f64) -> (f64, f64) {
        let (pull_n, slope) = self.sides[place].pull_n(self.contraction_mm(place, angle));
        if pull_n > 0.0 { (pull_n, slope) } else { (0.0, 0.0) }
    }

    /// The torque of muscles and bearing at an angle (rad), N m, and its slope, N m/rad.
    fn torque_nm(&self, angle: f64) -> (f64, f64) {
        let ((pull_a, slope_a), (pull_b, slope_b)) = (self.pull_n(0, angle), self.pull_n(1, angle));
        let radius_m = 1e-3 * self.radius_mm;
        let (bearing_nm, bearing_slope) = self.bearing.resistance_n(angle, &self.bearing_limits());
        (
            radius_m * (pull_a - pull_b) - bearing_nm,
            radius_m * self.radius_mm * (slope_a + slope_b) - bearing_slope,
        )
    }

    fn bearing_limits(&self) -> Limits {
        Limits { rising: (self.bearing_nm, 0.0), falling: (self.bearing_nm, 0.0) }
    }

    /// Brings friction to where it is at an angle (rad).
    fn settle(&mut self, angle: f64) {
        let limits = self.bearing_limits();
        self.bearing.settle(angle, &limits);
        for place in [0, 1] {
            if self.pull_n(place, angle).0 > 0.0 {
                let contraction_mm = self.contraction_mm(place, angle);
                self.sides[place].hold(contraction_mm);
            }
        }
    }

    fn measure(&mut self) -> JointMeasurement {
        let [a, b] = &self.sides;
        let exact =
            JointMeasurement { pressures_bar: [a, b].map(Side::pressure_bar), angle_deg: self.exact_deg() };
        let Some(noise) = &mut self.noise else { return exact };
        JointMeasurement {
            pressures_bar: exact.pressures_bar.map(|bar| bar + PRESSURE_NOISE_BAR * noise.normal()),
            angle_deg: exact.angle_deg + ANGLE_NOISE_DEG * noise.normal(),
        }
    }

    fn advance(&mut self, commands_bar: [f64; 2], dt_s: f64) {
        for (side, command_bar) in self.sides.iter_mut().zip(commands_bar) {
            side.blow(command_bar, dt_s);
        }
        let step = self.dynamics.step(&self.motion, dt_s);
        let surplus = |angle: f64| {
            let (torque_nm, slope) = self.torque_nm(angle);
            (
                torque_nm + self.load_nm - step.stiffness_n * (angle - step.free_ratio),
                slope - step.stiffness_n,
            )
        };
        // Every term falls with the angle.
        let (mut below, mut above) = (-STOP_RAD, STOP_RAD);
        let mut angle = self.motion.ratio;
        for _ in 0..ITERATION_LIMIT {
            let (surplus_nm, slope) = surplus(angle);
            if surplus_nm > 0.0 {
                below = angle;
            } else {
                above = angle;
            }
            let newton = angle - surplus_nm / slope;
            let next = if below < newton && newton < above { newton } else { 0.5 * (below + above) };
            let moved = (next - angle).abs();
            angle = next;
            if moved <= TOLERANCE_RAD {
                break;
            }
        }
        self.settle(angle);
        self.motion = step.arrive(angle);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn more_pressure_in_the_first_muscle_turns_the_joint_to_larger_angles_and_back() {
        let mut joint = JointPlant::new(1, false);
        let middle_deg = joint.step([3.0, 3.0], 2.0).angle_deg;
        assert!(joint.step([3.5, 2.5], 2.0).angle_deg > middle_deg + 10.0);
        assert!(joint.step([2.5, 3.5], 2.0).angle_deg < middle_deg - 10.0);
        assert!(joint.tensions_n().iter().all(|tension_n| *tension_n > 0.0));
    }

    #[test]
    fn joint_at_rest_is_balanced_and_gives_to_a_slow_load_as_its_stiffness_says() {
        let mut joint = JointPlant::new(2, false);
        joint.step([3.0, 3.0], 3.0);
        assert!(joint.torque_nm(joint.motion.ratio).0.abs() < 1e-3);
        let at_rest = joint.clone();
        assert!(at_rest.stiffness_nm_per_rad(0.035) > at_rest.stiffness_nm_per_rad(0.1));
        // A load to and fro, as large as turns it by about two degrees. It goes slowly: where a
        // joint overshoots friction holds it.
        let largest_nm = at_rest.stiffness_nm_per_rad(0.035) * 0.035;
        let mut load_nm = 0.0;
        let mut at_deg = |end_nm: f64| {
            let start_nm = load_nm;
            for step in 1..=400 {
                load_nm = start_nm + (end_nm - start_nm) * f64::from(step) / 400.0;
                joint.put_on(load_nm);
                joint.step([3.0, 3.0], 0.01);
            }
            joint.exact_deg()
        };
        for first in [largest_nm, -largest_nm] {
            at_deg(first);
        }
        let swing_deg = at_deg(largest_nm) - at_deg(-largest_nm);
        assert!((swing_deg - 2.0 * 0.035_f64.to_degrees()).abs() < 0.2, "{swing_deg} degrees");
    }

    #[test]
    fn seed_decides_the_joint_and_its_noise() {
        let after = |seed| JointPlant::new(seed, true).step([3.5, 3.0], 1.0);
        assert_eq!(after(1), after(1));
        assert_ne!(after(1), after(2));
    }
}
