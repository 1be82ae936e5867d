//! A bank of weighted plays, u = q v + Σ pᵢ zᵢ, and its inverse.
//!
//! The state of play i follows the inner coordinate v at a distance of at most its threshold:
//! zᵢ ← max(v - rᵢ, min(v + rᵢ, zᵢ)), equation (7) with one envelope; the sum is equation (6).
//!
//! # Design
//! Up to ten plays are kept by their outputs (`few_plays`). Of more, none is kept by itself: from a
//! turning point (v₀, u₀) on, play i is driven once v is more than 2 rᵢ away from v₀, so that u
//! moves along one curve, whatever went before:
//!
//! u = u₀ ± C(|v - v₀|), C(Δ) = q Δ + Σ pᵢ max(Δ - 2 rᵢ, 0),
//!
//! up to the turning point before, where the two are wiped out and the move goes on from the one
//! before that. So a sample costs one search among the turning points (`turning_points`) and one on
//! the curve (`loading_curve`), and its cost hardly grows with the number of plays. A move that has
//! wiped out all turning points drives all plays: u = (q + Σ pᵢ) v ∓ Σ pᵢ rᵢ.
//!
//! # The inverse
//! v and u change places: the inverse curve, and the same turning points with both coordinates
//! exchanged; of few plays the outputs q zᵢ + p₁ zᵢ + … + pᵢ zᵢ + pᵢ₊₁ zᵢ₊₁ + … + pₙ zₙ. It is a
//! bank again, that of equations (18), (19) and (21). The paper is silent about the state of the
//! inverse; a zero in its place costs up to 0.7 bar until it is wiped out.
//!
//! # Validity
//! q and every partial sum q + p₁ + … + pᵢ positive: then u is strictly increasing in v from every
//! state, and the inverse is exact. Single weights may be negative (those of an inverse are).

use crate::curve::Segment;
use crate::direction::Target;
use crate::error::{Check, InputError, ParameterError, Requirement, finite_input};
use crate::few_plays::{FEW_PLAYS, FewPlays};
use crate::list::List;
use crate::loading_curve::LoadingCurve;
use crate::play_state::Memory;
use crate::range::Range;
use crate::real::Real;
use crate::turn_stack::Turn;
use crate::turning_points::{TurningPoints, admissible};

pub(crate) use crate::direction::Reached;
pub use crate::play_parameters::PlayParameters;
pub use crate::play_state::PlayState;

/// A validated bank of at most `N` plays.
///
/// ```
/// use model_core::play::{PlayBank, PlayParameters};
///
/// let bank = PlayBank::try_new(&PlayParameters::<f64, 4>::exponential(4, 0.3, 0.2, 5.0, 0.1)?)?;
/// let mut state = bank.rest_state(0.0);
/// let rising = bank.step(&mut state, 0.5)?;
/// bank.step(&mut state, 1.0)?;
/// let falling = bank.step(&mut state, 0.5)?;
/// assert!(falling > rising); // hysteresis: the way back lies above
///
/// bank.step(&mut state, 1.0)?;
/// assert_eq!(bank.step(&mut state, 0.5)?, falling); // a small loop closes
/// # Ok::<(), Box<dyn core::error::Error>>(())
/// ```
#[derive(Clone, Debug, PartialEq)]
#[repr(C)] // As for `InverseCascade`.
pub struct PlayBank<T, const N: usize> {
    /// The same bank, where it has at most [`FEW_PLAYS`].
    few: FewPlays<T>,
    /// C: how far u moves when v moves from a turning point. Its i-th bend is at twice the i-th
    /// threshold.
    pub(crate) curve: LoadingCurve<T, N>,
    /// Where a falling move that drives all plays can be thought to come from: the last segment's
    /// line goes through it. A rising one comes from the same point on the other side of 0.
    pub(crate) origin_of_all: Turn<T>,
}

impl<T: Real, const N: usize> PlayBank<T, N> {
    fn new(curve: LoadingCurve<T, N>) -> Self {
        let (v, u) = curve.all().start();
        let origin_of_all = Turn { v: half(v), u: half(u), driven: 0 };
        Self { few: FewPlays::new(&curve), curve, origin_of_all }
    }

    /// # Errors
    /// Lists of different length; a threshold that is not above the one before (or above 0); q or a
    /// partial sum of the weights that is not above 0; anything not finite.
    pub fn try_new(parameters: &PlayParameters<T, N>) -> Result<Self, ParameterError> {
        let PlayParameters { q, thresholds, weights } = parameters;
        if weights.len() != thresholds.len() {
            let requirement = Requirement::Exactly(thresholds.len() as f64);
            return Err(Check::new("number of play weights", "").length(weights.len(), requirement));
        }
        let mut curve = LoadingCurve::line(*q, Check::new("q", ""))?;
        let (mut last, mut slope, mut point) = (T::ZERO, *q, (T::ZERO, T::ZERO));
        for (i, (&threshold, &weight)) in thresholds.iter().zip(weights).enumerate() {
            last = Check::at("play thresholds", i, "").above(threshold, last)?;
            Check::at("play weights", i, "").finite(weight)?;
            let bend = threshold + threshold;
            point = (bend, point.1 + slope * (bend - point.0));
            slope += weight;
            curve.bend(point, slope, Check::at("partial sums of q and play weights", i, ""))?;
        }
        Ok(Self::new(curve))
    }

    /// Number of plays.
    pub fn len(&self) -> usize {
        self.curve.len()
    }

    /// Whether the bank is the direct term alone.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// The smallest slope of u over v, the distance from being non-invertible. Unit: 1.
    pub fn smallest_slope(&self) -> T {
        self.curve.segments().fold(T::INFINITY, |least, segment| least.at_most(segment.slope()))
    }

    /// The thresholds of the plays.
    fn thresholds(&self) -> impl Iterator<Item = T> {
        self.curve.segments().skip(1).map(|segment| half(segment.start().0))
    }

    /// The largest slope of u over v. Unit: 1.
    pub fn largest_slope(&self) -> T {
        self.curve.segments().fold(T::ZERO, |most, s| if s.slope() > most { s.slope() } else { most })
    }

    /// The slope where all plays are driven. Unit: 1.
    pub(crate) fn slope_of_all(&self) -> T {
        self.curve.all().slope()
    }

    /// The state of a bank that rested at 0 and was then brought to `v`: the paper's initial state,
    /// equation (1) with w = 0.
    pub fn rest_state(&self, v: T) -> PlayState<T, N> {
        self.rested_at(T::ZERO, v)
    }

    /// The state of a bank that rested at `rest` instead of at 0.
    pub(crate) fn rested_at(&self, rest: T, v: T) -> PlayState<T, N> {
        let mut state = self.state_with(|_| rest, rest);
        self.advance(&mut state, v);
        state
    }

    /// The state with the given outputs at the input `v`, if some history leads there:
    /// |v - z₁| ≤ r₁ and |zᵢ - zᵢ₊₁| ≤ rᵢ₊₁ - rᵢ, with a tolerance of a few roundings.
    ///
    /// # Errors
    /// Names the first output that no history can reach.
    pub fn try_state(&self, outputs: &[T], v: T) -> Result<PlayState<T, N>, ParameterError> {
        if outputs.len() != self.len() {
            let requirement = Requirement::Exactly(self.len() as f64);
            return Err(Check::new("number of play outputs", "").length(outputs.len(), requirement));
        }
        admissible(self.thresholds(), outputs, v)?;
        Ok(self.state_with(|play| outputs.get(play).copied().unwrap_or(T::ZERO), v))
    }

    /// The state at the input `v` with these outputs of the plays.
    fn state_with(&self, output: impl Fn(usize) -> T, v: T) -> PlayState<T, N> {
        if self.len() <= FEW_PLAYS {
            let last = self.len().saturating_sub(1);
            PlayState::few(FewPlays::state_with(|play| output(play.min(last)), v))
        } else {
            PlayState::many(self.turning_points_with(output, v))
        }
    }

    /// A history of one turning point for each play, from the largest threshold on.
    fn turning_points_with(&self, output: impl Fn(usize) -> T, v: T) -> TurningPoints<T, N> {
        let mut state = TurningPoints::new(Turn { v, u: T::ZERO, driven: 0 }, false);
        // What the plays of the larger thresholds add to u.
        let mut still = T::ZERO;
        for play in (0..self.len()).rev() {
            let (segment, z) = (self.curve.segment(play + 1), output(play));
            let threshold = half(segment.start().0);
            state.rising = !state.rising;
            let turn = if state.rising { z - threshold } else { z + threshold };
            let moment = half(segment.slope() * segment.start().0 - segment.start().1);
            let u = segment.slope() * turn + still + if state.rising { moment } else { -moment };
            // As many as plays: it fits.
            let _ = state.push(Turn { v: turn, u, driven: play + 1 });
            still += (segment.slope() - self.curve.segment(play).slope()) * z;
        }
        state.last.u = self.curve.segment(0).slope() * v + still;
        state
    }

    /// The same memory, kept by turning points whatever the number of plays. The bank then moves by
    /// those: slower while the plays are few, at a cost that hardly grows with their number. A bank
    /// without room for more than ten leaves it as it is.
    pub fn by_turning_points(&self, state: &PlayState<T, N>) -> PlayState<T, N> {
        match state.memory() {
            Memory::Few(few) if N > FEW_PLAYS => {
                let output = |play| few.iter().nth(play).copied().unwrap_or(T::ZERO);
                PlayState::many(self.turning_points_with(output, few.v))
            }
            _ => state.clone(),
        }
    }

    /// The outputs of the plays, by rising threshold.
    pub fn outputs(&self, state: &PlayState<T, N>) -> List<T, N> {
        let mut outputs = List::new();
        let state = match state.memory() {
            Memory::Few(few) => {
                // There are no more plays than places.
                return List::try_from_iter(few.iter().take(self.len()).copied()).unwrap_or_default();
            }
            Memory::Many(many) => many,
        };
        for threshold in self.thresholds() {
            let _ = outputs.push(state.last.v - if state.rising { threshold } else { -threshold });
        }
        for (turn, is_high) in state.outermost_first().chain([(state.last, state.rising)]) {
            for (z, threshold) in outputs.iter_mut().zip(self.thresholds()).take(turn.driven) {
                *z = turn.v - if is_high { threshold } else { -threshold };
            }
        }
        outputs
    }

    /// One sample: moves the plays to the input `v` and answers u. Equations (6), (7).
    ///
    /// # Errors
    /// `v` is not finite; the state is then as it was.
    pub fn step(&self, state: &mut PlayState<T, N>, v: T) -> Result<T, InputError> {
        Ok(self.advance(state, finite_input(v)?))
    }

    /// [`step`](Self::step) for an input that is known to be finite.
    #[inline(always)]
    pub(crate) fn advance(&self, state: &mut PlayState<T, N>, v: T) -> T {
        match state.memory_mut() {
            Memory::Few(few) if v >= few.v => self.few.drive::<true>(few, v),
            Memory::Few(few) => self.few.drive::<false>(few, v),
            Memory::Many(many) => self.advance_many(many, v, many.goes_up_to(v), None).output(),
        }
    }

    /// Refuses a bank whose thresholds cannot change from sample to sample: one of many plays, or
    /// with a weight below 0, of which a wider bank may move farther than a narrow one.
    pub(crate) fn check_widening(&self) -> Result<(), ParameterError> {
        if self.len() > FEW_PLAYS {
            let check = Check::new("number of plays whose thresholds change", "");
            return Err(check.length(self.len(), Requirement::AtMost(FEW_PLAYS as f64)));
        }
        let slopes = || self.curve.segments().map(Segment::slope);
        for (i, (before, after)) in slopes().zip(slopes().skip(1)).enumerate() {
            Check::at("play weights where thresholds change", i, "").at_least(after - before, T::ZERO)?;
        }
        Ok(())
    }

    /// As [`advance`](Self::advance), with thresholds `times` as wide at this sample; of a bank
    /// that can widen.
    #[inline(always)]
    pub(crate) fn advance_wider(&self, state: &mut PlayState<T, N>, v: T, times: T) -> T {
        match state.memory_mut() {
            Memory::Few(few) => self.few.drive_wider(few, v, times),
            Memory::Many(_) => self.advance(state, v),
        }
    }

    /// What the plays of a bank that can widen hold back, from -1 (all follow a fall) to 1 (all
    /// follow a rise).
    pub(crate) fn held_back(&self, state: &PlayState<T, N>) -> T {
        match state.memory() {
            Memory::Few(few) => self.few.held_back(few),
            Memory::Many(_) => T::ZERO,
        }
    }

    /// The v that [`advance_wider`](Self::advance_wider) would answer with `u`. Moves nothing.
    #[inline(always)]
    pub(crate) fn input_wider(&self, state: &PlayState<T, N>, u: T, times: T) -> T {
        match state.memory() {
            Memory::Few(few) => self.few.input_wider(few, u, times),
            Memory::Many(many) => many.last.v,
        }
    }

    /// As [`advance`](Self::advance), in a direction that is known: with two envelopes v jumps,
    /// against the direction, at each reversal of the input that it comes from.
    pub(crate) fn advance_toward(&self, state: &mut PlayState<T, N>, v: T, rising: bool) -> T {
        match (state.memory_mut(), rising) {
            (Memory::Few(few), true) => self.few.drive::<true>(few, v),
            (Memory::Few(few), false) => self.few.drive::<false>(few, v),
            (Memory::Many(many), _) => self.advance_many(many, v, rising, None).output(),
        }
    }

    /// More than roundings can move u, where that stays within `range`; of few plays.
    pub(crate) fn rounding(&self, range: &Range<T>) -> T {
        self.few.rounding(range)
    }

    /// As [`advance_toward`](Self::advance_toward), but goes no farther than u stays within the
    /// range: the input that leads to its end takes the place of one beyond.
    pub(crate) fn advance_within(
        &self,
        state: &mut PlayState<T, N>,
        v: T,
        rising: bool,
        range: &Range<T>,
    ) -> T {
        match (state.memory_mut(), rising) {
            (Memory::Few(few), true) => {
                self.few.drive_within::<true, _>(few, v, range, |u| u, || range.max())
            }
            (Memory::Few(few), false) => {
                self.few.drive_within::<false, _>(few, v, range, |u| u, || range.min())
            }
            (Memory::Many(many), _) => self.advance_many(many, v, rising, Some(range)).output(),
        }
    }

    /// As [`advance`](Self::advance), but stays within the range; from a state that no jumps led
    /// to. Hands u to `inside`, or asks `at_end`, to which it says whether that is the upper one.
    /// Many plays are handed on, to avoid register spills in the path of few plays.
    #[inline(always)]
    pub(crate) fn advance_inside<A>(
        &self,
        state: &mut PlayState<T, N>,
        v: T,
        range: &Range<T>,
        inside: impl FnOnce(T) -> A,
        at_end: impl FnOnce(bool) -> A,
        many: impl FnOnce(&mut TurningPoints<T, N>) -> A,
    ) -> A {
        match state.memory_mut() {
            Memory::Few(few) if v >= few.v => {
                self.few.drive_within::<true, _>(few, v, range, inside, || at_end(true))
            }
            Memory::Few(few) => self.few.drive_within::<false, _>(few, v, range, inside, || at_end(false)),
            Memory::Many(state) => many(state),
        }
    }

    /// What many plays have reached that move to `v`, but stay within the range.
    pub(crate) fn advance_many_inside(
        &self,
        state: &mut TurningPoints<T, N>,
        v: T,
        range: &Range<T>,
    ) -> Reached<T> {
        self.advance_many(state, v, state.goes_up_to(v), Some(range))
    }

    /// Not inlined, to avoid register spills in the path of few plays.
    #[inline(always)]
    fn advance_many(
        &self,
        state: &mut TurningPoints<T, N>,
        v: T,
        rising: bool,
        range: Option<&Range<T>>,
    ) -> Reached<T> {
        if rising {
            self.drive::<true>(state, Target { v, end: range.map(Range::max) })
        } else {
            self.drive::<false>(state, Target { v, end: range.map(Range::min) })
        }
    }

    /// The inverse bank, from u to v. Equation (21).
    ///
    /// # Errors
    /// Thresholds of the inverse coincide, or are not finite, in this number type.
    ///
    /// ```
    /// use model_core::play::{PlayBank, PlayParameters};
    ///
    /// let bank = PlayBank::try_new(&PlayParameters::<f64, 4>::exponential(4, 0.3, 0.2, 5.0, 0.1)?)?;
    /// let inverse = bank.inverse()?;
    /// let (mut there, mut back) = (bank.rest_state(0.0), inverse.rest_state(0.0));
    /// for v in [0.2, 0.9, 0.4, 0.6] {
    ///     let u = bank.step(&mut there, v)?;
    ///     assert!((inverse.step(&mut back, u)? - v).abs() < 1e-12);
    /// }
    /// # Ok::<(), Box<dyn core::error::Error>>(())
    /// ```
    pub fn inverse(&self) -> Result<Self, ParameterError> {
        let mut last = T::ZERO;
        for (i, segment) in self.curve.segments().skip(1).enumerate() {
            last = Check::at("play thresholds of the inverse", i, "").above(segment.start().1, last)?;
        }
        Ok(Self::new(self.curve.inverted()))
    }

    /// The state that the inverse bank has where this bank has `state`.
    pub fn inverse_state(&self, state: &PlayState<T, N>) -> PlayState<T, N> {
        match state.memory() {
            Memory::Few(few) => PlayState::few(self.few.inverse_state(few)),
            Memory::Many(many) => PlayState::many(many.inverted()),
        }
    }
}

fn half<T: Real>(value: T) -> T {
    T::from_f64(0.5) * value
}
