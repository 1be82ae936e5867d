//! Adaptation: the feed-forward follows a muscle that warms up, ages or is loaded.
//!
//! The model stays as it is. What changes is what its inverse is asked for, with ρ the reference in
//! halves of the output range from its middle on:
//!
//! ```text
//! asked = reference − half ( offset + gain ρ + bend (ρ² − ½) + (width + flare ρ) h )
//! ```
//! h is where a play of half width [`PLAY`], driven by ρ, stands within its play, −1 to 1: the
//! branch. So offset, gain and bend move both branches, width and flare draw them apart.
//! All five are linear in what is to be learnt and explicit in the reference, and they act on the
//! contraction, as heat does.
//!
//! # What is learnt from
//! By how much the contraction misses what was due, less what feedback has moved it by, which is
//! told by the slope that the inverse has there. It is gathered over each move of the reference by
//! [`MOVE`], and each such mean is one step of recursive least squares that forgets over [`MEMORY`]
//! of them. A sixth number, the offset's change from step to step, is learnt with them: without it
//! what is learnt lags a muscle that warms up by the memory.
//!
//! # What is not excited
//! The information (the inverse of the covariance) is kept and not the covariance, and what is
//! forgotten of it is replaced by a share of what there was at the start: a direction that the
//! reference leaves open is never known less than that, and nothing pulls on it. At rest there are
//! no moves and so no steps.
//!
//! # Contract
//! * The inverse stays one: what is asked for rises with the reference by at least [`LEFT`] on
//!   every branch (`Adapter::held`), whatever is learnt; the offset stays within [`OFFSET`].
//! * Nothing is learnt in a tick that its caller does not trust, whose reference is outside the
//!   model's range, whose feed-forward is at the end of it, or in which more is missing than the
//!   bounds allow; nor in the rest of such a move.
//!
//! # Limits
//! Extensions (load, temperature, creep) are led as before; what is missing beside all of them is
//! learnt. A lateness that the model does not have looks like width, at the speed at which it is
//! learnt. What the muscle does while the reference rests is not seen until it moves again.

use crate::extension::root::{Point, root};
use crate::real::Real;

/// Numbers that are learnt: offset, its change over [`MEMORY`] steps, gain, bend, width, flare.
const LEARNT: usize = 6;
/// Where the offset stands among them.
const OFFSETS: usize = 0;
/// Where its change does.
const CHANGES: usize = 1;

/// How far the reference moves for a step of learning, as a share of the output range.
pub const MOVE: f64 = 0.01;
/// Steps after which 1/e of a step's weight is left: one stroke.
pub const MEMORY: f64 = 100.0;
/// Half width of the play that tells the branch, in halves of the output range: a tenth of it,
/// within which the branches of a muscle's loop part after a turn.
pub const PLAY: f64 = 0.2;
/// How far the offset may go, in halves of the output range: a fifth of the range. Heat of 15 K
/// moves the rig's muscle by up to an eighth (`--bin control -- --drift`); one that differs by more
/// than a fifth is not the one that was recorded.
pub const OFFSET: f64 = 0.4;
/// What is left of the slope of what is asked for over the reference, at the least. Unit: 1.
pub const LEFT: f64 = 0.25;
/// How many more steps lead out of the bounds than do not before they count as left: the memory.
pub const BEYOND: u16 = 100;
/// How many times as steep as the mean a muscle is taken to be at the most, where feedback is
/// counted as contraction. Beyond it is what an effect of the speed does where it turns.
const STEEPEST: f64 = 10.0;

/// A contraction is found to this share of half the range, in roundings.
const FOUND: f64 = 1e3;

/// What has been learnt, in halves of the output range.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Change<T> {
    /// How much further the muscle contracts in the middle of its range.
    pub offset: T,
    /// By how much more at the upper end.
    pub gain: T,
    /// By how much more at both ends.
    pub bend: T,
    /// How much further on the way up than in the middle of the loop.
    pub width: T,
    /// By how much more so at the upper end.
    pub flare: T,
}

/// The model's part of an adaptation: where its outputs lie.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Adapter<T> {
    /// Unit: mm.
    middle: T,
    /// Half of the range. Unit: mm.
    half: T,
    /// The largest slope that feedback is counted by. Unit: mm/bar.
    steepest: T,
}

/// What is remembered of an adaptation.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Adapted<T> {
    learnt: [T; LEARNT],
    /// Of them, over that of a step: the inverse of their covariance.
    information: [[T; LEARNT]; LEARNT],
    /// Where the play stands for the reference that is given, and for the one that is due.
    plays: [T; 2],
    /// Of this move; none before the first tick that is trusted.
    gathered: Option<Gathered<T>>,
    steps: u32,
    /// How many more steps led out of the bounds than did not.
    beyond: u16,
}

/// Sums over a move.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Gathered<T> {
    /// The reference at its begin. Unit: mm.
    from: T,
    /// Input (bar) and output (mm) of the inverse there.
    stood: (T, T),
    regressors: [T; LEARNT],
    /// Unit: mm.
    missing: T,
    /// Unit: bar.
    feedback: T,
    ticks: T,
}

impl<T: Real> Default for Adapted<T> {
    /// Nothing has been learnt.
    fn default() -> Self {
        Self {
            learnt: [T::ZERO; LEARNT],
            information: unit(),
            plays: [T::ZERO; 2],
            gathered: None,
            steps: 0,
            beyond: 0,
        }
    }
}

/// The information of one step about each number, on its own.
fn unit<T: Real>() -> [[T; LEARNT]; LEARNT] {
    let mut all = [[T::ZERO; LEARNT]; LEARNT];
    for (place, row) in all.iter_mut().enumerate() {
        row.iter_mut().skip(place).take(1).for_each(|value| *value = T::ONE);
    }
    all
}

impl<T: Real> Adapted<T> {
    /// What has been learnt.
    pub fn change(&self) -> Change<T> {
        let [offset, _, gain, bend, width, flare] = self.learnt;
        Change { offset, gain, bend, width, flare }
    }

    /// How many steps it was learnt in.
    pub fn steps(&self) -> u32 {
        self.steps
    }

    /// Whether the muscle has left the bounds.
    pub fn is_beyond(&self) -> bool {
        self.beyond >= BEYOND
    }

    /// What was gathered since the last step is of no use.
    pub fn interrupt(&mut self) {
        self.gathered = None;
    }
}

/// A tick to learn from.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Lesson<T> {
    /// What was due. Unit: mm.
    pub due: T,
    /// What was measured. Unit: mm.
    pub contraction: T,
    /// What the command has beside the feed-forward. Unit: bar.
    pub feedback: T,
    /// Input (bar) and output (mm) of the inverse.
    pub stands: (T, T),
    /// Whether command and sensors were as the controller takes them to be.
    pub is_trusted: bool,
}

impl<T: Real> Adapter<T> {
    /// That of a model between its outputs (mm) and inputs (bar), each lowest and highest.
    pub fn new((low, high): (T, T), (least, most): (T, T)) -> Self {
        let half = T::from_f64(0.5);
        Self {
            middle: half * (low + high),
            half: half * (high - low),
            steepest: T::from_f64(STEEPEST) * (high - low) / (most - least),
        }
    }

    /// A change in mm in the place of halves of the range.
    pub fn in_mm(&self, change: Change<T>) -> Change<T> {
        let Change { offset, gain, bend, width, flare } = change;
        let mm = |share: T| self.half * share;
        Change { offset: mm(offset), gain: mm(gain), bend: mm(bend), width: mm(width), flare: mm(flare) }
    }

    /// What the model's inverse is to be asked for in the place of a reference. Unit: mm. Once for
    /// each tick. One that is not finite is answered as it is, and changes nothing.
    #[inline(never)]
    pub fn asked(&self, adapted: &mut Adapted<T>, reference: T) -> T {
        if !reference.is_finite() {
            return reference;
        }
        let [given, due] = adapted.plays;
        let (regressors, given) = self.regressors(given, reference);
        adapted.plays = [given, due];
        reference - self.half * dot(&adapted.learnt, &regressors)
    }

    /// A change in halves of the range in the place of mm.
    pub fn in_halves(&self, change: Change<T>) -> Change<T> {
        let Change { offset, gain, bend, width, flare } = change;
        let share = |mm: T| mm / self.half;
        Change {
            offset: share(offset),
            gain: share(gain),
            bend: share(bend),
            width: share(width),
            flare: share(flare),
        }
    }

    /// As if a change (halves of the range) had been learnt, as far as it may be.
    pub fn remembered(&self, change: Change<T>) -> Adapted<T> {
        let Change { offset, gain, bend, width, flare } = change;
        let learnt = self.held(&[offset, T::ZERO, gain, bend, width, flare]);
        Adapted { learnt, ..Adapted::default() }
    }

    /// The contraction (mm) of a muscle that has changed so, where its model answers `model` (mm):
    /// what [`Adapter::asked`] for it is. One that is not finite is answered as it is.
    pub fn answered(&self, adapted: &mut Adapted<T>, model: T) -> T {
        if !model.is_finite() {
            return model;
        }
        let over = |contraction: T| self.asked(&mut adapted.clone(), contraction) - model;
        let from = Point { u: model, f: over(model) };
        let tolerance = T::EPSILON * T::from_f64(FOUND) * self.half;
        let contraction = if from.f == T::ZERO { model } else { root(from, T::ONE, tolerance, over).0 };
        self.asked(adapted, contraction);
        contraction
    }

    /// What the learnt numbers count by at a reference (mm), and where the play stands then.
    fn regressors(&self, play: T, reference: T) -> ([T; LEARNT], T) {
        let rho = ((reference - self.middle) / self.half).limit(-T::ONE, T::ONE);
        let reach = T::from_f64(PLAY);
        let play = play.limit(rho - reach, rho + reach);
        let branch = (rho - play) / reach;
        let bend = rho * rho - T::from_f64(0.5);
        ([T::ONE, T::ZERO, rho, bend, branch, branch * rho], play)
    }

    /// Learns from a tick.
    #[inline(never)]
    pub fn learn(&self, adapted: &mut Adapted<T>, lesson: &Lesson<T>) {
        let Lesson { due, contraction, feedback, stands, is_trusted } = *lesson;
        let missing = contraction - due;
        let is_within = (due - self.middle).abs() < self.half;
        if !(is_trusted && is_within && missing.abs() < T::from_f64(OFFSET) * self.half) {
            adapted.interrupt();
            return;
        }
        let [given, before] = adapted.plays;
        let (regressors, after) = self.regressors(before, due);
        adapted.plays = [given, after];
        let Some(gathered) = &mut adapted.gathered else {
            adapted.gathered = Some(Gathered {
                from: due,
                stood: stands,
                regressors: [T::ZERO; LEARNT],
                missing: T::ZERO,
                feedback: T::ZERO,
                ticks: T::ZERO,
            });
            return;
        };
        gathered.regressors.iter_mut().zip(regressors).for_each(|(sum, new)| *sum += new);
        gathered.missing += missing;
        gathered.feedback += feedback;
        gathered.ticks += T::ONE;
        let moved = (due - gathered.from).abs();
        if moved < T::from_f64(2.0 * MOVE) * self.half {
            return;
        }
        let Gathered { stood, regressors, missing, feedback, ticks, .. } = *gathered;
        adapted.gathered = None;
        let (pushed, went) = (stands.0 - stood.0, stands.1 - stood.1);
        // Where input and output part, as where an effect of the speed turns, no slope can be told.
        let slope = if pushed * went > T::ZERO { went / pushed } else { T::ZERO };
        let moved_by_feedback = feedback * slope.at_most(self.steepest);
        let share = T::ONE / ticks;
        let error = (missing - moved_by_feedback) * share / self.half;
        self.step(adapted, &regressors.map(|sum| sum * share), error);
    }

    /// A step of recursive least squares. `error`: in halves of the output range.
    fn step(&self, adapted: &mut Adapted<T>, regressors: &[T; LEARNT], error: T) {
        let forgotten = T::from_f64(1.0 / MEMORY);
        let mut learnt = adapted.learnt;
        let change = learnt.get(CHANGES).copied().unwrap_or_default();
        learnt.iter_mut().skip(OFFSETS).take(1).for_each(|offset| *offset += change * forgotten);
        let mut information = carried(&adapted.information, forgotten);
        for ((row, kept), of) in information.iter_mut().zip(unit()).zip(regressors) {
            for ((value, kept), with) in row.iter_mut().zip::<[T; LEARNT]>(kept).zip(regressors) {
                *value += forgotten * (kept - *value) + *of * *with;
            }
        }
        let found = solved(&information, &regressors.map(|value| value * error));
        let found = found.filter(|found| found.iter().chain(&learnt).all(|value| value.is_finite()));
        let Some(found) = found else {
            // What was learnt stays; learning begins again.
            *adapted = Adapted { learnt: adapted.learnt, steps: adapted.steps, ..Adapted::default() };
            return;
        };
        learnt.iter_mut().zip(found).for_each(|(value, found)| *value += found);
        let held = self.held(&learnt);
        let beyond = adapted.beyond;
        adapted.beyond = if held == learnt { beyond.saturating_sub(1) } else { beyond.saturating_add(1) };
        (adapted.learnt, adapted.information) = (held, information);
        adapted.steps = adapted.steps.saturating_add(1);
    }

    /// What may be learnt, nearest to what was along the way to nothing.
    ///
    /// The slope of what is asked for over the reference, with |ρ| and |h| at most 1, is at least
    /// 1 − |gain| − 2 |bend| − (|width| + |flare|)/[`PLAY`] − |flare|: in play h has the slope
    /// 1/[`PLAY`], beyond it none.
    fn held(&self, learnt: &[T; LEARNT]) -> [T; LEARNT] {
        let [offset, change, gain, bend, width, flare] = *learnt;
        let two = T::from_f64(2.0);
        let taken =
            gain.abs() + two * bend.abs() + (width.abs() + flare.abs()) / T::from_f64(PLAY) + flare.abs();
        let most = T::from_f64(1.0 - LEFT);
        let share = if taken > most { most / taken } else { T::ONE };
        let bound = T::from_f64(OFFSET);
        let stays = offset.limit(-bound, bound);
        let change = if stays == offset { change } else { T::ZERO };
        [stays, change, gain * share, bend * share, width * share, flare * share]
    }
}

fn dot<T: Real>(a: &[T; LEARNT], b: &[T; LEARNT]) -> T {
    a.iter().zip(b).fold(T::ZERO, |sum, (a, b)| sum + *a * *b)
}

/// The information after a step of the offset by its change: about offset − `by` · change, as it
/// was about the offset.
fn carried<T: Real>(information: &[[T; LEARNT]; LEARNT], by: T) -> [[T; LEARNT]; LEARNT] {
    let mut next = *information;
    let [of_offset, ..] = next;
    let [_, of_change, ..] = &mut next;
    of_change.iter_mut().zip(of_offset).for_each(|(value, offset)| *value -= by * offset);
    for [offset, change, ..] in &mut next {
        *change -= by * *offset;
    }
    next
}

/// x of `matrix` x = `right`, for a symmetric positive definite matrix; none if it is not.
fn solved<T: Real>(matrix: &[[T; LEARNT]; LEARNT], right: &[T; LEARNT]) -> Option<[T; LEARNT]> {
    let (mut matrix, mut right) = (*matrix, *right);
    for place in 0..LEARNT {
        let (pivots, of_pivot) = (*matrix.get(place)?, *right.get(place)?);
        let pivot = *pivots.get(place)?;
        if !pivot.is_finite() || pivot <= T::ZERO {
            return None;
        }
        for (at, (row, value)) in matrix.iter_mut().zip(&mut right).enumerate() {
            let factor = *row.get(place)? / pivot;
            if at == place {
                continue;
            }
            row.iter_mut().zip(pivots).for_each(|(value, by)| *value -= factor * by);
            *value -= factor * of_pivot;
        }
    }
    let mut found = right;
    for (place, (value, row)) in found.iter_mut().zip(&matrix).enumerate() {
        *value = *value / *row.get(place)?;
    }
    Some(found)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A number from −1 to 1, each after the other.
    fn random(seed: &mut u64) -> f64 {
        *seed ^= *seed << 13;
        *seed ^= *seed >> 7;
        *seed ^= *seed << 17;
        (*seed >> 11) as f64 / (1_u64 << 52) as f64 - 1.0
    }

    #[test]
    fn ten_thousand_random_walks_of_what_is_learnt_never_leave_the_invertible_set() {
        let adapter = Adapter::new((-2.0, 122.0), (0.0, 6.0));
        let mut seed = 0x9E37_79B9_7F4A_7C15;
        let (mut at_bound, mut least) = (0, f64::INFINITY);
        for walk in 0..10_000 {
            let mut adapted = Adapted::default();
            for _ in 0..20 {
                let mut wanted = adapted.learnt;
                let sizes = [0.2, 0.1, 0.2, 0.1, 0.05, 0.05];
                wanted.iter_mut().zip(sizes).for_each(|(value, size)| *value += size * random(&mut seed));
                adapted.learnt = adapter.held(&wanted);
                at_bound += i32::from(adapted.learnt != wanted);
            }
            assert!(adapted.change().offset.abs() <= OFFSET);
            // Wherever the reference turns, each step of it is followed, to and fro.
            let mut last: Option<(f64, f64)> = None;
            let mut wanted = 60.0;
            for _ in 0..40 {
                let to = 60.0 + 62.0 * random(&mut seed);
                let steps = 10;
                for _ in 0..steps {
                    wanted += (to - wanted) / 4.0;
                    let asked = adapter.asked(&mut adapted, wanted);
                    if let Some((from, was)) = last {
                        let slope = (asked - was) / (wanted - from);
                        assert!(slope >= LEFT - 1e-9, "walk {walk}: {slope} at {wanted} mm, {adapted:?}");
                        least = least.min(slope);
                    }
                    last = Some((wanted, asked));
                }
            }
        }
        // They do get to the bounds, and the bound is no wider than it has to be.
        assert!(at_bound > 10_000 && least < 1.3 * LEFT, "{at_bound}, {least}");
    }

    #[test]
    fn what_a_changed_muscle_answers_is_asked_for_as_what_its_model_answers() {
        let adapter = Adapter::new((-2.0, 122.0), (0.0, 6.0));
        let mm = Change { offset: 7.0, gain: -4.0, bend: 2.0, width: -1.0, flare: 0.5 };
        let mut adapted = adapter.remembered(adapter.in_halves(mm));
        let (mut seed, mut asking) = (0x2545_F491_4F6C_DD1D, adapted);
        let back = adapter.in_mm(adapted.change());
        assert!((back.offset - 7.0).abs() < 1e-12 && (back.flare - 0.5).abs() < 1e-12);
        for _ in 0..500 {
            let model = 60.0 + 62.0 * random(&mut seed);
            let contraction = adapter.answered(&mut adapted, model);
            assert!((adapter.asked(&mut asking, contraction) - model).abs() < 1e-9, "{contraction} mm");
            assert_eq!(adapted, asking);
        }
    }

    #[test]
    fn beyond_the_range_of_the_model_nothing_is_learnt() {
        let adapter = Adapter::new((0.0, 100.0), (0.0, 5.0));
        let steps = |from: f64| {
            let mut adapted = Adapted::default();
            for tick in 0..200 {
                let due = from + 0.1 * f64::from(tick);
                let (contraction, stands) = (due - 5.0, (0.05 * due, due));
                let lesson = Lesson { due, contraction, feedback: 0.0, stands, is_trusted: true };
                adapter.learn(&mut adapted, &lesson);
            }
            adapted.steps()
        };
        assert_eq!((steps(100.0), steps(-20.1)), (0, 0));
        assert!(steps(70.0) > 10);
    }

    #[test]
    fn linear_equations_are_solved_and_one_without_an_answer_is_refused() {
        let mut seed = 88_172_645_463_325_252;
        let mut matrix = unit::<f64>();
        for _ in 0..12 {
            let row: [f64; LEARNT] = core::array::from_fn(|_| random(&mut seed));
            for (values, of) in matrix.iter_mut().zip(row) {
                values.iter_mut().zip(row).for_each(|(value, with)| *value += of * with);
            }
        }
        let right = [1.0, -2.0, 3.0, 0.5, 0.0, -1.0];
        let found = solved(&matrix, &right).expect("positive definite");
        for (row, wanted) in matrix.iter().zip(right) {
            assert!((dot(row, &found) - wanted).abs() < 1e-12);
        }
        matrix[3][3] = -1.0;
        assert_eq!(solved(&matrix, &right), None);
        matrix[0][0] = f64::NAN;
        assert_eq!(solved(&matrix, &right), None);
    }
}
