//! The feedback controller of equation (24): PID with what the paper leaves out.
//!
//! * The derivative acts on the measurement, through a first-order filter: a step of the reference
//!   makes no kick, and sensor noise is bounded.
//! * Anti-windup by back-calculation: what the limits cut off the command flows back into the
//!   integral with the time constant `tracking_time_s`. Without integral gain there is nothing to
//!   wind up, and the integral stays 0.
//! * Gains are absolute: kp in bar/mm, ki in bar/(mm s), kd in bar s/mm. The paper gives none of
//!   the units; these are plausible for its values and stable. Its second "Kp = 0" is Kd.
//!
//! # Contract
//! One [`Pid::output`] and one [`Pid::settle`] each period, in that order: between the two the
//! caller applies its limits. The integral uses the error of the previous periods (forward Euler),
//! so that the output needs nothing from the future.

use crate::error::{Check, ParameterError};
use crate::real::Real;

/// Raw parameters of the PID.
///
/// ```
/// use model_core::pid::{Pid, PidParameters};
///
/// let wrong = PidParameters { ki: -0.01, ..PidParameters::paper() };
/// assert_eq!(Pid::try_new(&wrong, 0.001).unwrap_err().parameter, "ki");
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct PidParameters<T> {
    /// Proportional gain. Unit: bar/mm, at least 0.
    pub kp: T,
    /// Integral gain. Unit: bar/(mm s), at least 0.
    pub ki: T,
    /// Derivative gain. Unit: bar s/mm, at least 0.
    pub kd: T,
    /// Time constant of the derivative's filter. Unit: s, at least 0.
    pub derivative_filter_s: T,
    /// Time constant of the back-calculation. Unit: s, above 0.
    pub tracking_time_s: T,
}

impl<T: Real> PidParameters<T> {
    /// The paper's gains; filter and back-calculation, on which it is silent, at 20 ms and 1 s.
    pub fn paper() -> Self {
        Self {
            kp: T::from_f64(0.05),
            ki: T::from_f64(0.01),
            kd: T::ZERO,
            derivative_filter_s: T::from_f64(0.02),
            tracking_time_s: T::ONE,
        }
    }
}

/// A validated PID for a fixed period.
///
/// ```
/// use model_core::pid::{Pid, PidParameters, PidState};
///
/// let pid = Pid::try_new(&PidParameters::paper(), 0.001)?;
/// let mut state = PidState::starting_at(0.0);
/// let first: f64 = pid.output(&mut state, 2.0, 0.0);
/// assert!((first - 0.05 * 2.0).abs() < 1e-12); // bar: the proportional part alone
/// pid.settle(&mut state, 2.0, 0.0);
/// assert!(pid.output(&mut state, 2.0, 0.0) > first); // the integral grows while the error lasts
/// # Ok::<(), Box<dyn core::error::Error>>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Pid<T> {
    kp: T,
    /// ki times the period.
    ki_period: T,
    /// kd over the sum of filter time constant and period: the filter by backward Euler, stable for
    /// every time constant.
    kd_rate: T,
    /// The share of the way to the measurement that the filter goes in one period.
    filter_share: T,
    /// The share of the excess that flows back in one period; 0 without integral gain.
    back_calculation: T,
}

/// What the PID remembers.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PidState<T> {
    /// Integral part of the output. Unit: bar.
    integral: T,
    /// Filtered measurement. Unit: mm.
    filtered: T,
}

impl<T: Real> PidState<T> {
    /// The state at the first sample, whose measurement (mm) is taken for one that has lasted.
    pub fn starting_at(measurement: T) -> Self {
        Self { integral: T::ZERO, filtered: measurement }
    }
}

impl<T: Real> Pid<T> {
    /// # Errors
    /// A negative gain or time constant, a back-calculation time constant or period of 0, anything
    /// not finite.
    pub fn try_new(parameters: &PidParameters<T>, period_s: T) -> Result<Self, ParameterError> {
        let period = Check::new("period_s", "s").above(period_s, T::ZERO)?;
        let filter =
            Check::new("derivative_filter_s", "s").at_least(parameters.derivative_filter_s, T::ZERO)?;
        let tracking = Check::new("tracking_time_s", "s").above(parameters.tracking_time_s, T::ZERO)?;
        let ki = Check::new("ki", "bar/(mm s)").at_least(parameters.ki, T::ZERO)?;
        let share = (period / tracking).limit(T::ZERO, T::ONE);
        Ok(Self {
            kp: Check::new("kp", "bar/mm").at_least(parameters.kp, T::ZERO)?,
            ki_period: ki * period,
            kd_rate: Check::new("kd", "bar s/mm").at_least(parameters.kd, T::ZERO)? / (filter + period),
            filter_share: period / (filter + period),
            back_calculation: if ki > T::ZERO { share } else { T::ZERO },
        })
    }

    /// The output for this period, from the error (reference minus measurement) and the
    /// measurement. Both: mm; result: bar.
    #[inline(always)]
    pub fn output(&self, state: &mut PidState<T>, error: T, measurement: T) -> T {
        self.scaled_output(state, T::ONE, error, measurement)
    }

    /// The same with all gains as many times as large: `error` is that many times the error.
    #[inline(always)]
    pub(crate) fn scaled_output(&self, state: &mut PidState<T>, factor: T, error: T, measurement: T) -> T {
        let ahead = measurement - state.filtered;
        state.filtered += self.filter_share * ahead;
        self.kp * error + state.integral - self.kd_rate * (factor * ahead)
    }

    /// Closes the period: integrates the error (mm), and takes back `excess` (bar), what the limits
    /// cut off the output (applied minus asked).
    #[inline(always)]
    pub fn settle(&self, state: &mut PidState<T>, error: T, excess: T) {
        state.integral += self.ki_period * error + self.back_calculation * excess;
    }
}
