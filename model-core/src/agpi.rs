//! The asymmetric generalized Prandtl-Ishlinskii model (AGPI): two envelopes, plays and a gain.
//!
//! ```text
//! forward   x ── γ_r rising, γ_l falling ──▶ v ── plays ──▶ u ── gain, offset ──▶ y
//! inverse   y ── gain⁻¹ ──▶ u ── plays⁻¹ ──▶ v ── γ_r⁻¹ rising, γ_l⁻¹ falling ──▶ x, limited to the range
//! ```
//!
//! Equations (2), (6) to (8). The input drives the plays along γ_r while it rises and along γ_l ≥
//! γ_r while it falls; an input that rests keeps its branch, so that the direction is part of the
//! state.
//!
//! # What holds, and what does not
//! The direct term q γ jumps from one envelope to the other at each reversal (the paper is silent
//! about it): when the input starts to fall, the output first rises by gain q (γ_l - γ_r). So the
//! output is monotone in the input over each run in one direction, not over a reversal, and near a
//! reversal two inputs have the same output. The inverse answers each output with an input that
//! truly has it: forward of inverse is exact from every state, inverse of forward is exact where
//! the output does not jump back. An output that only a jump in the wrong direction could come near
//! is answered by the last input.
//!
//! # Validity
//! γ_l ≥ γ_r over the input range, held at 65 inputs of it; between them the inverse still never
//! moves its input against the output.

use crate::convert;
use crate::envelope::{AnyEnvelope, Envelope, EnvelopeParameters};
use crate::error::{Check, InputError, ParameterError, finite_input};
use crate::hysteresis::{Hysteresis, HysteresisState, InverseHysteresis, Invertible, Sample};
use crate::play::{PlayBank, PlayParameters, PlayState};
use crate::range::Range;
use crate::real::Real;

/// How many pieces the input range is cut into to compare the envelopes.
const PIECES: u8 = 64;

/// Raw parameters of an AGPI model with at most `N` plays.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(
    feature = "serde",
    derive(serde::Serialize, serde::Deserialize),
    serde(bound = "T: Real + serde::Serialize + serde::de::DeserializeOwned")
)]
pub struct AgpiParameters<T, const N: usize> {
    /// The envelope γ_r of rising inputs.
    pub rising: EnvelopeParameters<T>,
    /// The envelope γ_l of falling inputs, nowhere below γ_r.
    pub falling: EnvelopeParameters<T>,
    /// The bank of plays.
    pub plays: PlayParameters<T, N>,
    /// Output over u. Unit: output unit, above 0.
    pub gain: T,
    /// Output at u = 0. Unit: output unit.
    pub offset: T,
    /// Lower end of the inputs that the model is valid for; the muscle's state of rest. Input unit.
    pub input_min: T,
    /// Upper end of the inputs that the model is valid for. Input unit.
    pub input_max: T,
    /// Whether the muscle has been through its whole range before, as most have: it is then at rest
    /// as after a rise to the upper end of the inputs and a return to the lower one. Else it comes
    /// from rest at 0.
    pub preconditioned: bool,
}

impl<T: Real, const N: usize> AgpiParameters<T, N> {
    /// The same parameters in another number type or capacity.
    ///
    /// # Errors
    /// The other capacity is too small.
    pub fn convert<U: Real, const N2: usize>(&self) -> Result<AgpiParameters<U, N2>, ParameterError> {
        Ok(AgpiParameters {
            rising: self.rising.convert()?,
            falling: self.falling.convert()?,
            plays: self.plays.convert()?,
            gain: convert::number(self.gain),
            offset: convert::number(self.offset),
            input_min: convert::number(self.input_min),
            input_max: convert::number(self.input_max),
            preconditioned: self.preconditioned,
        })
    }
}

/// A validated AGPI model with at most `N` plays.
///
/// ```
/// use model_core::agpi::{Agpi, AgpiParameters};
/// use model_core::envelope::{EnvelopeParameters::Tanh, TanhParameters};
/// use model_core::{Hysteresis, paper};
///
/// // Falling inputs see a higher envelope.
/// let falling = TanhParameters { c3: paper::ENVELOPE.c3 + 0.2, ..paper::ENVELOPE };
/// let muscle = Agpi::try_new(&AgpiParameters {
///     rising: Tanh(paper::ENVELOPE),
///     falling: Tanh(falling),
///     plays: paper::mgpi()?.plays,
///     gain: 50.0,
///     offset: 0.0,
///     input_min: 0.0,
///     input_max: 6.0,
///     preconditioned: false,
/// })?;
/// let mut state = muscle.rest_state();
/// let rising = muscle.step(&mut state, 3.0)?;
/// muscle.step(&mut state, 6.0)?;
/// assert!(muscle.step(&mut state, 3.0)? > rising);
/// # Ok::<(), Box<dyn core::error::Error>>(())
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct Agpi<T, const N: usize> {
    rising: AnyEnvelope<T>,
    falling: AnyEnvelope<T>,
    plays: PlayBank<T, N>,
    gain: T,
    reciprocal_gain: T,
    offset: T,
    input_range: Range<T>,
    preconditioned: bool,
}

impl<T: Real, const N: usize> Agpi<T, N> {
    /// # Errors
    /// The first parameter that no invertible model can be made of.
    pub fn try_new(parameters: &AgpiParameters<T, N>) -> Result<Self, ParameterError> {
        let AgpiParameters { rising, falling, plays, gain, offset, input_min, input_max, preconditioned } =
            parameters;
        let gain = Check::new("gain", "output unit").above(*gain, T::ZERO)?;
        let agpi = Self {
            rising: AnyEnvelope::try_new(rising)?,
            falling: AnyEnvelope::try_new(falling)?,
            plays: PlayBank::try_new(plays)?,
            gain,
            reciprocal_gain: Check::new("1/gain", "1/output unit").finite(T::ONE / gain)?,
            offset: Check::new("offset", "output unit").finite(*offset)?,
            input_range: Range::try_new(*input_min, *input_max, "input range", "input unit")?,
            preconditioned: *preconditioned,
        };
        let piece = (*input_max - *input_min) / T::from_f64(f64::from(PIECES));
        for i in 0..=PIECES {
            let x = *input_min + T::from_f64(f64::from(i)) * piece;
            let (rising, falling) = (agpi.rising.value(x), agpi.falling.value(x));
            let rounding = T::from_f64(8.0) * T::EPSILON * (rising.abs() + falling.abs());
            let check = Check::at("falling envelope at 65 inputs of the range", i.into(), "");
            check.at_least(falling + rounding, rising)?;
        }
        Ok(agpi)
    }

    /// The bank of plays.
    pub fn plays(&self) -> &PlayBank<T, N> {
        &self.plays
    }

    /// Output over u. Unit: output unit.
    pub fn gain(&self) -> T {
        self.gain
    }

    /// Least slope of the output over the input within a run in one direction. Unit: output
    /// unit/input unit.
    pub(crate) fn least_slope(&self) -> T {
        let (rising, falling) =
            (self.rising.least_slope(&self.input_range), self.falling.least_slope(&self.input_range));
        let envelope = if rising < falling { rising } else { falling };
        self.gain * self.plays.smallest_slope() * envelope
    }

    fn envelope(&self, rising: bool) -> &AnyEnvelope<T> {
        if rising { &self.rising } else { &self.falling }
    }

    fn output(&self, u: T) -> T {
        self.gain * u + self.offset
    }
}

impl<T: Real, const N: usize> Hysteresis<T, N> for Agpi<T, N> {
    fn input_range(&self) -> &Range<T> {
        &self.input_range
    }

    /// Equation (1) with w = 0, on the rising branch; or on the falling one, if the muscle has been
    /// up.
    fn rest_state(&self) -> HysteresisState<T, N> {
        let x = self.input_range.min();
        let mut plays = self.plays.rest_state(T::ZERO);
        self.plays.advance_toward(&mut plays, self.falling.value(x), false);
        let u = self.plays.advance_toward(&mut plays, self.rising.value(x), true);
        if !self.preconditioned {
            return HysteresisState { plays, last: Sample { x, y: self.output(u), rising: true } };
        }
        self.plays.advance_toward(&mut plays, self.rising.value(self.input_range.max()), true);
        let u = self.plays.advance_toward(&mut plays, self.falling.value(x), false);
        HysteresisState { plays, last: Sample { x, y: self.output(u), rising: false } }
    }

    fn step(&self, state: &mut HysteresisState<T, N>, x: T) -> Result<T, InputError> {
        let x = finite_input(x)?;
        if x != state.last.x {
            let rising = x > state.last.x;
            let v = self.envelope(rising).value(x);
            let y = self.output(self.plays.advance_toward(&mut state.plays, v, rising));
            state.last = Sample { x, y, rising };
        }
        Ok(state.last.y)
    }
}

impl<T: Real, const N: usize> Invertible<T, N> for Agpi<T, N> {
    type Inverse = InverseAgpi<T, N>;

    fn inverse(&self) -> Result<Self::Inverse, ParameterError> {
        let (low, high) = (self.input_range.min(), self.input_range.max());
        let (lowest, highest) = (self.falling.value(low), self.rising.value(high));
        Ok(InverseAgpi {
            plays: self.plays.inverse()?,
            reach: T::from_f64(2.0)
                * self.plays.largest_slope()
                * (self.falling.value(high) - self.rising.value(low)),
            inner_range: Range::try_new(lowest, highest, "envelope range", "")?,
            forward: self.clone(),
        })
    }
}

/// The inverse of an [`Agpi`].
#[derive(Clone, Debug, PartialEq)]
pub struct InverseAgpi<T, const N: usize> {
    forward: Agpi<T, N>,
    /// The inverse of the forward model's plays.
    plays: PlayBank<T, N>,
    /// From the falling envelope at the lower end of the input range to the rising one at the upper
    /// end.
    inner_range: Range<T>,
    /// A way of u that leads past each end of the range from everywhere.
    reach: T,
}

impl<T: Real, const N: usize> InverseAgpi<T, N> {
    /// u at the output `y`.
    pub(crate) fn inner(&self, y: T) -> T {
        (y - self.forward.offset) * self.forward.reciprocal_gain
    }

    /// The output that the plays of the inverse have reached.
    pub(crate) fn reached(&self, plays: &PlayState<T, N>) -> T {
        self.forward.output(plays.input())
    }

    /// Moves the plays of the inverse to `u` in a direction that is known, and answers the input.
    pub(crate) fn drive(&self, plays: &mut PlayState<T, N>, last_x: T, u: T, rising: bool) -> T {
        let v = self.plays.advance_within(plays, u, rising, &self.inner_range);
        let (ends, inner_ends) = (&self.forward.input_range, &self.inner_range);
        // At an end the answer is that end itself, whatever the envelope's rounding.
        if rising && v >= inner_ends.max() {
            ends.max()
        } else if !rising && v <= inner_ends.min() {
            ends.min()
        } else {
            let x = ends.limit(self.forward.envelope(rising).inverse(v));
            if (x > last_x) == rising { x } else { last_x }
        }
    }

    /// Input and output at the end of the range in a direction.
    pub(crate) fn end(&self, plays: &PlayState<T, N>, rising: bool) -> (T, T) {
        let (x, far) = if rising {
            (self.forward.input_range.max(), plays.input() + self.reach)
        } else {
            (self.forward.input_range.min(), plays.input() - self.reach)
        };
        let mut end = plays.clone();
        self.drive(&mut end, x, far, rising);
        (x, self.reached(&end))
    }
}

impl<T: Real, const N: usize> InverseHysteresis<T, N> for InverseAgpi<T, N> {
    fn state_of(&self, state: &HysteresisState<T, N>) -> HysteresisState<T, N> {
        HysteresisState { plays: self.forward.plays.inverse_state(&state.plays), last: state.last }
    }

    fn rest_state(&self) -> HysteresisState<T, N> {
        self.state_of(&self.forward.rest_state())
    }

    fn last_output(&self, state: &HysteresisState<T, N>) -> T {
        state.last.y
    }

    /// Not inlined, to avoid register spills of the cascade where the model is chosen at run time.
    #[inline(never)]
    fn step(&self, state: &mut HysteresisState<T, N>, y: T) -> Result<T, InputError> {
        let y = finite_input(y)?;
        let (u, last, before) = (self.inner(y), state.last, state.plays.input());
        let rising = u > before;
        if !is_rounding(u, before)
            && (rising == last.rising || leads_on(&last, self.end(&state.plays, rising)))
        {
            let x = self.drive(&mut state.plays, last.x, u, rising);
            state.last = Sample { x, y: self.reached(&state.plays), rising };
        }
        Ok(state.last.x)
    }
}

/// Whether two values differ by a few roundings only: an output that rests must not be taken for a
/// reversal.
pub(crate) fn is_rounding<T: Real>(one: T, other: T) -> bool {
    (one - other).abs() <= T::from_f64(8.0) * T::EPSILON * (one.abs() + other.abs())
}

/// Whether the way to an end of the range leads on from the last output, and not, by the jump at
/// the reversal, back from it.
pub(crate) fn leads_on<T: Real>(last: &Sample<T>, (x, y): (T, T)) -> bool {
    if x > last.x { y > last.y } else { y < last.y }
}
