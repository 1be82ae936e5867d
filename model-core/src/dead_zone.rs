//! Weighted one-sided dead zones, y = Σ wⱼ S(u, dⱼ) + offset, and their inverse.
//!
//! S(u, 0) = u and S(u, d) = max(u - d, 0) for d > 0, equations (12) to (14). With d₀ = 0 the sum is a
//! piecewise-linear curve through the knots dⱼ whose slope on [dⱼ, dⱼ₊₁] is the partial sum w₀ + … + wⱼ; both
//! directions are evaluated in that form, which costs one multiplication instead of one per dead zone and
//! rounds less (at n = 10 in f32 by an order of magnitude). The weights of equation (20) are those of the
//! inverse curve in the sum form; tests hold the two against each other.
//!
//! # Beyond the paper
//! `offset` is where the curve starts: a recording whose contraction is not zero at rest needs it. The
//! paper's model has 0.
//!
//! # Validity
//! Thresholds from exactly 0 strictly upward, partial sums all positive: then the curve is strictly
//! increasing and its inverse exact. (The paper's equation (23) does not ask for it; without it a
//! fit can be non-invertible.)

use heapless::Vec;

use crate::error::{Check, ParameterError, Requirement};
use crate::real::Real;

/// Raw parameters of at most `M` dead zones.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(
    feature = "serde",
    derive(serde::Serialize, serde::Deserialize),
    serde(bound = "T: serde::Serialize + serde::de::DeserializeOwned")
)]
pub struct DeadZoneParameters<T, const M: usize> {
    /// Thresholds d: 0 first, strictly increasing. Unit: that of u (1).
    pub thresholds: Vec<T, M>,
    /// Weights w, as many as thresholds. Unit: output unit.
    pub weights: Vec<T, M>,
    /// Output at u = 0. Unit: output unit.
    pub offset: T,
}

#[derive(Clone, Copy, Debug, PartialEq)]
struct Segment<T> {
    /// Where it starts, along u.
    threshold: T,
    /// The output there.
    output: T,
    slope: T,
    reciprocal_slope: T,
}

/// A validated dead-zone stage of at most `M` dead zones, at least one.
#[derive(Clone, Debug, PartialEq)]
pub struct DeadZones<T, const M: usize> {
    first: Segment<T>,
    /// The segments after the first: at most M - 1.
    rest: Vec<Segment<T>, M>,
}

impl<T: Real, const M: usize> DeadZones<T, M> {
    /// # Errors
    /// No dead zone; lists of different length; a first threshold other than 0; thresholds that do not
    /// increase; a partial sum of the weights that is not above 0; anything not finite.
    pub fn try_new(parameters: &DeadZoneParameters<T, M>) -> Result<Self, ParameterError> {
        let DeadZoneParameters { thresholds, weights, offset } = parameters;
        if weights.len() != thresholds.len() {
            let requirement = Requirement::Exactly(thresholds.len() as f64);
            return Err(Check::new("number of dead-zone weights", "").length(weights.len(), requirement));
        }
        let mut pairs = thresholds.iter().copied().zip(weights.iter().copied());
        let Some((threshold, weight)) = pairs.next() else {
            return Err(Check::new("dead zones", "").length(0, Requirement::AtLeast(1.0)));
        };
        if threshold != T::ZERO {
            let check = Check::at("dead-zone thresholds", 0, "");
            return Err(check.error(threshold.to_f64(), Requirement::Exactly(0.0)));
        }
        let output = Check::new("offset", "output unit").finite(*offset)?;
        let first = Segment::try_new(0, threshold, output, weight)?;
        let mut zones = Self { first, rest: Vec::new() };
        let mut last = first;
        for (i, (threshold, weight)) in pairs.enumerate() {
            let i = i + 1;
            Check::at("dead-zone thresholds", i, "").above(threshold, last.threshold)?;
            Check::at("dead-zone weights", i, "output unit").finite(weight)?;
            last = Segment::try_new(i, threshold, last.output_at(threshold), last.slope + weight)?;
            // One fewer than a list of capacity M holds: it fits.
            let _ = zones.rest.push(last);
        }
        Ok(zones)
    }

    /// The smallest slope of the curve, the distance from being non-invertible. Unit: output unit.
    pub fn smallest_slope(&self) -> T {
        self.segments().fold(self.first.slope, |least, s| if s.slope < least { s.slope } else { least })
    }

    /// y(u). Unit: output unit. Below 0 the first segment goes on, beyond the last knot the last one.
    pub fn value(&self, u: T) -> T {
        self.segment(|segment| segment.threshold <= u).output_at(u)
    }

    /// u(y): exact inverse of [`value`](Self::value) over all outputs.
    pub fn inverse(&self, y: T) -> T {
        let segment = self.segment(|segment| segment.output <= y);
        segment.threshold + (y - segment.output) * segment.reciprocal_slope
    }

    fn segments(&self) -> impl Iterator<Item = &Segment<T>> {
        core::iter::once(&self.first).chain(&self.rest)
    }

    /// The last segment that has started; the first where none has.
    fn segment(&self, started: impl Fn(&Segment<T>) -> bool) -> &Segment<T> {
        self.rest.iter().take_while(|segment| started(segment)).last().unwrap_or(&self.first)
    }
}

impl<T: Real> Segment<T> {
    fn try_new(index: usize, threshold: T, output: T, slope: T) -> Result<Self, ParameterError> {
        let check = Check::at("partial sums of dead-zone weights", index, "output unit");
        let slope = check.above(slope, T::ZERO)?;
        let reciprocal_slope =
            Check::at("reciprocal partial sums of dead-zone weights", index, "1/output unit")
                .finite(T::ONE / slope)?;
        Ok(Self { threshold, output, slope, reciprocal_slope })
    }

    fn output_at(&self, u: T) -> T {
        self.output + self.slope * (u - self.threshold)
    }
}
