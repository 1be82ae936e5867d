//! The disturbance observer: feedback that knows how much pressure a millimetre takes where the
//! muscle is.
//!
//! ```text
//! contraction ─▶ band ─▶ inverse, with the muscle's own memory ─▶ slope, bar/mm ─▶ factor ─▶ PID
//! reference, error ─▶ where the muscle is to go ──────────────────────▲
//! ```
//! A load that nobody measures, or a drift, is a pressure d that is missing at the muscle. Let P be
//! the muscle's answer, y the contraction, r the reference. What is missing is observed by
//! d' = (1/T) (dP⁻¹/dy)(r − y): a low pass of time constant T, the same on every slope of the loop.
//! An integral has one gain in its place, which the steepest slope allows, and is as many times
//! slower as a slope is flatter. So the slope of the inverse multiplies the PID's gains, which are
//! those for the steepest slope; the factor is 1 there.
//!
//! The slope is that of the operator's inverse from where the muscle is, in the direction in which
//! it is to go. Its memory is that of the measured contraction: a muscle that a load has pushed has
//! turned round, whatever the reference did.
//!
//! # Noise
//! A move within the band is none, so that noise does not turn the memory round; nor does an error
//! within it turn the direction.
//!
//! # Contract
//! One `Observer::factor` a period, whether or not the feedback acts. The factor lies between 1
//! and the reach: it never makes feedback weaker than the PID's gains are.
//!
//! # Limits
//! What extends the model (creep, viscosity, mass) has no part in the slope: the loop has to have
//! its margins with them.

use crate::error::{Check, ParameterError};
use crate::hysteresis::{HysteresisState, InverseHysteresis};
use crate::model::InverseModel;
use crate::range::Range;
use crate::real::Real;

/// How far ahead the slope is taken, as a share of the model's output range: less than a play of
/// the board's models is wide.
pub const LOOK: f64 = 0.01;

/// Raw parameters of the observer.
///
/// ```
/// use model_core::ObserverParameters;
///
/// assert_eq!(ObserverParameters::<f32>::default().slope, 0.0); // off
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct ObserverParameters<T> {
    /// The slope that the PID's gains are for. Unit: mm/bar, at least 0; 0 switches the observer
    /// off.
    pub slope: T,
    /// How many times as large the gains may become. Unit: 1, at least 1.
    pub reach: T,
    /// Moves and errors within it count as none. Unit: mm, at least 0.
    pub band: T,
}

impl<T: Real> Default for ObserverParameters<T> {
    /// Off.
    fn default() -> Self {
        Self { slope: T::ZERO, reach: T::ONE, band: T::ZERO }
    }
}

/// A validated observer for a fixed period.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Observer<T> {
    slope: T,
    reach: T,
    band: T,
    /// How far ahead the slope is taken. Unit: mm.
    look: T,
    /// T: what the error and the reference's rate are compared over. Unit: period.
    lasting: T,
    outputs: Range<T>,
}

/// What the observer remembers.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Observed<T, const N: usize> {
    /// The inverse's state of the muscle.
    muscle: HysteresisState<T, N>,
    /// Where it is: the contraction behind the band. Unit: mm.
    place: T,
    /// What was asked for a period ago. Unit: mm.
    due: T,
    is_rising: bool,
}

impl<T: Real, const N: usize> Observed<T, N> {
    /// Of a muscle whose inverse rests in a state.
    pub(crate) fn resting(muscle: HysteresisState<T, N>) -> Self {
        Self { muscle, place: T::ZERO, due: T::ZERO, is_rising: true }
    }
}

impl<T: Real> Observer<T> {
    /// None where it is off. `ki`: the integral gain, bar/(mm s). `outputs`: the model's, mm.
    ///
    /// # Errors
    /// The first parameter that is out of its limits.
    pub(crate) fn try_new(
        parameters: &ObserverParameters<T>,
        ki: T,
        period_s: T,
        (low, high): (T, T),
    ) -> Result<Option<Self>, ParameterError> {
        let ObserverParameters { slope, reach, band } = *parameters;
        let slope = Check::new("observer slope", "mm/bar").at_least(slope, T::ZERO)?;
        let reach = Check::new("observer reach", "").at_least(reach, T::ONE)?;
        let band = Check::new("observer band", "mm").at_least(band, T::ZERO)?;
        if slope == T::ZERO {
            return Ok(None);
        }
        let rate = ki * slope * period_s;
        Ok(Some(Self {
            slope,
            reach,
            band,
            look: T::from_f64(LOOK) * (high - low),
            lasting: if rate > T::ZERO { T::ONE / rate } else { T::ZERO },
            outputs: Range::try_new(low, high, "output range", "mm")?,
        }))
    }

    /// Closes a period: where the muscle is, and where it is asked to be now; both mm, finite.
    /// Answers what multiplies the PID's gains.
    pub(crate) fn factor<const N: usize, const M: usize>(
        &self,
        observed: &mut Observed<T, N>,
        inverse: &InverseModel<T, N, M>,
        contraction: T,
        due: T,
    ) -> T {
        let place = observed.place.limit(contraction - self.band, contraction + self.band);
        // No finite output is refused.
        let here = inverse.step(&mut observed.muscle, place).unwrap_or_default();
        // With the observed pressure the muscle goes on as the reference does, and takes back the
        // error.
        let way = (observed.due - contraction) + self.lasting * (due - observed.due);
        if way.abs() > self.band {
            observed.is_rising = way > T::ZERO;
        }
        let ahead = if observed.is_rising { place + self.look } else { place - self.look };
        let ahead = if self.outputs.contains(ahead) { ahead } else { place + (place - ahead) };
        let there = inverse.step(&mut observed.muscle.clone(), ahead).unwrap_or_default();
        let slope = (there - here).abs() / self.look;
        (observed.place, observed.due) = (place, due);
        (self.slope * slope).limit(T::ONE, self.reach)
    }
}
