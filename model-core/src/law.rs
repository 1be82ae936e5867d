//! The control law of Fig. 10 alone: inverse model as feed-forward, PID as feedback, slew and
//! limits.
//!
//! For a firmware that knows its model, and its size, when it is compiled, such as
//! [`crate::cascade::InverseCascade`] with one kind of envelope. [`crate::tracking`] is for what is
//! chosen at run time; beside the same law it has modes, extensions, the preview of a delay and a
//! limit to what the feedback sees of a wild sample, which together cost half as much again.
//!
//! # Contract
//! One [`Law::step`] a period. Without extensions, in the mode of feed-forward and feedback, with
//! reference and contraction in the model's output range, the command is that of the tracking
//! controller, bit for bit. Beyond that range nothing but the anti-windup holds the integral back:
//! the caller rejects wild samples.

use crate::error::{Check, InputError, ParameterError, finite_input};
use crate::hysteresis::{HysteresisState, InverseHysteresis};
use crate::pid::{Pid, PidParameters, PidState};
use crate::range::Range;
use crate::real::Real;

/// Raw parameters of the law.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LawParameters<T> {
    /// The feedback.
    pub pid: PidParameters<T>,
    /// Lowest command, also the one at the start. Unit: bar.
    pub command_min: T,
    /// Highest command. Unit: bar.
    pub command_max: T,
    /// Largest rate of change of the command. Unit: bar/s, above 0.
    pub slew_bar_per_s: T,
    /// Time from sample to sample. Unit: s, above 0.
    pub period_s: T,
}

/// A validated control law with the inverse model `I`.
///
/// ```
/// use model_core::law::{Law, LawParameters};
/// use model_core::pid::PidParameters;
/// use model_core::{Invertible, Mgpi};
///
/// let inverse = Mgpi::try_new(&model_core::paper::mgpi()?)?.inverse()?;
/// let law = Law::try_new(inverse, &LawParameters {
///     pid: PidParameters::paper(),
///     command_min: 0.0,
///     command_max: 6.0,
///     slew_bar_per_s: 60.0,
///     period_s: 0.001,
/// })?;
/// let mut state = law.rest_state(0.0);
/// let command: f64 = law.step(&mut state, 40.0, 0.0)?;
/// assert!(command > 0.0 && command <= 0.06 + 1e-12); // bar: no faster than the slew limit
/// # Ok::<(), Box<dyn core::error::Error>>(())
/// ```
#[derive(Clone, Debug, PartialEq)]
#[repr(C)] // As for `LawState`.
pub struct Law<T, I> {
    inverse: I,
    pid: Pid<T>,
    limits: Range<T>,
    /// Of the command in one period. Unit: bar.
    largest_change: T,
}

/// What the law remembers.
#[derive(Clone, Debug, PartialEq)]
#[repr(C)] // The inverse's first: what stands at the begin needs no address of its own.
pub struct LawState<T, const N: usize> {
    inverse: HysteresisState<T, N>,
    pid: PidState<T>,
    /// Unit: bar.
    command: T,
}

impl<T: Real, I> Law<T, I> {
    /// # Errors
    /// The first parameter that no law can be made of.
    pub fn try_new(inverse: I, parameters: &LawParameters<T>) -> Result<Self, ParameterError> {
        let LawParameters { pid, command_min, command_max, slew_bar_per_s, period_s } = parameters;
        let period = Check::new("period_s", "s").above(*period_s, T::ZERO)?;
        let slew = Check::new("slew_bar_per_s", "bar/s").above(*slew_bar_per_s, T::ZERO)?;
        Ok(Self {
            inverse,
            pid: Pid::try_new(pid, period)?,
            limits: Range::try_new(*command_min, *command_max, "command range", "bar")?,
            largest_change: slew * period,
        })
    }

    /// The state of a muscle at rest, the valve at the lowest command. Contraction there: mm.
    pub fn rest_state<const N: usize>(&self, contraction: T) -> LawState<T, N>
    where
        I: InverseHysteresis<T, N>,
    {
        LawState {
            inverse: self.inverse.rest_state(),
            pid: PidState::starting_at(contraction),
            command: self.limits.min(),
        }
    }

    /// One sample: the command, bar. Reference and contraction, now: mm.
    ///
    /// # Errors
    /// A value that is not finite; the state, and so the last command, is then as it was.
    #[inline(always)]
    pub fn step<const N: usize>(
        &self,
        state: &mut LawState<T, N>,
        reference: T,
        contraction: T,
    ) -> Result<T, InputError>
    where
        I: InverseHysteresis<T, N>,
    {
        let (reference, contraction) = (finite_input(reference)?, finite_input(contraction)?);
        let error = reference - contraction;
        let feedback = self.pid.output(&mut state.pid, error, contraction);
        let asked = self.inverse.step(&mut state.inverse, reference)? + feedback;
        let command = self.limits.step_toward(state.command, asked, self.largest_change);
        state.command = command;
        self.pid.settle(&mut state.pid, error, command - asked);
        Ok(command)
    }
}
