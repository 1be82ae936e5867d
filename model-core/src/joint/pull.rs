//! One muscle at a joint: what torque its pressure makes, and between which pressures it may be.
//!
//! drive u = p + knee/p: a tube has to be pressed against its braid before it pulls, part by part,
//! so that the first bar does less than the last. The knee (bar²) says over which pressures; what
//! of the threshold does not depend on the pressure is in the joint's passive torque.

use super::{ARM, CHECKED_ANGLES, checked_angle};
use crate::convert;
use crate::error::{Check, ParameterError, Requirement};
use crate::list::List;
use crate::range::Range;
use crate::real::Real;

/// Raw parameters of a muscle at a joint with at most `N` stops.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(
    feature = "serde",
    derive(serde::Serialize, serde::Deserialize),
    serde(bound = "T: Real + serde::Serialize + serde::de::DeserializeOwned")
)]
pub struct PullParameters<T, const N: usize> {
    /// Torque for each bar of drive, in the direction of the muscle: a polynomial of the angle,
    /// constant first. Unit: N m/bar, N m/(bar rad), …
    pub arm: [T; ARM],
    /// Unit: bar², at least 0.
    pub knee: T,
    /// The stiffness of each stop of this muscle until it slips. Unit: N m/rad, at least 0.
    pub friction: List<T, N>,
    /// By what its stops reach farther than the joint's reaches: a factor that is constant, and one
    /// for each bar of drive. Unit: 1 and 1/bar, at least 0.
    pub slip: [T; 2],
    /// Lowest pressure at the lowest and at the highest angle, straight between: below it the
    /// muscle may be slack. Unit: bar, above the root of the knee.
    pub lowest: [T; 2],
    /// Highest pressure at the same angles. Unit: bar.
    pub highest: [T; 2],
    /// Time constant of the regulator. Unit: s, above 0.
    pub valve_lag_s: T,
}

impl<T: Real, const N: usize> PullParameters<T, N> {
    pub(super) fn convert<U: Real, const N2: usize>(&self) -> Result<PullParameters<U, N2>, ParameterError> {
        Ok(PullParameters {
            arm: self.arm.map(convert::number),
            knee: convert::number(self.knee),
            friction: convert::list("friction", &self.friction)?,
            slip: self.slip.map(convert::number),
            lowest: self.lowest.map(convert::number),
            highest: self.highest.map(convert::number),
            valve_lag_s: convert::number(self.valve_lag_s),
        })
    }
}

/// A validated muscle.
#[derive(Clone, Debug, PartialEq)]
pub struct Pull<T, const N: usize> {
    pub(super) arm: [T; ARM],
    knee: T,
    pub(super) friction: List<T, N>,
    pub(super) slip: [T; 2],
    /// Constant and slope over the angle.
    lowest: [T; 2],
    highest: [T; 2],
}

impl<T: Real, const N: usize> Pull<T, N> {
    pub(super) fn try_new(
        parameters: &PullParameters<T, N>,
        reaches: &[T],
        angles: &Range<T>,
    ) -> Result<Self, ParameterError> {
        let PullParameters { arm, knee, friction, slip, lowest, highest, .. } = parameters;
        Check::new("valve_lag_s", "s").above(parameters.valve_lag_s, T::ZERO)?;
        let knee = Check::new("knee", "bar²").at_least(*knee, T::ZERO)?;
        if friction.len() != reaches.len() {
            return Err(
                Check::new("friction", "").length(friction.len(), Requirement::Exactly(reaches.len() as f64))
            );
        }
        for (i, stiffness) in friction.iter().enumerate() {
            Check::at("friction", i, "N m/rad").at_least(*stiffness, T::ZERO)?;
        }
        let [constant, per_bar] = *slip;
        Check::new("slip", "1").at_least(constant, T::ZERO)?;
        Check::new("slip", "1/bar").at_least(per_bar, T::ZERO)?;
        Check::new("slip", "1").above(constant + per_bar, T::ZERO)?;
        let check = Check::new("lowest", "bar");
        for (lowest, highest) in lowest.iter().zip(highest) {
            let highest = Check::new("highest", "bar").finite(*highest)?;
            check.below(check.above(*lowest, knee.sqrt())?, highest)?;
        }
        let line = |[first, last]: [T; 2]| {
            let slope = (last - first) / (angles.max() - angles.min());
            [first - slope * angles.min(), slope]
        };
        let pull = Self {
            arm: *arm,
            knee,
            friction: friction.clone(),
            slip: *slip,
            lowest: line(*lowest),
            highest: line(*highest),
        };
        // By how much all friction that slips grows against it.
        let mut held = T::ZERO;
        for (reach, stiffness) in reaches.iter().zip(friction) {
            held += per_bar * *reach * *stiffness;
        }
        for i in 0..CHECKED_ANGLES {
            let arm = polynomial(&pull.arm, checked_angle(angles, i)) - held;
            Check::at("arm less friction", i, "N m/bar").above(arm, T::ZERO)?;
        }
        Ok(pull)
    }

    /// The drive of a pressure above 0. Both: bar.
    pub fn drive(&self, pressure: T) -> T {
        pressure + self.knee / pressure
    }

    /// The pressure of a drive that is one of a pressure above the root of the knee. Both: bar.
    pub(super) fn pressure(&self, drive: T) -> T {
        let half = T::from_f64(0.5) * drive;
        half + (half * half - self.knee).at_least(T::ZERO).sqrt()
    }

    /// By what its stops reach farther at a pressure (bar, above 0). Unit: 1.
    pub fn slip(&self, pressure: T) -> T {
        let [constant, per_bar] = self.slip;
        constant + per_bar * self.drive(pressure)
    }

    /// Lowest and highest pressure at an angle (rad). Unit: bar.
    pub fn bounds(&self, angle: T) -> (T, T) {
        let at = |[constant, slope]: [T; 2]| constant + slope * angle;
        (at(self.lowest), at(self.highest))
    }
}

/// A polynomial, constant first.
#[inline(always)]
pub(super) fn polynomial<T: Real>(coefficients: &[T], x: T) -> T {
    coefficients.iter().rev().fold(T::ZERO, |sum, coefficient| sum * x + *coefficient)
}

/// Its derivative.
#[inline(always)]
pub(super) fn slope<T: Real>(coefficients: &[T], x: T) -> T {
    let terms = coefficients.iter().enumerate().skip(1).rev();
    terms.fold(T::ZERO, |sum, (power, coefficient)| sum * x + T::from_f64(power as f64) * *coefficient)
}
