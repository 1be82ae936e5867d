//! The modified generalized Prandtl-Ishlinskii model (MGPI), equation (16): envelope, plays, dead zones.
//!
//! The envelope is the paper's tanh ([`Mgpi`]) or a piecewise-linear one ([`PiecewiseMgpi`]). The inverse is
//! that of the [`crate::cascade`].
//!
//! # Accuracy
//! Round trip of Tables 1 and 2 over triangles from 0 to 6 bar: below 1e-12 bar in `f64`, 5e-5 bar in `f32`
//! (`cargo test -p model-core round_trip`).

use crate::cascade::{Cascade, InverseCascade};
use crate::dead_zone::{DeadZoneParameters, DeadZones};
use crate::envelope::{PiecewiseLinear, PiecewiseLinearParameters, TanhEnvelope, TanhParameters};
use crate::error::{Check, ParameterError, Requirement};
use crate::play::{PlayBank, PlayParameters};
use crate::range::Range;
use crate::real::Real;

/// An MGPI model with a tanh envelope.
pub type Mgpi<T, const N: usize, const M: usize> = Cascade<T, TanhEnvelope<T>, N, M>;
/// Its inverse.
pub type InverseMgpi<T, const N: usize, const M: usize> = InverseCascade<T, TanhEnvelope<T>, N, M>;
/// An MGPI model with a piecewise-linear envelope of at most `K` knots.
pub type PiecewiseMgpi<T, const N: usize, const M: usize, const K: usize> =
    Cascade<T, PiecewiseLinear<T, K>, N, M>;

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

impl<T: Real, const N: usize, const M: usize> Mgpi<T, N, M> {
    /// # Errors
    /// The first parameter that no invertible model can be made of.
    pub fn try_new(parameters: &MgpiParameters<T, N, M>) -> Result<Self, ParameterError> {
        Ok(Self::new(
            TanhEnvelope::try_new(parameters.envelope)?,
            PlayBank::try_new(&parameters.plays)?,
            DeadZones::try_new(&parameters.dead_zones)?,
            Range::try_new(parameters.input_min, parameters.input_max, "input range", "input unit")?,
        ))
    }
}

impl<T: Real, const N: usize, const M: usize, const K: usize> PiecewiseMgpi<T, N, M, K> {
    /// # Errors
    /// The first parameter that no invertible model can be made of.
    pub fn try_new(
        envelope: &PiecewiseLinearParameters<T, K>,
        plays: &PlayParameters<T, N>,
        dead_zones: &DeadZoneParameters<T, M>,
        input_range: Range<T>,
    ) -> Result<Self, ParameterError> {
        Ok(Self::new(
            PiecewiseLinear::try_new(envelope)?,
            PlayBank::try_new(plays)?,
            DeadZones::try_new(dead_zones)?,
            input_range,
        ))
    }
}
