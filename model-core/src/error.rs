//! What can be wrong with parameters and with inputs.

use core::fmt;

use crate::real::Real;

/// What a parameter has to fulfil.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Requirement {
    /// neither infinite nor NaN
    Finite,
    /// larger than the limit
    Above(f64),
    /// the limit or larger
    AtLeast(f64),
    /// smaller than the limit
    Below(f64),
    /// the limit or smaller
    AtMost(f64),
    /// exactly the limit
    Exactly(f64),
}

impl fmt::Display for Requirement {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Finite => write!(f, "finite"),
            Self::Above(limit) => write!(f, "above {limit}"),
            Self::AtLeast(limit) => write!(f, "at least {limit}"),
            Self::Below(limit) => write!(f, "below {limit}"),
            Self::AtMost(limit) => write!(f, "at most {limit}"),
            Self::Exactly(limit) => write!(f, "exactly {limit}"),
        }
    }
}

/// A parameter that no model can be made of: its name, its value and what it has to be.
///
/// ```
/// use model_core::Range;
///
/// let refused = Range::try_new(1.0, 0.5, "command range", "bar").unwrap_err();
/// assert_eq!(refused.to_string(), "command range is 0.5 bar, must be above 1 bar");
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ParameterError {
    /// The parameter, by the name that it has in its struct and in a model file.
    pub parameter: &'static str,
    /// Its place, if it is one of a list.
    pub index: Option<usize>,
    /// Its value.
    pub value: f64,
    /// What it has to be.
    pub requirement: Requirement,
    /// The unit of value and limit.
    pub unit: &'static str,
}

impl fmt::Display for ParameterError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}", self.parameter)?;
        if let Some(index) = self.index {
            write!(f, "[{index}]")?;
        }
        let space = if self.unit.is_empty() { "" } else { " " };
        write!(f, " is {}{space}{}, must be {}{space}{}", self.value, self.unit, self.requirement, self.unit)
    }
}

impl core::error::Error for ParameterError {}

/// An input that a step refuses; the state is as it was before.
///
/// ```
/// use model_core::{Hysteresis, InputError, Mgpi};
///
/// let muscle = Mgpi::try_new(&model_core::paper::mgpi()?)?;
/// assert_eq!(muscle.step(&mut muscle.rest_state(), f64::INFINITY), Err(InputError::NotFinite));
/// # Ok::<(), Box<dyn core::error::Error>>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum InputError {
    /// The input is infinite or not a number.
    NotFinite,
    /// No time, or less than none, has passed since the last sample.
    NotLater,
    /// There are more samples within the delay than can be kept.
    DelayTooLong,
}

impl fmt::Display for InputError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::NotFinite => write!(f, "the input is infinite or not a number"),
            Self::NotLater => write!(f, "no time has passed since the last sample"),
            Self::DelayTooLong => write!(f, "there are more samples within the delay than can be kept"),
        }
    }
}

impl core::error::Error for InputError {}

/// Refuses a non-finite input.
pub(crate) fn finite_input<T: Real>(value: T) -> Result<T, InputError> {
    if value.is_finite() { Ok(value) } else { Err(InputError::NotFinite) }
}

/// A parameter under test: its name, place and unit, for the error if it fails.
#[derive(Clone, Copy)]
pub(crate) struct Check {
    parameter: &'static str,
    index: Option<usize>,
    unit: &'static str,
}

impl Check {
    pub(crate) fn new(parameter: &'static str, unit: &'static str) -> Self {
        Self { parameter, index: None, unit }
    }

    pub(crate) fn at(parameter: &'static str, index: usize, unit: &'static str) -> Self {
        Self { parameter, index: Some(index), unit }
    }

    /// The same place under another name.
    pub(crate) fn named(self, parameter: &'static str) -> Self {
        Self { parameter, ..self }
    }

    pub(crate) fn error(self, value: f64, requirement: Requirement) -> ParameterError {
        ParameterError { parameter: self.parameter, index: self.index, value, requirement, unit: self.unit }
    }

    pub(crate) fn finite<T: Real>(self, value: T) -> Result<T, ParameterError> {
        if value.is_finite() { Ok(value) } else { Err(self.error(value.to_f64(), Requirement::Finite)) }
    }

    pub(crate) fn above<T: Real>(self, value: T, limit: T) -> Result<T, ParameterError> {
        let value = self.finite(value)?;
        if value > limit {
            Ok(value)
        } else {
            Err(self.error(value.to_f64(), Requirement::Above(limit.to_f64())))
        }
    }

    pub(crate) fn at_least<T: Real>(self, value: T, limit: T) -> Result<T, ParameterError> {
        let value = self.finite(value)?;
        if value >= limit {
            Ok(value)
        } else {
            Err(self.error(value.to_f64(), Requirement::AtLeast(limit.to_f64())))
        }
    }

    pub(crate) fn at_most<T: Real>(self, value: T, limit: T) -> Result<T, ParameterError> {
        let value = self.finite(value)?;
        if value <= limit {
            Ok(value)
        } else {
            Err(self.error(value.to_f64(), Requirement::AtMost(limit.to_f64())))
        }
    }

    pub(crate) fn below<T: Real>(self, value: T, limit: T) -> Result<T, ParameterError> {
        let value = self.finite(value)?;
        if value < limit {
            Ok(value)
        } else {
            Err(self.error(value.to_f64(), Requirement::Below(limit.to_f64())))
        }
    }

    /// A list's length against its capacity or against that of its companion.
    pub(crate) fn length(self, length: usize, requirement: Requirement) -> ParameterError {
        self.error(length as f64, requirement)
    }
}
