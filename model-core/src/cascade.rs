//! The cascade that most of the family are: envelope, plays, dead zones.
//!
//! ```text
//! forward   x ── γ ──▶ v ── plays ──▶ u ── dead zones ──▶ y
//! inverse   y ── dead zones⁻¹ ──▶ u ── plays⁻¹ ──▶ v ── γ⁻¹ ──▶ x, limited to the input range
//! ```
//!
//! [`crate::mgpi`] has it with a tanh or a piecewise-linear envelope. Without an envelope and with dead zones on both
//! sides of 0 it is Kuhnen's modified model, with a single dead zone (a gain) the classical or the symmetric
//! generalized one.
//!
//! # The state of the inverse
//! The inverse remembers the history that it has commanded. An output that no input of the range reaches
//! is answered with the end of the range, and the inverse then remembers that end, not the impossible
//! demand: the next reachable output is inverted as exactly as if nothing had happened.

use crate::dead_zone::DeadZones;
use crate::envelope::Envelope;
use crate::error::{InputError, ParameterError, finite_input};
use crate::hysteresis::{Hysteresis, HysteresisState, InverseHysteresis, Invertible};
use crate::play::{PlayBank, Reached};
use crate::range::Range;
use crate::real::Real;

/// A validated, invertible cascade of an envelope, at most `N` plays and at most `M` dead zones.
#[derive(Clone, Debug, PartialEq)]
pub struct Cascade<T, E, const N: usize, const M: usize> {
    envelope: E,
    plays: PlayBank<T, N>,
    dead_zones: DeadZones<T, M>,
    input_range: Range<T>,
}

impl<T: Real, E: Envelope<T>, const N: usize, const M: usize> Cascade<T, E, N, M> {
    pub(crate) fn new(
        envelope: E,
        plays: PlayBank<T, N>,
        dead_zones: DeadZones<T, M>,
        input_range: Range<T>,
    ) -> Self {
        Self { envelope, plays, dead_zones, input_range }
    }

    /// The bank of plays.
    pub fn plays(&self) -> &PlayBank<T, N> {
        &self.plays
    }

    /// The dead-zone stage.
    pub fn dead_zones(&self) -> &DeadZones<T, M> {
        &self.dead_zones
    }
}

impl<T: Real, E: Envelope<T>, const N: usize, const M: usize> Hysteresis<T, N> for Cascade<T, E, N, M> {
    fn input_range(&self) -> &Range<T> {
        &self.input_range
    }

    fn rest_state(&self) -> HysteresisState<T, N> {
        HysteresisState::of_plays(self.plays.rest_state(self.envelope.value(self.input_range.min())))
    }

    /// Equation (16).
    fn step(&self, state: &mut HysteresisState<T, N>, x: T) -> Result<T, InputError> {
        let v = self.envelope.value(finite_input(x)?);
        Ok(self.dead_zones.value(self.plays.advance(&mut state.plays, v)))
    }
}

impl<T: Real, E: Envelope<T> + Clone, const N: usize, const M: usize> Invertible<T, N>
    for Cascade<T, E, N, M>
{
    type Inverse = InverseCascade<T, E, N, M>;

    fn inverse(&self) -> Result<Self::Inverse, ParameterError> {
        let v = |x| self.envelope.value(x);
        Ok(InverseCascade {
            plays: self.plays.inverse()?,
            inner_range: Range::try_new(
                v(self.input_range.min()),
                v(self.input_range.max()),
                "envelope range",
                "",
            )?,
            has_few: self.plays.has_few() && self.dead_zones.curve().has_few(),
            forward: self.clone(),
        })
    }
}

/// The inverse of a [`Cascade`].
#[derive(Clone, Debug, PartialEq)]
pub struct InverseCascade<T, E, const N: usize, const M: usize> {
    forward: Cascade<T, E, N, M>,
    /// The inverse of the forward model's plays.
    plays: PlayBank<T, N>,
    /// The image of the input range under the envelope.
    inner_range: Range<T>,
    /// Whether the curves of plays and dead zones have few segments, see [`crate::curve`].
    has_few: bool,
}

impl<T: Real, E: Envelope<T>, const N: usize, const M: usize> InverseCascade<T, E, N, M> {
    /// The model that this is the inverse of.
    pub fn forward(&self) -> &Cascade<T, E, N, M> {
        &self.forward
    }

    /// The step for an output that is known to be finite.
    #[inline(always)]
    pub(crate) fn answer(&self, state: &mut HysteresisState<T, N>, y: T) -> T {
        if self.has_few { self.answer_with::<true>(state, y) } else { self.answer_by_loops(state, y) }
    }

    /// Apart, lest it costs the other case registers.
    #[inline(never)]
    fn answer_by_loops(&self, state: &mut HysteresisState<T, N>, y: T) -> T {
        self.answer_with::<false>(state, y)
    }

    /// `FEW`: whether the curves of plays and dead zones have few segments.
    #[inline(always)]
    fn answer_with<const FEW: bool>(&self, state: &mut HysteresisState<T, N>, y: T) -> T {
        let u = self.forward.dead_zones.curve().segment_of::<FEW>(y).inverse(y);
        let ends = &self.forward.input_range;
        match self.plays.move_within::<FEW>(&mut state.plays, u, &self.inner_range) {
            Reached::Inside(v) => ends.limit(self.forward.envelope.inverse_inside(v)),
            // The end itself, whatever the envelope's rounding.
            Reached::End(_) if state.plays.rising => ends.max(),
            Reached::End(_) => ends.min(),
        }
    }
}

impl<T: Real, E: Envelope<T>, const N: usize, const M: usize> InverseHysteresis<T, N>
    for InverseCascade<T, E, N, M>
{
    fn state_of(&self, state: &HysteresisState<T, N>) -> HysteresisState<T, N> {
        HysteresisState::of_plays(self.forward.plays.inverse_state(&state.plays))
    }

    fn rest_state(&self) -> HysteresisState<T, N> {
        self.state_of(&self.forward.rest_state())
    }

    /// Equation (17).
    #[inline(always)]
    fn step(&self, state: &mut HysteresisState<T, N>, y: T) -> Result<T, InputError> {
        Ok(self.answer(state, finite_input(y)?))
    }
}
