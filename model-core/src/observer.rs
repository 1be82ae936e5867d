//! The disturbance observer: what moves the contraction and is neither reference nor model.
//!
//! ```text
//! reference ──▶ + ──▶ inverse of the extended model ──▶ command ──▶ muscle ──▶ contraction
//!               ▲                                                                  │
//!               └── estimate ◀── ∫ rate ◀── (reference that is due − contraction) ◀┘
//! ```
//! A load that nobody measures, a drift, or what the model gets wrong shifts the contraction away
//! from the one that the model has been asked for. The estimate of that shift, d, is how far the
//! measured contraction lies from the model's, through a first-order low pass of the given rate.
//! What the model was asked for is reference + d, so that the low pass of
//! (reference + d) − contraction is d' = rate (reference − contraction): one multiplication.
//!
//! The error goes through a low pass before, five times as fast as the estimate ([`FILTER`]): the
//! inverse leads lags, up to three of them, and would make a command of the sensor's noise.
//!
//! # Beside the integral of a PID
//! The estimate goes through the inverse. So a millimetre costs as much pressure as it takes there:
//! where the muscle is stiff more, where it has just turned round so much more as the hysteresis
//! asks for, and a valve's lag, viscosity and mass are led. An integral in bar/(mm s) has to be
//! slow enough for the steepest part of the curve and is ten times slower on the flattest; this one
//! is as fast everywhere. It takes the integral's place where both feed-forward and feedback act.
//!
//! # Contract
//! One [`Observer::settle`] a period. The estimate goes into the inverse of the next period. It
//! does not grow while the command cannot follow (anti-windup by clamping), and stays within
//! [`REACH`]. In a mode that does not use it, it fades, so that no change of mode is a jump.

use crate::error::{Check, ParameterError};
use crate::range::Range;
use crate::real::Real;

/// How large an estimate may be, as a share of the model's output range: a disturbance of half the
/// stroke leaves nothing to control.
pub const REACH: f64 = 0.5;

/// Time constant of the error's low pass, as a share of the estimate's: at the loop's corner it
/// costs 11 degrees of phase.
pub const FILTER: f64 = 0.2;

/// Raw parameters of the observer.
///
/// ```
/// use model_core::ObserverParameters;
///
/// assert_eq!(ObserverParameters::<f32>::default().rate_per_s, 0.0); // off
/// ```
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct ObserverParameters<T> {
    /// How fast the estimate follows. Unit: 1/s, at least 0; 0 switches the observer off.
    pub rate_per_s: T,
}

/// A validated observer for a fixed period.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Observer<T> {
    /// The rate times the period.
    share: T,
    /// The share of the way to the error that the low pass goes in one period.
    filter_share: T,
    /// What a millimetre takes on the average. Unit: bar/mm.
    mean: T,
    reach: Range<T>,
}

/// What the observer remembers.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct Estimate<T> {
    /// What is asked of the inverse beside the reference. Unit: mm.
    pub(crate) shift: T,
    /// The error behind its low pass. Unit: mm.
    error: T,
}

impl<T: Real> Estimate<T> {
    /// What is left of it after a period without the observer. `decay`: 1.
    pub(crate) fn faded(self, decay: T) -> Self {
        Self { shift: self.shift * decay, error: T::ZERO }
    }
}

impl<T: Real> Observer<T> {
    /// None where it is off. The model's outputs at its ends: mm; the commands there are: bar.
    ///
    /// # Errors
    /// A rate that is negative, not finite, or so fast that the estimate would overtake the error
    /// within a period.
    pub(crate) fn try_new(
        parameters: &ObserverParameters<T>,
        period_s: T,
        (low, high): (T, T),
        commands: &Range<T>,
    ) -> Result<Option<Self>, ParameterError> {
        let check = Check::new("observer rate_per_s", "1/s");
        let rate = check.at_most(check.at_least(parameters.rate_per_s, T::ZERO)?, T::ONE / period_s)?;
        if rate == T::ZERO {
            return Ok(None);
        }
        let reach = T::from_f64(REACH) * (high - low);
        let reach = Range::try_new(-reach, reach, "observer's reach", "mm")?;
        // By backward Euler, stable for every time constant.
        let filter_share = period_s / (T::from_f64(FILTER) / rate + period_s);
        let mean = (commands.max() - commands.min()) / (high - low);
        Ok(Some(Self { share: rate * period_s, filter_share, mean, reach }))
    }

    /// About how much of a feed-forward is there because of the estimate, for whoever watches
    /// what feedback adds. Unit: bar.
    #[inline(always)]
    pub(crate) fn added(&self, estimate: Estimate<T>) -> T {
        estimate.shift * self.mean
    }

    /// The estimate for the next period, from the error (mm) and whether the command stands at its
    /// lower and its upper limit.
    #[inline(always)]
    pub(crate) fn settle(&self, last: Estimate<T>, error: T, (is_low, is_high): (bool, bool)) -> Estimate<T> {
        let error = last.error + self.filter_share * (error - last.error);
        let is_held = if error > T::ZERO { is_high } else { is_low };
        let shift = if is_held { last.shift } else { self.reach.limit(last.shift + self.share * error) };
        Estimate { shift, error }
    }
}
