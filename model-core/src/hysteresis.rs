//! What every model of the family can do: [`Hysteresis`] forward, [`InverseHysteresis`] backward.
//!
//! All models keep the same kind of [`HysteresisState`]: it can be handed on without knowing the
//! model.

use crate::error::{InputError, ParameterError};
use crate::play::PlayState;
use crate::range::Range;
use crate::real::Real;

/// What a model or an inverse remembers.
///
/// ```
/// use model_core::{Hysteresis, Mgpi};
///
/// // Wiping out: after a rise to the upper end it no longer matters what was before.
/// let muscle = Mgpi::try_new(&model_core::paper::mgpi()?)?;
/// let (mut straight, mut winding) = (muscle.rest_state(), muscle.rest_state());
/// for pressure in [2.0, 1.0, 3.0, 0.5] {
///     muscle.step(&mut winding, pressure)?;
/// }
/// let (one, other) = (muscle.step(&mut straight, 6.0)?, muscle.step(&mut winding, 6.0)?);
/// assert!((one - other).abs() < 1e-12);
/// # Ok::<(), Box<dyn core::error::Error>>(())
/// ```
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(
    feature = "serde",
    derive(serde::Serialize, serde::Deserialize),
    serde(bound = "T: Real + serde::Serialize + serde::de::DeserializeOwned")
)]
#[repr(C)] // As for `InverseCascade`.
pub struct HysteresisState<T, const N: usize> {
    /// That of the plays.
    pub(crate) plays: PlayState<T, N>,
    /// The last sample, which models with two envelopes need. The others leave it as it is at rest.
    pub(crate) last: Sample<T>,
}

/// A sample on one of two branches.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub(crate) struct Sample<T> {
    /// Input, given to a model or answered by an inverse. Input unit.
    pub(crate) x: T,
    /// Output, answered by a model or given to an inverse. Output unit.
    pub(crate) y: T,
    /// Whether the input rose, or rested after it had risen.
    pub(crate) rising: bool,
}

impl<T: Real, const N: usize> HysteresisState<T, N> {
    /// The state of a model that needs its plays alone.
    pub(crate) fn of_plays(plays: PlayState<T, N>) -> Self {
        Self { plays, last: Sample { x: T::ZERO, y: T::ZERO, rising: true } }
    }

    /// Makes it the same as another one of the same model; copies no more than is remembered.
    pub(crate) fn copy_from(&mut self, other: &Self) {
        self.plays.copy_from(&other.plays);
        self.last = other.last;
    }

    /// The state of the plays.
    pub fn plays(&self) -> &PlayState<T, N> {
        &self.plays
    }
}

/// A validated hysteresis model with at most `N` plays: from input (pressure) to output
/// (contraction).
pub trait Hysteresis<T: Real, const N: usize> {
    /// The inputs that the model is valid for. Input unit.
    fn input_range(&self) -> &Range<T>;

    /// The state of a muscle that came from rest to the lower end of the input range.
    fn rest_state(&self) -> HysteresisState<T, N>;

    /// One sample: the output for the input `x`. Input: input unit; result: output unit. Inputs
    /// outside the input range are extrapolated, by at most its span on either side.
    ///
    /// # Errors
    /// `x` is not finite; the state is then as it was.
    fn step(&self, state: &mut HysteresisState<T, N>, x: T) -> Result<T, InputError>;

    /// The outputs at rest and, from there, at the upper end of the input range. Output unit.
    fn output_range(&self) -> (T, T) {
        let mut state = self.rest_state();
        // The ends of a range are finite: no step is refused.
        let mut output = |x| self.step(&mut state, x).unwrap_or(T::ZERO);
        (output(self.input_range().min()), output(self.input_range().max()))
    }
}

/// A model that has an inverse.
pub trait Invertible<T: Real, const N: usize>: Hysteresis<T, N> {
    /// Its inverse.
    type Inverse: InverseHysteresis<T, N>;

    /// Makes the inverse.
    ///
    /// # Errors
    /// A parameter of the inverse leaves the number type, or the model has no inverse that can be
    /// proven.
    fn inverse(&self) -> Result<Self::Inverse, ParameterError>;
}

/// The inverse of a model: from a wanted output to the input that brings it about.
pub trait InverseHysteresis<T: Real, const N: usize> {
    /// The state of the inverse after the history that led the model to `state`.
    fn state_of(&self, state: &HysteresisState<T, N>) -> HysteresisState<T, N>;

    /// The state of the inverse for a muscle at rest.
    fn rest_state(&self) -> HysteresisState<T, N>;

    /// The output that the inverse remembers to have reached. Output unit.
    fn last_output(&self, state: &HysteresisState<T, N>) -> T;

    /// One sample: the input, within the model's input range, that brings the output to `y`, or as
    /// near as the range allows. Input: output unit; result: input unit.
    ///
    /// # Errors
    /// `y` is not finite; the state is then as it was.
    fn step(&self, state: &mut HysteresisState<T, N>, y: T) -> Result<T, InputError>;
}
