//! A bank of weighted plays, u = q v + Σ pᵢ zᵢ, and its inverse.
//!
//! The state of play i follows the inner coordinate v at a distance of at most its threshold:
//! zᵢ ← max(v - rᵢ, min(v + rᵢ, zᵢ)), equation (7) with one envelope; the sum is equation (6).
//!
//! # The inverse
//! The inverse of such a bank is a bank again, equations (18), (19) and (21): q' = 1/q, thresholds
//! r'ᵢ = q rᵢ + Σ_{j<i} pⱼ (rᵢ - rⱼ), and weights that make the partial sums of the inverse the reciprocals of
//! those of the bank. [`PlayBank::inverse`] makes it, and [`PlayBank::inverse_state`] maps a state to the
//! one that the inverse has after the same history,
//! z'ᵢ = (q + Σ_{j≤i} pⱼ) zᵢ + Σ_{j>i} pⱼ zⱼ. The paper is silent about that; a zero in its place costs up to
//! 0.7 bar until it is wiped out.
//!
//! # Validity
//! q and every partial sum q + p₁ + … + pᵢ positive: then u is strictly increasing in v from every state,
//! and the inverse is exact. Single weights may be negative (those of an inverse are).

use heapless::Vec;

use crate::convert;
use crate::error::{Check, InputError, ParameterError, Requirement, finite_input};
use crate::range::Range;
use crate::real::Real;

/// Raw parameters of a bank of at most `N` plays.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(
    feature = "serde",
    derive(serde::Serialize, serde::Deserialize),
    serde(bound = "T: serde::Serialize + serde::de::DeserializeOwned")
)]
pub struct PlayParameters<T, const N: usize> {
    /// Weight of the direct term. Unit: 1, above 0.
    pub q: T,
    /// Thresholds r, strictly increasing and above 0. Unit: that of the inner coordinate (1).
    pub thresholds: Vec<T, N>,
    /// Weights p, as many as thresholds. Unit: 1.
    pub weights: Vec<T, N>,
}

impl<T: Real, const N: usize> PlayParameters<T, N> {
    /// Equally spaced thresholds rᵢ = α i, equation (9), with weights pᵢ = ρ exp(-τ rᵢ), equation (10), for
    /// i = 1 … `count`.
    ///
    /// # Errors
    /// `count` is above the capacity `N`.
    pub fn exponential(count: usize, q: T, rho: T, tau: T, alpha: T) -> Result<Self, ParameterError> {
        let mut parameters = Self { q, thresholds: Vec::new(), weights: Vec::new() };
        let too_many = |_| Check::new("plays", "").length(count, Requirement::AtMost(N as f64));
        for i in 1..=count {
            let threshold = alpha * T::from_f64(i as f64);
            parameters.thresholds.push(threshold).map_err(too_many)?;
            parameters.weights.push(rho * (-tau * threshold).exp()).map_err(too_many)?;
        }
        Ok(parameters)
    }

    /// The same parameters in another number type or capacity.
    ///
    /// # Errors
    /// The other capacity is too small.
    pub fn convert<U: Real, const N2: usize>(&self) -> Result<PlayParameters<U, N2>, ParameterError> {
        Ok(PlayParameters {
            q: convert::number(self.q),
            thresholds: convert::list("plays", &self.thresholds)?,
            weights: convert::list("plays", &self.weights)?,
        })
    }
}

#[derive(Clone, Copy, Debug, PartialEq)]
struct Play<T> {
    threshold: T,
    weight: T,
    /// q + Σ of the weights up to and with this one: the slope of u over v when the plays up to here are driven.
    slope: T,
    reciprocal_slope: T,
    /// Σ of weight times threshold up to and with this one.
    moment: T,
}

/// A validated bank of at most `N` plays.
#[derive(Clone, Debug, PartialEq)]
pub struct PlayBank<T, const N: usize> {
    q: T,
    reciprocal_q: T,
    plays: Vec<Play<T>, N>,
}

/// What a bank of plays remembers.
#[derive(Clone, Debug, PartialEq)]
pub struct PlayState<T, const N: usize> {
    /// The outputs z of the plays. Unit: that of the bank's input.
    outputs: Vec<T, N>,
    /// The last input.
    input: T,
}

impl<T: Real, const N: usize> PlayState<T, N> {
    /// The outputs of the plays, by rising threshold.
    pub fn outputs(&self) -> &[T] {
        &self.outputs
    }

    /// The last input of the bank. Unit: that of its input.
    pub fn input(&self) -> T {
        self.input
    }
}

/// Where a bank stands after a move: the first `driven` plays follow the input, the others stand still.
struct Cut<T> {
    driven: usize,
    /// The part of u of the plays that stand still.
    still: T,
}

impl<T: Real, const N: usize> PlayBank<T, N> {
    /// # Errors
    /// Lists of different length; a threshold that is not above the one before (or above 0); q or a
    /// partial sum of the weights that is not above 0; anything not finite.
    pub fn try_new(parameters: &PlayParameters<T, N>) -> Result<Self, ParameterError> {
        let PlayParameters { q, thresholds, weights } = parameters;
        if weights.len() != thresholds.len() {
            let requirement = Requirement::Exactly(thresholds.len() as f64);
            return Err(Check::new("number of play weights", "").length(weights.len(), requirement));
        }
        let q = Check::new("q", "").above(*q, T::ZERO)?;
        let reciprocal_q = Check::new("1/q", "").finite(T::ONE / q)?;
        let mut bank = Self { q, reciprocal_q, plays: Vec::new() };
        let (mut last, mut slope, mut moment) = (T::ZERO, q, T::ZERO);
        for (i, (&threshold, &weight)) in thresholds.iter().zip(weights).enumerate() {
            last = Check::at("play thresholds", i, "").above(threshold, last)?;
            Check::at("play weights", i, "").finite(weight)?;
            let check = Check::at("partial sums of q and play weights", i, "");
            slope = check.above(slope + weight, T::ZERO)?;
            let reciprocal_slope =
                check.named("reciprocal partial sums of play weights").finite(T::ONE / slope)?;
            moment += weight * threshold;
            // A play more than the capacity cannot come out of a list of that capacity.
            let _ = bank.plays.push(Play { threshold, weight, slope, reciprocal_slope, moment });
        }
        Ok(bank)
    }

    /// Number of plays.
    pub fn len(&self) -> usize {
        self.plays.len()
    }

    /// Whether the bank is the direct term alone.
    pub fn is_empty(&self) -> bool {
        self.plays.is_empty()
    }

    /// The smallest slope of u over v, the distance from being non-invertible. Unit: 1.
    pub fn smallest_slope(&self) -> T {
        self.plays.iter().fold(self.q, |least, play| if play.slope < least { play.slope } else { least })
    }

    /// The largest slope of u over v. Unit: 1.
    pub fn largest_slope(&self) -> T {
        self.plays.iter().fold(self.q, |most, play| if play.slope > most { play.slope } else { most })
    }

    /// The state of a bank that rested at 0 and was then brought to `v`: the paper's initial state,
    /// equation (1) with w = 0.
    pub fn rest_state(&self, v: T) -> PlayState<T, N> {
        let mut state = PlayState { outputs: list(self.plays.iter().map(|_| T::ZERO)), input: T::ZERO };
        self.advance(&mut state, v);
        state
    }

    /// The state with the given outputs at the input `v`, if some history leads there:
    /// |v - z₁| ≤ r₁ and |zᵢ - zᵢ₊₁| ≤ rᵢ₊₁ - rᵢ, with a tolerance of a few roundings.
    ///
    /// # Errors
    /// Names the first output that no history can reach.
    pub fn try_state(&self, outputs: &[T], v: T) -> Result<PlayState<T, N>, ParameterError> {
        if outputs.len() != self.plays.len() {
            let requirement = Requirement::Exactly(self.plays.len() as f64);
            return Err(Check::new("number of play outputs", "").length(outputs.len(), requirement));
        }
        admissible(self.plays.iter().map(|play| play.threshold), outputs, v)?;
        Ok(PlayState { outputs: list(outputs.iter().copied()), input: v })
    }

    /// One sample: moves the plays to the input `v` and answers u. Equations (6), (7).
    ///
    /// # Errors
    /// `v` is not finite; the state is then as it was.
    pub fn step(&self, state: &mut PlayState<T, N>, v: T) -> Result<T, InputError> {
        Ok(self.advance(state, finite_input(v)?))
    }

    /// [`step`](Self::step) for an input that is known to be finite.
    pub(crate) fn advance(&self, state: &mut PlayState<T, N>, v: T) -> T {
        self.advance_toward(state, v, v > state.input)
    }

    /// As [`advance`](Self::advance), in a direction that is known: with two envelopes v jumps, against the
    /// direction, at each reversal of the input that it comes from.
    pub(crate) fn advance_toward(&self, state: &mut PlayState<T, N>, v: T, rising: bool) -> T {
        if rising { self.drive::<true>(state, v, None) } else { self.drive::<false>(state, v, None) }
    }

    /// As [`advance_toward`](Self::advance_toward), but goes no farther than u stays within the range: the input
    /// that leads to its end takes the place of one beyond.
    pub(crate) fn advance_within(
        &self,
        state: &mut PlayState<T, N>,
        v: T,
        rising: bool,
        range: &Range<T>,
    ) -> T {
        if rising {
            self.drive::<true>(state, v, Some(range.max()))
        } else {
            self.drive::<false>(state, v, Some(range.min()))
        }
    }

    /// Moves in one direction, in which only one of a play's two bounds can bind, to `v` or to where u
    /// reaches `end`.
    ///
    /// The driven plays are always those of the smallest thresholds, so that the walk goes down from the
    /// largest threshold and ends at the first driven play: what follows the input needs no sum of its
    /// own, and what stands still no store.
    #[inline(always)]
    fn drive<const RISING: bool>(&self, state: &mut PlayState<T, N>, v: T, end: Option<T>) -> T {
        let mut cut = Cut { driven: self.plays.len(), still: T::ZERO };
        self.shorten(
            &mut cut,
            state,
            |_, play, z| {
                if RISING { v - play.threshold > z } else { v + play.threshold < z }
            },
        );
        let mut u = self.output::<RISING>(&cut, v);
        let mut v = v;
        if let Some(end) = end
            && if RISING { u > end } else { u < end }
        {
            // Only those plays are driven that start to be before the end is reached.
            self.shorten(&mut cut, state, |cut, play, z| {
                let start = if RISING { z + play.threshold } else { z - play.threshold };
                let u = self.output::<RISING>(cut, start);
                if RISING { u < end } else { u > end }
            });
            v = self.input::<RISING>(&cut, end);
            u = end;
        }
        for (play, z) in self.plays.iter().zip(&mut state.outputs).take(cut.driven) {
            *z = if RISING { v - play.threshold } else { v + play.threshold };
        }
        state.input = v;
        u
    }

    /// Takes plays out of a cut, from the largest threshold on, up to the first one that is driven.
    #[inline(always)]
    fn shorten(
        &self,
        cut: &mut Cut<T>,
        state: &PlayState<T, N>,
        is_driven: impl Fn(&Cut<T>, &Play<T>, T) -> bool,
    ) {
        for (play, &z) in self.plays.iter().zip(&state.outputs).take(cut.driven).rev() {
            if is_driven(cut, play, z) {
                break;
            }
            cut.still += play.weight * z;
            cut.driven -= 1;
        }
    }

    /// The last play that a cut drives: slope, its reciprocal and moment; those of the direct term without one.
    #[inline(always)]
    fn front(&self, cut: &Cut<T>) -> (T, T, T) {
        match self.plays.get(cut.driven.wrapping_sub(1)) {
            Some(play) => (play.slope, play.reciprocal_slope, play.moment),
            None => (self.q, self.reciprocal_q, T::ZERO),
        }
    }

    /// u at the input `v`.
    #[inline(always)]
    fn output<const RISING: bool>(&self, cut: &Cut<T>, v: T) -> T {
        let (slope, _, moment) = self.front(cut);
        slope * v + if RISING { cut.still - moment } else { cut.still + moment }
    }

    /// The input at the output `u`.
    #[inline(always)]
    fn input<const RISING: bool>(&self, cut: &Cut<T>, u: T) -> T {
        let (_, reciprocal_slope, moment) = self.front(cut);
        (u - if RISING { cut.still - moment } else { cut.still + moment }) * reciprocal_slope
    }

    /// The inverse bank, from u to v. Equation (21).
    ///
    /// # Errors
    /// A parameter of the inverse is not finite, or its thresholds coincide, in this number type.
    pub fn inverse(&self) -> Result<Self, ParameterError> {
        let mut parameters =
            PlayParameters { q: T::ONE / self.q, thresholds: Vec::new(), weights: Vec::new() };
        let (mut slope, mut last, mut image) = (self.q, T::ZERO, T::ZERO);
        for play in &self.plays {
            // The threshold's image under the bank's initial loading curve; its slope up to here is `slope`.
            image += slope * (play.threshold - last);
            last = play.threshold;
            // As many as plays: both pushes fit.
            let _ = parameters.thresholds.push(image);
            let _ = parameters.weights.push(-play.weight * play.reciprocal_slope / slope);
            slope = play.slope;
        }
        Self::try_new(&parameters)
    }

    /// The state that the inverse bank has where this bank has `state`.
    pub fn inverse_state(&self, state: &PlayState<T, N>) -> PlayState<T, N> {
        let mut outputs = state.outputs.clone();
        // Σ_{j>i} pⱼ zⱼ, gathered from the last play to the first.
        let mut tail = T::ZERO;
        for (play, z) in self.plays.iter().zip(&mut outputs).rev() {
            let output = *z;
            *z = play.slope * output + tail;
            tail += play.weight * output;
        }
        PlayState { outputs, input: self.q * state.input + tail }
    }
}

/// Refuses outputs of plays that no history can reach at the input `v`: |v - z₁| ≤ r₁ and
/// |zᵢ - zᵢ₊₁| ≤ rᵢ₊₁ - rᵢ, with a tolerance of a few roundings. As many outputs as thresholds.
pub(crate) fn admissible<T: Real>(
    thresholds: impl Iterator<Item = T>,
    outputs: &[T],
    v: T,
) -> Result<(), ParameterError> {
    let mut before = (Check::new("v", "").finite(v)?, T::ZERO);
    for (i, (threshold, &output)) in thresholds.zip(outputs).enumerate() {
        let check = Check::at("play outputs", i, "");
        check.finite(output)?;
        let tolerance = T::from_f64(8.0) * T::EPSILON * (v.abs() + threshold);
        let reach = threshold - before.1 + tolerance;
        if output > before.0 + reach {
            return Err(check.error(output.to_f64(), Requirement::AtMost((before.0 + reach).to_f64())));
        }
        if output < before.0 - reach {
            return Err(check.error(output.to_f64(), Requirement::AtLeast((before.0 - reach).to_f64())));
        }
        before = (output, threshold);
    }
    Ok(())
}

/// The values as a list, as many as fit. `collect` would panic on one too many, also where there is none.
fn list<T, const N: usize>(values: impl Iterator<Item = T>) -> Vec<T, N> {
    let mut list = Vec::new();
    for value in values.take(N) {
        let _ = list.push(value);
    }
    list
}
