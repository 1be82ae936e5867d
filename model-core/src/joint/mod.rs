//! A joint: two muscles that pull against each other at one axis, each on a regulator of its own.
//!
//! ```text
//! torque     τ = u_a α_a(φ) - u_b α_b(φ) - passive(φ) - viscosity φ' - Σₖ (w_a,ₖ σ_a,ₖ + w_b,ₖ σ_b,ₖ)
//! drive      u = p + knee/p
//! slip       h = constant + per_bar u
//! stop m, k  σ: the angle since the last reversal, at most ± rₖ h_m
//! ```
//!
//! with φ the angle, p a muscle's pressure, α its torque for each bar of drive, w the stiffness of
//! its friction before it slips, and h how much farther that reaches under more pressure. With the
//! friction that there is the torque is linear in both drives, and where it is known which stops a
//! swing makes slip so is the stiffness: which pressures bring about a torque and a stiffness is
//! two linear equations. The friction and those stops are taken from the pressures of the sample
//! before, which a sample changes by little.
//!
//! # Why not two models of contraction over pressure
//! Such a model has its hysteresis at one load. At a joint a muscle's load goes from nothing to
//! nearly all of its force, and its friction grows with the pressure, so that the loop over the
//! pressure is another one at each stiffness. Over the *angle*, which both muscles share, friction
//! is a bank of stops for each, the counterpart of the plays. And every unknown but the knees and
//! the two shares of the slip is then linear in what a recording of pressures, angle and torque
//! shows.
//!
//! # Geometry
//! Pulley, lever or cam are all in α and the passive torque, which are polynomials of the angle:
//! neither radius nor length has to be known.
//!
//! # Stiffness
//! The torque against a slow swing of the joint by ± `swing` around an angle, pressures held, for
//! each radian: the slope of all that is smooth, and of each stop the part min(1, r h/swing), since
//! a stop that is shorter than the swing slips. Friction that sticks is a good part of it.
//!
//! | file | what it does |
//! |---|---|
//! | [`pull`] | one muscle: drive, torque, lowest and highest pressure |
//! | [`stops`] | the banks of stops |
//! | [`balance`] | torque and stiffness as linear forms of the drives, and the two equations |
//! | [`control`] | the controller of angle and stiffness |
//!
//! # Limits
//! Neither muscle may be slack: the lowest pressures are those at which the joint was recorded. A
//! stop's stiffness before it slips does not depend on the pressure.

pub mod balance;
pub mod control;
pub mod pull;
pub mod stops;

pub use control::{JointCommand, JointControl, JointControlParameters, JointState, JointTarget};
pub use pull::PullParameters;

use crate::convert;
use crate::error::{Check, ParameterError};
use crate::list::List;
use crate::range::Range;
use crate::real::Real;
use balance::{Form, share};
use pull::{Pull, polynomial, slope};
use stops::{Stops, Thresholds};

/// Number of coefficients of a muscle's torque over the angle.
pub const ARM: usize = 3;
/// Number of coefficients of the passive torque.
pub const PASSIVE: usize = 4;
/// A joint is checked at so many angles of its range.
const CHECKED_ANGLES: usize = 33;
/// No joint is as stiff. Unit: N m/rad.
const STIFFEST: f64 = 1e9;

/// Raw parameters of a joint with at most `N` stops.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(
    feature = "serde",
    derive(serde::Serialize, serde::Deserialize),
    serde(bound = "T: Real + serde::Serialize + serde::de::DeserializeOwned")
)]
pub struct JointParameters<T, const N: usize> {
    /// The muscle that turns the joint to larger angles, and the other one.
    pub muscles: [PullParameters<T, N>; 2],
    /// Torque against the angle without pressure, a polynomial of it, constant first. Unit: N m,
    /// N m/rad, …
    pub passive: [T; PASSIVE],
    /// Torque against the speed. Unit: N m s/rad, at least 0.
    pub viscosity: T,
    /// The reaches r of the stops, in rising order and the same for both muscles. Each muscle's
    /// slip multiplies them. Unit: rad, above 0.
    pub reaches: List<T, N>,
    /// Half the swing that the stiffness is for. Unit: rad, above 0.
    pub swing: T,
    /// The angles that the model is valid for. Unit: rad.
    pub angles: (T, T),
}

impl<T: Real, const N: usize> JointParameters<T, N> {
    /// The same parameters in another number type or capacity, for instance those of the board.
    ///
    /// # Errors
    /// The other capacity is too small.
    pub fn convert<U: Real, const N2: usize>(&self) -> Result<JointParameters<U, N2>, ParameterError> {
        let [a, b] = &self.muscles;
        Ok(JointParameters {
            muscles: [a.convert()?, b.convert()?],
            passive: self.passive.map(convert::number),
            viscosity: convert::number(self.viscosity),
            reaches: convert::list("reaches", &self.reaches)?,
            swing: convert::number(self.swing),
            angles: (convert::number(self.angles.0), convert::number(self.angles.1)),
        })
    }
}

/// A validated joint of at most `N` stops.
#[derive(Clone, Debug, PartialEq)]
pub struct Joint<T, const N: usize> {
    muscles: [Pull<T, N>; 2],
    passive: [T; PASSIVE],
    viscosity: T,
    stops: Thresholds<T, N>,
    /// Unit: rad.
    swing: T,
    /// Unit: N m/rad.
    stiffest: T,
    angles: Range<T>,
}

impl<T: Real, const N: usize> Joint<T, N> {
    /// # Errors
    /// The first parameter that no joint can be made of: muscles that do not pull against each
    /// other everywhere in the range, a lowest pressure that is not valid, or a joint that does
    /// not get stiffer with the pressure.
    pub fn try_new(parameters: &JointParameters<T, N>) -> Result<Self, ParameterError> {
        let JointParameters { muscles, passive, viscosity, reaches, swing, angles } = parameters;
        let stops = Thresholds::try_new(reaches)?;
        let swing = Check::new("swing", "rad").above(*swing, T::ZERO)?;
        let angles = Range::try_new(angles.0, angles.1, "angle range", "rad")?;
        for (i, coefficient) in passive.iter().enumerate() {
            Check::at("passive", i, "N m").finite(*coefficient)?;
        }
        let [a, b] = muscles;
        let mut joint = Self {
            muscles: [Pull::try_new(a, reaches, &angles)?, Pull::try_new(b, reaches, &angles)?],
            passive: *passive,
            viscosity: Check::new("viscosity", "N m s/rad").at_least(*viscosity, T::ZERO)?,
            stops,
            swing,
            stiffest: T::ZERO,
            angles,
        };
        joint.stiffest = joint.check_stiffening()?;
        Ok(joint)
    }

    /// That the joint is stiff within the bounds of the pressures, and that more pressure in both
    /// muscles makes it stiffer, at all angles. Answers the largest stiffness of these. Unit:
    /// N m/rad.
    fn check_stiffening(&self) -> Result<T, ParameterError> {
        let mut stiffest = T::ZERO;
        let still = Stops::relaxed(T::ZERO);
        for i in 0..CHECKED_ANGLES {
            let angle = checked_angle(&self.angles, i);
            let torque = self.torque_form(angle, T::ZERO, &still);
            let [a, b] = &self.muscles;
            let (ends_a, ends_b) = (a.bounds(angle), b.bounds(angle));
            for pressure_a in [ends_a.0, ends_a.1] {
                for pressure_b in [ends_b.0, ends_b.1] {
                    let drives = self.drives([pressure_a, pressure_b]);
                    let form = self.stiffness_form(angle, drives);
                    Check::at("stiffening", i, "N m/(rad bar)").above(form.along(&torque), T::ZERO)?;
                    let stiffness = Check::at("stiffness", i, "N m/rad").above(form.at(drives), T::ZERO)?;
                    stiffest = stiffest.at_least(stiffness);
                }
            }
        }
        Ok(stiffest)
    }

    /// The angles that it is valid for. Unit: rad.
    pub fn angles(&self) -> &Range<T> {
        &self.angles
    }

    /// Half the swing that the stiffness is for. Unit: rad.
    pub fn swing(&self) -> T {
        self.swing
    }

    /// What both muscles turn with at an angle (rad), their friction and what turns without
    /// pressure left out. Pressures: bar, counted as the lowest ones where they are below; result:
    /// N m.
    pub fn pull_of(&self, angle: T, pressures: [T; 2]) -> T {
        let ([a, b], [pressure_a, pressure_b]) = (&self.muscles, pressures);
        let of = |muscle: &Pull<T, N>, pressure: T| {
            polynomial(&muscle.arm, angle) * muscle.drive(pressure.at_least(muscle.bounds(angle).0))
        };
        of(a, pressure_a) - of(b, pressure_b)
    }

    /// The largest stiffness at the ends of the bounds of both pressures, over all angles. Unit:
    /// N m/rad.
    pub fn stiffest(&self) -> T {
        self.stiffest
    }

    /// Turns the stops to an angle (rad), under pressures (bar, above 0).
    pub fn turn(&self, stops: &mut Stops<T, N>, angle: T, pressures: [T; 2]) {
        let ([a, b], [pressure_a, pressure_b]) = (&self.muscles, pressures);
        self.stops.turn(stops, angle, [a.slip(pressure_a), b.slip(pressure_b)]);
    }

    /// A muscle, 0 or 1 by its place, for the bounds of its pressure.
    pub fn muscles(&self) -> &[Pull<T, N>; 2] {
        &self.muscles
    }

    /// The torque of both muscles at an angle (rad) and a speed (rad/s), with the stops as they
    /// have been turned. Pressures: bar, above 0; result: N m, that which turns the joint to larger
    /// angles positive.
    pub fn torque(&self, angle: T, speed: T, stops: &Stops<T, N>, pressures: [T; 2]) -> T {
        self.torque_form(angle, speed, stops).at(self.drives(pressures))
    }

    /// The stiffness at an angle (rad) under pressures (bar, above 0). Result: N m/rad.
    pub fn stiffness(&self, angle: T, pressures: [T; 2]) -> T {
        let drives = self.drives(pressures);
        self.stiffness_form(angle, drives).at(drives)
    }

    /// The least and the largest stiffness at an angle (rad), nothing else acting, the stops
    /// without tension. Unit: N m/rad.
    pub fn stiffness_range(&self, angle: T) -> (T, T) {
        let still = Stops::relaxed(angle);
        let [a, b] = &self.muscles;
        let lowest = self.drives([a.bounds(angle).0, b.bounds(angle).0]);
        // Each ends at a bound, whatever slips: more of both pressures is always stiffer.
        let (torque, stiffness) =
            (self.torque_form(angle, T::ZERO, &still), self.stiffness_form(angle, lowest));
        let at = |wanted: T| {
            let found = share(&self.muscles, angle, (&torque, T::ZERO), (&stiffness, wanted));
            self.stiffness(angle, found.pressures)
        };
        (at(T::ZERO), at(T::from_f64(STIFFEST)))
    }

    pub(crate) fn drives(&self, pressures: [T; 2]) -> [T; 2] {
        let [a, b] = &self.muscles;
        let [pressure_a, pressure_b] = pressures;
        [a.drive(pressure_a), b.drive(pressure_b)]
    }

    /// The torque over the drives, with the friction that there is. Unit: N m.
    pub(crate) fn torque_form(&self, angle: T, speed: T, stops: &Stops<T, N>) -> Form<T> {
        let [a, b] = &self.muscles;
        let mut constant = -polynomial(&self.passive, angle) - self.viscosity * speed;
        for (muscle, bank) in self.muscles.iter().zip(&stops.moved) {
            for (stiffness, moved) in muscle.friction.iter().zip(bank) {
                constant += -(*stiffness * *moved);
            }
        }
        Form { constant, by: [polynomial(&a.arm, angle), -polynomial(&b.arm, angle)] }
    }

    /// The stiffness over the drives, as far as the same stops slip as at some drives (bar). Unit:
    /// N m/rad.
    pub(crate) fn stiffness_form(&self, angle: T, drives: [T; 2]) -> Form<T> {
        let [a, b] = &self.muscles;
        let mut constant = slope(&self.passive, angle);
        let mut by = [-slope(&a.arm, angle), slope(&b.arm, angle)];
        for ((muscle, drive), by) in self.muscles.iter().zip(drives).zip(&mut by) {
            let [fixed, per_bar] = muscle.slip;
            let factor = fixed + per_bar * drive;
            for (stiffness, reach) in muscle.friction.iter().zip(self.stops.reaches()) {
                if *reach * factor < self.swing {
                    let share = *stiffness * *reach / self.swing;
                    constant += share * fixed;
                    *by += share * per_bar;
                } else {
                    constant += *stiffness;
                }
            }
        }
        Form { constant, by }
    }
}

/// One of the angles that a joint is checked at.
fn checked_angle<T: Real>(angles: &Range<T>, i: usize) -> T {
    let share = T::from_f64(i as f64 / (CHECKED_ANGLES - 1) as f64);
    angles.min() + share * (angles.max() - angles.min())
}
