//! A valve that ignores small changes of its command.
//!
//! | form | what it does | the inverse |
//! |---|---|---|
//! | hold | a command nearer than `band` to the last accepted one is ignored, else accepted whole | steps of at least 9/8 `band`, within 5/8 `band` of what is wanted |
//! | backlash | its set point follows the command at a distance of at most `band` (a play) | exact |
//!
//! A held valve cannot be given a set point nearer than `band` to the one that it has. The inverse
//! waits until the wanted one is 5/8 of the band away, and then goes past it, by 9/8 of the band:
//! an eighth more than the valve asks for, so that neither rounding nor a converter's steps lose
//! the move, and less than would take it back at once. With a lag behind it, the lag's inverse sees
//! what was really accepted and makes up for the rest in the mean.

use crate::convert;
use crate::error::{Check, ParameterError};
use crate::real::Real;

/// How far away a wanted set point makes a held valve move, and by how much. Unit: band.
const MOVES_FROM: f64 = 0.625;
const MOVES_BY: f64 = 1.125;

/// What a valve does with a change smaller than its dead band.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub enum DeadbandForm {
    /// Ignores it.
    Hold,
    /// Plays within it.
    Backlash,
}

/// Raw parameters of a dead band.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct ValveDeadbandParameters<T> {
    /// The band, on either side. Input unit, above 0.
    pub band: T,
    /// What happens within it.
    pub form: DeadbandForm,
}

impl<T: Real> ValveDeadbandParameters<T> {
    pub(super) fn convert<U: Real>(&self) -> ValveDeadbandParameters<U> {
        ValveDeadbandParameters { band: convert::number(self.band), form: self.form }
    }
}

/// A validated dead band.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct ValveDeadband<T> {
    band: T,
    form: DeadbandForm,
}

impl<T: Real> ValveDeadband<T> {
    pub(super) fn try_new(parameters: &ValveDeadbandParameters<T>) -> Result<Self, ParameterError> {
        let band = Check::new("valve_deadband band", "input unit").above(parameters.band, T::ZERO)?;
        Ok(Self { band, form: parameters.form })
    }

    /// The set point that a command leads to from another one.
    #[inline(always)]
    pub(super) fn set_point(&self, from: T, command: T) -> T {
        match self.form {
            DeadbandForm::Hold if (command - from).abs() < self.band => from,
            DeadbandForm::Hold => command,
            DeadbandForm::Backlash => from.limit(command - self.band, command + self.band),
        }
    }

    /// The command that leads from a set point to the wanted one, or as near as the form's table
    /// says.
    #[inline(always)]
    pub(super) fn command(&self, from: T, wanted: T) -> T {
        let way = wanted - from;
        let (direction, distance) = if way < T::ZERO { (-T::ONE, -way) } else { (T::ONE, way) };
        match self.form {
            DeadbandForm::Hold if distance < T::from_f64(MOVES_FROM) * self.band => from,
            DeadbandForm::Hold => from + direction * distance.at_least(T::from_f64(MOVES_BY) * self.band),
            DeadbandForm::Backlash if distance > T::ZERO => wanted + direction * self.band,
            DeadbandForm::Backlash => from,
        }
    }
}
