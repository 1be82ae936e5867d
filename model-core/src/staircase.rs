//! The bank of plays as a staircase: the same operator as [`crate::play`], at a cost that hardly grows with the
//! number of plays.
//!
//! # Design
//! The outputs of the plays over their thresholds are a staircase: a few segments, each of plays that were last
//! driven at the same moment, z = v - s r with s = 1 (driven upward), -1 (downward) or 0 (never). A
//! new input drives the plays of the smallest thresholds, up to a cut, into one new segment; the
//! segments before the cut are gone (wiping-out), the one at the cut is shortened. With the prefix sums
//! P = Σ p and Q = Σ p r a segment's part of u is v (P_end - P_begin) - s (Q_end - Q_begin), and the parts of
//! all segments behind the top one are kept as a running tail. So a sample costs one push, one search
//! for the cut, and the pops of segments that earlier samples pushed: amortised constant.
//!
//! # Limits
//! A sample that wipes out many segments at once costs their number, at most the number of plays. At most
//! `N + 1` segments exist; an arbitrary admissible state starts with one per play.

use heapless::Vec;

use crate::error::{Check, InputError, ParameterError, Requirement, finite_input};
use crate::play::{PlayBank, PlayParameters, admissible};
use crate::real::Real;

/// How many plays are tried one by one before the cut is searched by halving.
const NEAR: usize = 4;

/// A play with the prefix sums up to and with it.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Step<T> {
    threshold: T,
    weight_sum: T,
    moment_sum: T,
}

/// A validated bank of at most `N` plays, evaluated as a staircase.
#[derive(Clone, Debug, PartialEq)]
pub struct StaircaseBank<T, const N: usize> {
    q: T,
    steps: Vec<Step<T>, N>,
}

/// Plays that were last driven together: z = v - side r for those before `end` and not in a later segment.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Segment<T> {
    v: T,
    /// 1 driven upward, -1 downward, 0 never.
    side: T,
    end: usize,
    /// The part of u of all plays from `end` on.
    tail: T,
}

/// The staircase: all that the bank remembers. The last segment is that of the smallest thresholds.
#[derive(Clone, Debug, PartialEq)]
pub struct StaircaseState<T, const N: usize> {
    segments: Vec<Segment<T>, N>,
    /// The last input.
    v: T,
}

impl<T: Real, const N: usize> StaircaseBank<T, N> {
    /// # Errors
    /// Those of [`PlayBank::try_new`].
    pub fn try_new(parameters: &PlayParameters<T, N>) -> Result<Self, ParameterError> {
        PlayBank::try_new(parameters)?;
        let (mut weight_sum, mut moment_sum) = (T::ZERO, T::ZERO);
        let step = |(&threshold, &weight): (&T, &T)| {
            weight_sum += weight;
            moment_sum += weight * threshold;
            Step { threshold, weight_sum, moment_sum }
        };
        let steps = parameters.thresholds.iter().zip(&parameters.weights).map(step).collect();
        Ok(Self { q: parameters.q, steps })
    }

    /// The state of a bank that rested at 0 and was then brought to `v`.
    pub fn rest_state(&self, v: T) -> StaircaseState<T, N> {
        let mut state = StaircaseState { segments: Vec::new(), v: T::ZERO };
        if !self.steps.is_empty() {
            state.push(Segment { v: T::ZERO, side: T::ZERO, end: self.steps.len(), tail: T::ZERO });
        }
        self.advance(&mut state, v);
        state
    }

    /// The state with the given outputs of the plays at the input `v`, if some history leads there.
    ///
    /// # Errors
    /// Another number of outputs than plays, or the first output that no history can reach:
    /// |v - z₁| ≤ r₁ and |zᵢ - zᵢ₊₁| ≤ rᵢ₊₁ - rᵢ.
    pub fn try_state(&self, outputs: &[T], v: T) -> Result<StaircaseState<T, N>, ParameterError> {
        if outputs.len() != self.steps.len() {
            let requirement = Requirement::Exactly(self.steps.len() as f64);
            return Err(Check::new("number of play outputs", "").length(outputs.len(), requirement));
        }
        admissible(self.steps.iter().map(|step| step.threshold), outputs, v)?;
        let mut state = StaircaseState { segments: Vec::new(), v };
        let mut tail = T::ZERO;
        for (play, &output) in outputs.iter().enumerate().rev() {
            let segment = Segment { v: output, side: T::ZERO, end: play + 1, tail };
            state.push(segment);
            tail += self.part(&segment, play, play + 1);
        }
        Ok(state)
    }

    /// The outputs of the plays, by rising threshold.
    pub fn outputs(&self, state: &StaircaseState<T, N>) -> Vec<T, N> {
        let mut begin = 0;
        let mut outputs = Vec::new();
        for segment in state.segments.iter().rev() {
            for step in self.steps.iter().take(segment.end).skip(begin) {
                // At most as many as plays.
                let _ = outputs.push(segment.v - segment.side * step.threshold);
            }
            begin = segment.end;
        }
        outputs
    }

    /// One sample: moves the plays to the input `v` and answers u. Equations (6), (7).
    ///
    /// # Errors
    /// `v` is not finite; the state is then as it was.
    pub fn step(&self, state: &mut StaircaseState<T, N>, v: T) -> Result<T, InputError> {
        Ok(self.advance(state, finite_input(v)?))
    }

    fn advance(&self, state: &mut StaircaseState<T, N>, v: T) -> T {
        let side = if v > state.v { T::ONE } else { -T::ONE };
        // Driven: the output is behind v by more than the threshold, seen in the direction of travel.
        let driven = |segment: &Segment<T>, step: &Step<T>| {
            (v - segment.v + segment.side * step.threshold) * side > step.threshold
        };
        let (mut cut, mut tail) = (0, T::ZERO);
        while let Some(&top) = state.segments.last() {
            if self.steps.get(top.end - 1).is_some_and(|last| driven(&top, last)) {
                state.segments.pop();
                cut = top.end;
                continue;
            }
            let open = self.steps.get(cut..top.end).unwrap_or_default();
            // A smooth input drives few more plays from sample to sample: look near first.
            let near = open.iter().take(NEAR).take_while(|step| driven(&top, step)).count();
            let far = open.get(NEAR..).filter(|_| near == NEAR).unwrap_or_default();
            cut += near + far.partition_point(|step| driven(&top, step));
            tail = self.part(&top, cut, top.end) + top.tail;
            break;
        }
        if cut > 0 {
            state.push(Segment { v, side, end: cut, tail });
        }
        state.v = v;
        self.q * v + v * self.weight_sum(cut) - side * self.moment_sum(cut) + tail
    }

    /// The part of u of a segment's plays from `begin` to `end`.
    fn part(&self, segment: &Segment<T>, begin: usize, end: usize) -> T {
        segment.v * (self.weight_sum(end) - self.weight_sum(begin))
            - segment.side * (self.moment_sum(end) - self.moment_sum(begin))
    }

    /// Σ p of the first `count` plays.
    fn weight_sum(&self, count: usize) -> T {
        self.steps.get(count.wrapping_sub(1)).map_or(T::ZERO, |step| step.weight_sum)
    }

    /// Σ p r of the first `count` plays.
    fn moment_sum(&self, count: usize) -> T {
        self.steps.get(count.wrapping_sub(1)).map_or(T::ZERO, |step| step.moment_sum)
    }
}

impl<T: Real, const N: usize> StaircaseState<T, N> {
    fn push(&mut self, segment: Segment<T>) {
        // A segment holds at least one play of its own, so that there are never more than plays.
        let _ = self.segments.push(segment);
    }
}
