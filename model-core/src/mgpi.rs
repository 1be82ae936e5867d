//! The modified generalized Prandtl-Ishlinskii model, equation (16), and its analytical inverse, (17).
//!
//! ```text
//! forward   x ── γ ──▶ v ── plays ──▶ u ── dead zones ──▶ y
//! inverse   y ── dead zones⁻¹ ──▶ u ── plays⁻¹ ──▶ v ── γ⁻¹ ──▶ x, limited to the input range
//! ```
//!
//! # The state of the inverse
//! The inverse remembers the history that it has commanded. An output that no input of the range reaches
//! is answered with the end of the range, and the inverse then remembers that end, not the impossible
//! demand: the next reachable output is inverted as exactly as if nothing had happened.
//!
//! # Accuracy
//! Round trip of Tables 1 and 2 over triangles from 0 to 6 bar: below 1e-12 bar in `f64`, 5e-5 bar in `f32`
//! (`cargo test -p model-core round_trip`).

use crate::dead_zone::{DeadZoneParameters, DeadZones};
use crate::envelope::{TanhEnvelope, TanhParameters};
use crate::error::{Check, InputError, ParameterError, Requirement, finite_input};
use crate::play::{PlayBank, PlayParameters, PlayState};
use crate::range::Range;
use crate::real::Real;

/// Raw parameters of an MGPI model with at most `N` plays and `M` dead zones.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(
    feature = "serde",
    derive(serde::Serialize, serde::Deserialize),
    serde(bound = "T: serde::Serialize + serde::de::DeserializeOwned")
)]
pub struct MgpiParameters<T, const N: usize, const M: usize> {
    /// The envelope γ.
    pub envelope: TanhParameters<T>,
    /// The bank of plays.
    pub plays: PlayParameters<T, N>,
    /// The dead-zone stage.
    pub dead_zones: DeadZoneParameters<T, M>,
    /// Lower end of the inputs that the model is valid for; the muscle's state of rest. Input unit.
    pub input_min: T,
    /// Upper end of the inputs that the model is valid for. Input unit.
    pub input_max: T,
}

impl<T: Real, const N: usize, const M: usize> MgpiParameters<T, N, M> {
    /// The same parameters in another number type or capacity, for instance those of the board.
    ///
    /// # Errors
    /// The other capacity is too small.
    pub fn convert<U: Real, const N2: usize, const M2: usize>(
        &self,
    ) -> Result<MgpiParameters<U, N2, M2>, ParameterError> {
        let number = |value: T| U::from_f64(value.to_f64());
        let TanhParameters { c0, c1, c2, c3 } = self.envelope;
        Ok(MgpiParameters {
            envelope: TanhParameters { c0: number(c0), c1: number(c1), c2: number(c2), c3: number(c3) },
            plays: PlayParameters {
                q: number(self.plays.q),
                thresholds: convert_list("plays", &self.plays.thresholds)?,
                weights: convert_list("plays", &self.plays.weights)?,
            },
            dead_zones: DeadZoneParameters {
                thresholds: convert_list("dead zones", &self.dead_zones.thresholds)?,
                weights: convert_list("dead zones", &self.dead_zones.weights)?,
                offset: number(self.dead_zones.offset),
            },
            input_min: number(self.input_min),
            input_max: number(self.input_max),
        })
    }
}

fn convert_list<T: Real, U: Real, const N: usize>(
    parameter: &'static str,
    list: &[T],
) -> Result<heapless::Vec<U, N>, ParameterError> {
    let mut converted = heapless::Vec::new();
    for value in list {
        let too_many = |_| Check::new(parameter, "").length(list.len(), Requirement::AtMost(N as f64));
        converted.push(U::from_f64(value.to_f64())).map_err(too_many)?;
    }
    Ok(converted)
}

/// A validated, invertible MGPI model.
#[derive(Clone, Debug, PartialEq)]
pub struct Mgpi<T, const N: usize, const M: usize> {
    envelope: TanhEnvelope<T>,
    plays: PlayBank<T, N>,
    dead_zones: DeadZones<T, M>,
    input_range: Range<T>,
}

/// What an MGPI model remembers.
#[derive(Clone, Debug, PartialEq)]
pub struct MgpiState<T, const N: usize> {
    plays: PlayState<T, N>,
}

impl<T, const N: usize> MgpiState<T, N> {
    /// The state of the plays.
    pub fn plays(&self) -> &PlayState<T, N> {
        &self.plays
    }
}

impl<T: Real, const N: usize, const M: usize> Mgpi<T, N, M> {
    /// # Errors
    /// The first parameter that no invertible model can be made of.
    pub fn try_new(parameters: &MgpiParameters<T, N, M>) -> Result<Self, ParameterError> {
        Ok(Self {
            envelope: TanhEnvelope::try_new(parameters.envelope)?,
            plays: PlayBank::try_new(&parameters.plays)?,
            dead_zones: DeadZones::try_new(&parameters.dead_zones)?,
            input_range: Range::try_new(
                parameters.input_min,
                parameters.input_max,
                "input range",
                "input unit",
            )?,
        })
    }

    /// The inputs that the model is valid for. Input unit.
    pub fn input_range(&self) -> &Range<T> {
        &self.input_range
    }

    /// The outputs between rest and the upper end of the input range. Output unit.
    pub fn output_range(&self) -> (T, T) {
        let mut state = self.rest_state();
        let rest = self.move_to(&mut state, self.input_range.min());
        (rest, self.move_to(&mut state, self.input_range.max()))
    }

    /// The bank of plays.
    pub fn plays(&self) -> &PlayBank<T, N> {
        &self.plays
    }

    /// The dead-zone stage.
    pub fn dead_zones(&self) -> &DeadZones<T, M> {
        &self.dead_zones
    }

    /// The state of a muscle that came from rest to the lower end of the input range.
    pub fn rest_state(&self) -> MgpiState<T, N> {
        MgpiState { plays: self.plays.rest_state(self.envelope.value(self.input_range.min())) }
    }

    /// One sample: the output for the input `x`. Input: input unit; result: output unit. Equation (16).
    ///
    /// Inputs outside the input range are extrapolated.
    ///
    /// # Errors
    /// `x` is not finite; the state is then as it was.
    pub fn step(&self, state: &mut MgpiState<T, N>, x: T) -> Result<T, InputError> {
        Ok(self.move_to(state, finite_input(x)?))
    }

    fn move_to(&self, state: &mut MgpiState<T, N>, x: T) -> T {
        self.dead_zones.value(self.plays.step(&mut state.plays, self.envelope.value(x)))
    }

    /// The analytical inverse.
    ///
    /// # Errors
    /// A parameter of the inverse leaves the number type.
    pub fn inverse(&self) -> Result<InverseMgpi<T, N, M>, ParameterError> {
        let v = |x| self.envelope.value(x);
        Ok(InverseMgpi {
            plays: self.plays.inverse()?,
            inner_range: Range::try_new(
                v(self.input_range.min()),
                v(self.input_range.max()),
                "envelope range",
                "",
            )?,
            forward: self.clone(),
        })
    }
}

/// The inverse of an MGPI model: from a wanted output to the input that brings it about.
#[derive(Clone, Debug, PartialEq)]
pub struct InverseMgpi<T, const N: usize, const M: usize> {
    forward: Mgpi<T, N, M>,
    /// The inverse of the forward model's plays.
    plays: PlayBank<T, N>,
    /// The image of the input range under the envelope.
    inner_range: Range<T>,
}

/// What an inverse MGPI model remembers.
#[derive(Clone, Debug, PartialEq)]
pub struct InverseMgpiState<T, const N: usize> {
    plays: PlayState<T, N>,
}

impl<T: Real, const N: usize, const M: usize> InverseMgpi<T, N, M> {
    /// The model that this is the inverse of.
    pub fn forward(&self) -> &Mgpi<T, N, M> {
        &self.forward
    }

    /// The state of the inverse after the history that led the model to `state`.
    pub fn state_of(&self, state: &MgpiState<T, N>) -> InverseMgpiState<T, N> {
        InverseMgpiState { plays: self.forward.plays.inverse_state(&state.plays) }
    }

    /// The state of the inverse for a muscle at rest.
    pub fn rest_state(&self) -> InverseMgpiState<T, N> {
        self.state_of(&self.forward.rest_state())
    }

    /// One sample: the input, within the model's input range, that brings the output to `y`, or as near as
    /// the range allows. Input: output unit; result: input unit. Equation (17).
    ///
    /// # Errors
    /// `y` is not finite; the state is then as it was.
    pub fn step(&self, state: &mut InverseMgpiState<T, N>, y: T) -> Result<T, InputError> {
        let u = self.forward.dead_zones.inverse(finite_input(y)?);
        let before = state.plays.clone();
        let v = self.plays.step(&mut state.plays, u);
        if self.inner_range.contains(v) {
            return Ok(self.forward.input_range.limit(self.forward.envelope.inverse(v)));
        }
        let (ends, inner_ends) = (&self.forward.input_range, &self.inner_range);
        let (x, v) = if v > inner_ends.max() {
            (ends.max(), inner_ends.max())
        } else {
            (ends.min(), inner_ends.min())
        };
        // Remember the end of the range: the u that belongs to it, from the history before.
        let mut forward = self.plays.inverse_state(&before);
        let u = self.forward.plays.step(&mut forward, v);
        state.plays = before;
        self.plays.step(&mut state.plays, u);
        Ok(x)
    }
}
