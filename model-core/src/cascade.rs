//! The cascade that most of the family are: envelope, plays, dead zones.
//!
//! ```text
//! forward   x ── γ ──▶ v ── plays ──▶ u ── dead zones ──▶ y
//! inverse   y ── dead zones⁻¹ ──▶ u ── plays⁻¹ ──▶ v ── γ⁻¹ ──▶ x, limited to the input range
//! ```
//!
//! | envelope | dead zones | model | file |
//! |---|---|---|---|
//! | none | one, a gain | classical (CPI) | [`crate::cpi`] |
//! | yes | one, a gain | symmetric generalized (SGPI) | [`crate::sgpi`] |
//! | none | several, on both sides of 0 | Kuhnen's modified (MPI) | [`crate::mpi`] |
//! | yes | several, from 0 | modified generalized (MGPI) | [`crate::mgpi`] |
//!
//! # The state of the inverse
//! The inverse remembers the history that it has commanded. An output that no input of the range
//! reaches is answered with the end of the range, and the inverse then remembers that end, not the
//! impossible demand: the next reachable output is inverted as exactly as if nothing had happened.
//!
//! # Where v and u count from
//! Plays do not mind where their input counts from, as long as their outputs count from there too.
//! But the smaller the numbers the smaller their roundings, and near an end of its values the
//! envelope is so flat that a rounding of v there is many of x. So the inverse counts v, and u with
//! it, from near its flatter end, and the envelope and the dead zones give and take them so. That
//! is for single precision, whose error it lessens to a third.

use crate::convert;
use crate::dead_zone::{DeadZoneParameters, DeadZones};
use crate::envelope::{AnyEnvelope, Envelope, EnvelopeParameters};
use crate::error::{InputError, ParameterError, finite_input};
use crate::hysteresis::{Hysteresis, HysteresisState, InverseHysteresis, Invertible};
use crate::play::{PlayBank, PlayParameters, Reached};
use crate::range::Range;
use crate::real::Real;
use crate::turning_points::TurningPoints;

/// Raw parameters of a cascade with at most `N` plays and `M` dead zones.
///
/// ```
/// use model_core::Mgpi;
///
/// let mut muscle = model_core::paper::mgpi()?;
/// (muscle.input_min, muscle.input_max) = (6.0, 0.0);
/// let refused = Mgpi::try_new(&muscle).unwrap_err();
/// assert_eq!(refused.to_string(), "input range is 0 input unit, must be above 6 input unit");
/// # Ok::<(), Box<dyn core::error::Error>>(())
/// ```
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(
    feature = "serde",
    derive(serde::Serialize, serde::Deserialize),
    serde(bound = "T: Real + serde::Serialize + serde::de::DeserializeOwned")
)]
pub struct CascadeParameters<T, const N: usize, const M: usize> {
    /// The envelope γ.
    pub envelope: EnvelopeParameters<T>,
    /// The bank of plays.
    pub plays: PlayParameters<T, N>,
    /// The dead-zone stage.
    pub dead_zones: DeadZoneParameters<T, M>,
    /// Lower end of the inputs that the model is valid for; the muscle's state of rest. Input unit.
    pub input_min: T,
    /// Upper end of the inputs that the model is valid for. Input unit.
    pub input_max: T,
    /// Whether the muscle has been through its whole range before, as most have: it is then at rest
    /// as after a rise to the upper end of the inputs and a return to the lower one. Else it comes
    /// from rest at 0.
    pub preconditioned: bool,
}

impl<T: Real, const N: usize, const M: usize> CascadeParameters<T, N, M> {
    /// The same parameters in another number type or capacity, for instance those of the board.
    ///
    /// # Errors
    /// The other capacity is too small.
    pub fn convert<U: Real, const N2: usize, const M2: usize>(
        &self,
    ) -> Result<CascadeParameters<U, N2, M2>, ParameterError> {
        Ok(CascadeParameters {
            envelope: self.envelope.convert()?,
            plays: self.plays.convert()?,
            dead_zones: self.dead_zones.convert()?,
            input_min: convert::number(self.input_min),
            input_max: convert::number(self.input_max),
            preconditioned: self.preconditioned,
        })
    }
}

/// A validated, invertible cascade of an envelope, at most `N` plays and at most `M` dead zones.
///
/// ```
/// use model_core::{Hysteresis, Mgpi};
///
/// let muscle = Mgpi::try_new(&model_core::paper::mgpi()?)?;
/// let mut state = muscle.rest_state();
/// let rising = muscle.step(&mut state, 3.0)?;
/// muscle.step(&mut state, 6.0)?;
/// let falling = muscle.step(&mut state, 3.0)?;
/// assert!(falling > rising); // mm: at the same pressure the muscle is shorter on the way back
/// # Ok::<(), Box<dyn core::error::Error>>(())
/// ```
#[derive(Clone, Debug, PartialEq)]
#[repr(C)] // As for `InverseCascade`.
pub struct Cascade<T, E, const N: usize, const M: usize> {
    input_range: Range<T>,
    envelope: E,
    dead_zones: DeadZones<T, M>,
    plays: PlayBank<T, N>,
    preconditioned: bool,
    /// The v and the u that v and u count from, in the envelope, the dead zones and every state; 0
    /// but inside an inverse.
    origin: (f64, f64),
}

impl<T: Real, E: Envelope<T>, const N: usize, const M: usize> Cascade<T, E, N, M> {
    /// With an envelope of a kind that is known at compile time, in the place of the parameters'
    /// own: its inverse takes fewer instructions, the fewer the smaller the capacities.
    ///
    /// # Errors
    /// The first parameter that no invertible model can be made of.
    pub fn with_envelope(
        envelope: E,
        parameters: &CascadeParameters<T, N, M>,
    ) -> Result<Self, ParameterError> {
        let CascadeParameters { plays, dead_zones, input_min, input_max, preconditioned, .. } = parameters;
        Ok(Self {
            envelope,
            plays: PlayBank::try_new(plays)?,
            dead_zones: DeadZones::try_new(dead_zones)?,
            input_range: Range::try_new(*input_min, *input_max, "input range", "input unit")?,
            preconditioned: *preconditioned,
            origin: (0.0, 0.0),
        })
    }

    /// The bank of plays.
    pub fn plays(&self) -> &PlayBank<T, N> {
        &self.plays
    }

    /// The dead-zone stage.
    pub fn dead_zones(&self) -> &DeadZones<T, M> {
        &self.dead_zones
    }

    /// What the plays hold back, from -1 to 1; of plays that can widen.
    pub(crate) fn held_back(&self, state: &HysteresisState<T, N>) -> T {
        self.plays.held_back(&state.plays)
    }

    /// The input behind the envelope, for [`step_wider`](Self::step_wider).
    pub(crate) fn enveloped(&self, x: T) -> T {
        self.envelope.value(self.input_range.extrapolated(x))
    }

    /// A step to an [enveloped](Self::enveloped) input with thresholds `times` as wide at this
    /// sample; of plays that can widen.
    #[inline(always)]
    pub(crate) fn step_wider(&self, state: &mut HysteresisState<T, N>, v: T, times: T) -> T {
        self.dead_zones.value(self.plays.advance_wider(&mut state.plays, v, times))
    }
}

impl<T: Real, const N: usize, const M: usize> Cascade<T, AnyEnvelope<T>, N, M> {
    /// # Errors
    /// The first parameter that no invertible model can be made of.
    pub fn try_new(parameters: &CascadeParameters<T, N, M>) -> Result<Self, ParameterError> {
        Self::with_envelope(AnyEnvelope::try_new(&parameters.envelope)?, parameters)
    }
}

impl<T: Real, E: Envelope<T>, const N: usize, const M: usize> Hysteresis<T, N> for Cascade<T, E, N, M> {
    fn input_range(&self) -> &Range<T> {
        &self.input_range
    }

    fn rest_state(&self) -> HysteresisState<T, N> {
        let lowest = self.envelope.value(self.input_range.min());
        let mut plays = self.plays.rested_at(T::from_f64(-self.origin.0), lowest);
        if self.preconditioned {
            self.plays.advance(&mut plays, self.envelope.value(self.input_range.max()));
            self.plays.advance(&mut plays, lowest);
        }
        HysteresisState::of_plays(plays)
    }

    /// Equation (16).
    fn step(&self, state: &mut HysteresisState<T, N>, x: T) -> Result<T, InputError> {
        let v = self.envelope.value(self.input_range.extrapolated(finite_input(x)?));
        Ok(self.dead_zones.value(self.plays.advance(&mut state.plays, v)))
    }
}

impl<T: Real, E: Envelope<T> + Clone, const N: usize, const M: usize> Invertible<T, N>
    for Cascade<T, E, N, M>
{
    type Inverse = InverseCascade<T, E, N, M>;

    fn inverse(&self) -> Result<Self::Inverse, ParameterError> {
        let plays = self.plays.inverse()?;
        let forward = self.counting_from_flat(plays.slope_of_all());
        let v = |x| forward.envelope.value(x);
        let (low, high) = (v(self.input_range.min()), v(self.input_range.max()));
        let range = |low, high| Range::try_new(low, high, "envelope range", "");
        // Roundings of the plays must not lead out of the envelope's values, near the ends of which
        // its own loses as much.
        let (least, most) = forward.envelope.values();
        let rounding = plays.rounding(&range(low, high)?);
        let inner_range = range(low.at_least(least + rounding), high.at_most(most - rounding))?;
        Ok(InverseCascade { inner_range, plays, forward })
    }
}

impl<T: Real, E: Envelope<T> + Clone, const N: usize, const M: usize> Cascade<T, E, N, M> {
    /// The same model, but v counts from between the ends of its range, the nearer to an end the
    /// flatter the envelope is there. `slope`: of v over u where all plays are driven.
    fn counting_from_flat(&self, slope: T) -> Self {
        let (low, high) =
            (self.envelope.value(self.input_range.min()), self.envelope.value(self.input_range.max()));
        let part = T::from_f64(1.0 / 64.0) * (high - low);
        let input = |v| self.envelope.inverse(v).to_f64();
        let (at_low, at_high) = (input(low + part) - input(low), input(high) - input(high - part));
        let v = (at_low * low.to_f64() + at_high * high.to_f64()) / (at_low + at_high);
        // Exactly a T: what breaks the dead zones have near it lose nothing.
        let u = T::from_f64(v / slope.to_f64()).to_f64();
        let v = u * slope.to_f64();
        match self.envelope.counted_from(v).filter(|_| v.is_finite()) {
            Some(envelope) => {
                Self { envelope, dead_zones: self.dead_zones.counted_from(u), origin: (v, u), ..self.clone() }
            }
            None => self.clone(),
        }
    }
}

/// The inverse of a [`Cascade`].
///
/// ```
/// use model_core::{Hysteresis, InverseHysteresis, Invertible, Mgpi};
///
/// let muscle = Mgpi::try_new(&model_core::paper::mgpi()?)?;
/// let inverse = muscle.inverse()?;
/// let (mut there, mut back) = (muscle.rest_state(), inverse.rest_state());
/// for pressure in [1.0, 5.0, 2.0, 4.0] {
///     let contraction = muscle.step(&mut there, pressure)?;
///     assert!((inverse.step(&mut back, contraction)? - pressure).abs() < 1e-9);
/// }
/// # Ok::<(), Box<dyn core::error::Error>>(())
/// ```
#[derive(Clone, Debug, PartialEq)]
#[repr(C)] // In this order what every sample needs is within the reach of a load, 1020 bytes: else each costs an addition.
pub struct InverseCascade<T, E, const N: usize, const M: usize> {
    /// The inverse of the forward model's plays.
    plays: PlayBank<T, N>,
    /// Of the plays' moves: the image of the input range under the envelope.
    inner_range: Range<T>,
    /// The model that this is the inverse of, but for where v and u count from.
    forward: Cascade<T, E, N, M>,
}

impl<T: Real, E: Envelope<T>, const N: usize, const M: usize> InverseCascade<T, E, N, M> {
    /// The inputs that it answers with. Input unit.
    pub fn input_range(&self) -> &Range<T> {
        &self.forward.input_range
    }

    /// The model that this is the inverse of. Its states are its own, for its v and u count from
    /// elsewhere.
    pub(crate) fn forward(&self) -> &Cascade<T, E, N, M> {
        &self.forward
    }

    /// The inverse of [`Cascade::step_wider`], on a state of the model: moves it to the input that
    /// brings the output to `y`, or as near as the range allows. Answers the input and the output.
    #[inline(never)]
    pub(crate) fn reach_wider(&self, state: &mut HysteresisState<T, N>, y: T, times: T) -> (T, T) {
        let Cascade { envelope, plays, dead_zones, input_range, .. } = &self.forward;
        let inner = &self.inner_range;
        let v = plays.input_wider(&state.plays, dead_zones.inverse(y), times);
        let (x, v) = if v <= inner.min() {
            (input_range.min(), inner.min())
        } else if v >= inner.max() {
            (input_range.max(), inner.max())
        } else {
            (input_range.limit(envelope.inverse(v)), v)
        };
        (x, self.forward.step_wider(state, v, times))
    }

    /// The step for an output that is known to be finite.
    #[inline(always)]
    pub(crate) fn answer(&self, state: &mut HysteresisState<T, N>, y: T) -> T {
        let u = self.forward.dead_zones.inverse(y);
        let inside = |v| self.forward.input_range.limit(self.forward.envelope.inverse_inside(v));
        let at_end = |rises| self.end(rises);
        let many = |plays: &mut TurningPoints<T, N>| self.answer_of_many(plays, u);
        self.plays.advance_inside(&mut state.plays, u, &self.inner_range, inside, at_end, many)
    }

    /// The answer of many plays. Not inlined, to avoid register spills in the path of few plays.
    #[inline(never)]
    fn answer_of_many(&self, plays: &mut TurningPoints<T, N>, u: T) -> T {
        match self.plays.advance_many_inside(plays, u, &self.inner_range) {
            Reached::Inside(v) => self.forward.input_range.limit(self.forward.envelope.inverse(v)),
            Reached::End(v) => self.end(v == self.inner_range.max()),
        }
    }

    /// An end of the input range: the end itself, whatever the envelope's rounding.
    #[inline(always)]
    fn end(&self, upper: bool) -> T {
        if upper { self.forward.input_range.max() } else { self.forward.input_range.min() }
    }
}

impl<T: Real, E: Envelope<T>, const N: usize, const M: usize> InverseHysteresis<T, N>
    for InverseCascade<T, E, N, M>
{
    fn state_of(&self, state: &HysteresisState<T, N>) -> HysteresisState<T, N> {
        let (v, u) = self.forward.origin;
        HysteresisState::of_plays(self.forward.plays.inverse_state(&state.plays.counted_from(v, u)))
    }

    fn rest_state(&self) -> HysteresisState<T, N> {
        let Cascade { plays, .. } = &self.forward;
        HysteresisState::of_plays(plays.inverse_state(&self.forward.rest_state().plays))
    }

    fn last_output(&self, state: &HysteresisState<T, N>) -> T {
        self.forward.dead_zones.value(state.plays.input())
    }

    /// Equation (17).
    #[inline(always)]
    fn step(&self, state: &mut HysteresisState<T, N>, y: T) -> Result<T, InputError> {
        Ok(self.answer(state, finite_input(y)?))
    }
}
