//! Weighted dead zones, y = Σ wⱼ S(u, dⱼ) + offset, and their inverse.
//!
//! S(u, 0) = u, S(u, d) = max(u - d, 0) for d > 0 and min(u - d, 0) for d < 0, equations (12) to
//! (14). The sum is a piecewise-linear curve through the knots dⱼ whose slope beyond a knot, seen
//! from 0, is the partial sum of the weights up to it, each side by itself. Both directions are
//! evaluated in that form, which costs one multiplication instead of one per dead zone and rounds
//! less (at n = 10 in f32 by an order of magnitude). The weights of equation (20) are those of the
//! inverse curve in the sum form; tests hold the two against each other.
//!
//! The MGPI model has thresholds of 0 and above, Kuhnen's modified model has them on both sides
//! of 0.
//!
//! # Beyond the paper
//! `offset` is where the curve starts: a recording whose contraction is not zero at rest needs it.
//! The paper's model has 0.
//!
//! # Validity
//! Thresholds strictly increasing, one of them exactly 0, and the partial sums of each side, from 0
//! outward, all positive: then the curve is strictly increasing and its inverse exact. (The paper's
//! equation (23) does not ask for it; without it a fit can be non-invertible.)

use crate::convert;
use crate::curve::MonotoneCurve;
use crate::error::{Check, ParameterError, Requirement};
use crate::list::List;
use crate::real::Real;

/// Raw parameters of at most `M` dead zones.
///
/// ```
/// use model_core::List;
/// use model_core::dead_zone::{DeadZoneParameters, DeadZones};
///
/// let list = |numbers: [f64; 2]| List::<f64, 2>::from_iter(numbers);
/// let mut zones = DeadZoneParameters { thresholds: list([0.0, 1.0]), weights: list([20.0, -5.0]), offset: 0.0 };
/// assert_eq!(DeadZones::try_new(&zones)?.smallest_slope(), 15.0); // flatter beyond 1, but rising
///
/// zones.weights = list([20.0, -20.0]);
/// assert!(DeadZones::try_new(&zones).is_err()); // level beyond 1: no inverse
/// # Ok::<(), Box<dyn core::error::Error>>(())
/// ```
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(
    feature = "serde",
    derive(serde::Serialize, serde::Deserialize),
    serde(bound = "T: Real + serde::Serialize + serde::de::DeserializeOwned")
)]
pub struct DeadZoneParameters<T, const M: usize> {
    /// Thresholds d: strictly increasing, one of them 0. Unit: that of u (1).
    pub thresholds: List<T, M>,
    /// Weights w, as many as thresholds. Unit: output unit.
    pub weights: List<T, M>,
    /// Output at u = 0. Unit: output unit.
    pub offset: T,
}

impl<T: Real, const M: usize> DeadZoneParameters<T, M> {
    /// A straight line: a single dead zone, of threshold 0. Gain and offset: output unit.
    ///
    /// # Errors
    /// The capacity `M` is 0.
    pub fn line(gain: T, offset: T) -> Result<Self, ParameterError> {
        let list = |value| {
            let mut list = List::new();
            let too_many = |_| Check::new("dead zones", "").length(1, Requirement::AtMost(M as f64));
            list.push(value).map_err(too_many).map(|()| list)
        };
        Ok(Self { thresholds: list(T::ZERO)?, weights: list(gain)?, offset })
    }

    /// The same parameters in another number type or capacity.
    ///
    /// # Errors
    /// The other capacity is too small.
    pub fn convert<U: Real, const M2: usize>(&self) -> Result<DeadZoneParameters<U, M2>, ParameterError> {
        Ok(DeadZoneParameters {
            thresholds: convert::list("dead zones", &self.thresholds)?,
            weights: convert::list("dead zones", &self.weights)?,
            offset: convert::number(self.offset),
        })
    }
}

/// A validated dead-zone stage of at most `M` dead zones, at least one.
///
/// ```
/// use model_core::dead_zone::{DeadZoneParameters, DeadZones};
///
/// let line = DeadZones::try_new(&DeadZoneParameters::<f64, 1>::line(20.0, 5.0)?)?;
/// assert_eq!(line.value(2.0), 45.0);
/// assert_eq!(line.inverse(45.0), 2.0);
/// # Ok::<(), Box<dyn core::error::Error>>(())
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct DeadZones<T, const M: usize> {
    curve: MonotoneCurve<T, M>,
}

const SUMS: &str = "partial sums of dead-zone weights";

impl<T: Real, const M: usize> DeadZones<T, M> {
    /// # Errors
    /// No dead zone; lists of different length; no threshold of 0; thresholds that do not increase;
    /// a partial sum of the weights that is not above 0; anything not finite.
    pub fn try_new(parameters: &DeadZoneParameters<T, M>) -> Result<Self, ParameterError> {
        let DeadZoneParameters { thresholds, weights, offset } = parameters;
        if weights.len() != thresholds.len() {
            let requirement = Requirement::Exactly(thresholds.len() as f64);
            return Err(Check::new("number of dead-zone weights", "").length(weights.len(), requirement));
        }
        if thresholds.is_empty() {
            return Err(Check::new("dead zones", "").length(0, Requirement::AtLeast(1.0)));
        }
        for (i, (&weight, &threshold)) in weights.iter().zip(thresholds).enumerate() {
            Check::at("dead-zone weights", i, "output unit").finite(weight)?;
            let check = Check::at("dead-zone thresholds", i, "");
            match thresholds.get(i.wrapping_sub(1)) {
                Some(&last) => check.above(threshold, last)?,
                None => check.finite(threshold)?,
            };
        }
        let offset = Check::new("offset", "output unit").finite(*offset)?;
        let Some(zero) = thresholds.iter().position(|threshold| *threshold == T::ZERO) else {
            let least = thresholds.first().map_or(0.0, |threshold| threshold.to_f64());
            return Err(Check::at("dead-zone thresholds", 0, "").error(least, Requirement::Exactly(0.0)));
        };
        let zone = |i: usize| Some((i, *thresholds.get(i)?, *weights.get(i)?));

        // From 0 outward to the left: each knot with its output and the slopes on its two sides.
        let central = zone(zero).map_or(T::ZERO, |(_, _, weight)| weight);
        let (mut point, mut slope) = ((T::ZERO, offset), central);
        let mut left: List<(usize, (T, T), T), M> = List::new();
        for (i, threshold, weight) in (0..zero).rev().filter_map(zone) {
            point = (threshold, point.1 + slope * (threshold - point.0));
            // Fewer than M: it fits.
            let _ = left.push((i, point, slope));
            slope += weight;
        }
        let check = |i| Check::at(SUMS, i, "output unit");
        let mut curve = MonotoneCurve::line(point, slope, check(0))?;
        for &(i, point, slope) in left.iter().rev() {
            curve.bend(point, slope, check(i + 1))?;
        }

        (point, slope) = ((T::ZERO, offset), central);
        for (i, threshold, weight) in (zero + 1..thresholds.len()).filter_map(zone) {
            point = (threshold, point.1 + slope * (threshold - point.0));
            slope += weight;
            curve.bend(point, slope, check(i))?;
        }
        Ok(Self { curve })
    }

    /// The smallest slope of the curve, the distance from being non-invertible. Unit: output unit.
    pub fn smallest_slope(&self) -> T {
        self.curve.smallest_slope()
    }

    /// The same where u counts from an origin on.
    pub(crate) fn counted_from(&self, u: f64) -> Self {
        Self { curve: self.curve.counted_from(u, 0.0) }
    }

    /// y(u). Unit: output unit. The outermost segments go on without end.
    pub fn value(&self, u: T) -> T {
        self.curve.value(u)
    }

    /// u(y): exact inverse of [`value`](Self::value) over all outputs.
    #[inline(always)]
    pub fn inverse(&self, y: T) -> T {
        self.curve.inverse(y)
    }
}
