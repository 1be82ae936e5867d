//! Learning over repetitions: what has to be added to a reference so that the contraction is where
//! the reference says.
//!
//! After each pass the error is added to what was added before, and both go through a low pass that
//! shifts nothing in time ([`crate::zero_phase`]), of the corner up to which learning converges
//! over everything that the plant may be ([`crate::Tuning`]'s `learning_hz`). What is above it,
//! noise for the most part, is not learnt.
//!
//! # Contract
//! The best pass is kept. A pass whose error is larger than the best one's by more than
//! [`GROWTH`] ends the learning: what was added in the best pass is what stays.

use recording::numbers::root_mean_square;

use crate::zero_phase::filtered;

/// By which share an error may be larger than the best one before the learning ends: what the noise
/// of a sensor makes of one pass beside the next.
pub const GROWTH: f64 = 0.05;

/// What a pass came to.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Pass {
    /// Root mean square of its error. Output unit.
    pub rmse: f64,
    /// The largest. Output unit.
    pub largest: f64,
}

impl Pass {
    /// Of its error, a value a tick.
    fn of(error: &[f64]) -> Self {
        let largest = error.iter().fold(0.0_f64, |most, error| most.max(error.abs()));
        Self { rmse: root_mean_square(error), largest }
    }
}

/// What follows from a pass.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Next {
    /// Another pass may be better.
    Learn,
    /// The error has grown: the best pass stays, and nothing more is learnt.
    Ended,
}

/// A learner for one reference.
#[derive(Clone, Debug)]
pub struct Learner {
    correction: Vec<f64>,
    best: Option<(Vec<f64>, Pass)>,
    passes: Vec<Pass>,
    period_s: f64,
    corner_hz: f64,
    has_ended: bool,
}

impl Learner {
    /// For a reference of so many ticks of a period (s); `corner_hz`: up to where it learns, Hz.
    pub fn new(ticks: usize, period_s: f64, corner_hz: f64) -> Self {
        Self::from(vec![0.0; ticks], period_s, corner_hz)
    }

    /// One that goes on from a correction.
    pub fn from(correction: Vec<f64>, period_s: f64, corner_hz: f64) -> Self {
        // Up to 0 Hz nothing is learnt.
        let has_ended = corner_hz <= 0.0;
        Self { correction, best: None, passes: Vec::new(), period_s, corner_hz, has_ended }
    }

    /// What the next pass adds to the reference, a value a tick. Output unit.
    pub fn correction(&self) -> &[f64] {
        &self.correction
    }

    /// What was added in the best pass.
    pub fn best(&self) -> &[f64] {
        self.best.as_ref().map_or(&self.correction, |(correction, _)| correction)
    }

    /// The passes so far.
    pub fn passes(&self) -> &[Pass] {
        &self.passes
    }

    /// Notes a pass from which nothing is learnt; arguments as of [`Self::learn`].
    pub fn note(&mut self, error: &[f64]) -> Next {
        self.passes.push(Pass::of(error));
        Next::Learn
    }

    /// Brings what the next pass adds within limits: what becomes of a tick's.
    pub fn limit(&mut self, limited: impl Fn(usize, f64) -> f64) {
        self.correction.iter_mut().enumerate().for_each(|(tick, added)| *added = limited(tick, *added));
    }

    /// Takes the error of a pass (reference less contraction, a value a tick, output unit).
    /// Errors that are not finite count as grown.
    pub fn learn(&mut self, error: &[f64]) -> Next {
        let pass = Pass::of(error);
        self.passes.push(pass);
        let is_whole = error.len() == self.correction.len() && pass.rmse.is_finite();
        let has_grown =
            self.best.as_ref().is_some_and(|(_, best)| pass.rmse > (1.0 + GROWTH) * best.rmse) || !is_whole;
        if has_grown || self.has_ended {
            self.has_ended = true;
            self.correction = self.best().to_vec();
            return Next::Ended;
        }
        if self.best.as_ref().is_none_or(|(_, best)| pass.rmse < best.rmse) {
            self.best = Some((self.correction.clone(), pass));
        }
        let sum: Vec<f64> = self.correction.iter().zip(error).map(|(added, error)| added + error).collect();
        self.correction = filtered(&sum, self.period_s, self.corner_hz);
        Next::Learn
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The error of a muscle that answers a reference with a lag that repeats, and so many times
    /// too strongly.
    fn pass(correction: &[f64], gain: f64) -> Vec<f64> {
        let reference = |k: usize| 20.0 * (std::f64::consts::TAU * 1e-3 * k as f64 / 2.0).sin();
        let mut last = 0.0;
        (0..correction.len())
            .map(|k| {
                last += 0.02 * (gain * (reference(k) + correction[k]) - last);
                reference(k) - last
            })
            .collect()
    }

    #[test]
    fn what_repeats_is_learnt() {
        let mut learner = Learner::new(4000, 1e-3, 3.0);
        for _ in 0..6 {
            let error = pass(learner.correction(), 1.0);
            assert_eq!(learner.learn(&error), Next::Learn);
        }
        let (first, last) = (learner.passes()[0].rmse, learner.passes()[5].rmse);
        assert!(last < 0.1 * first, "{first} {last}");
    }

    #[test]
    fn an_error_that_grows_ends_the_learning_and_the_best_pass_stays() {
        let mut learner = Learner::new(4000, 1e-3, 3.0);
        // Three times too strong: each pass overshoots by more than the last.
        let mut ended = false;
        for _ in 0..10 {
            let error = pass(learner.correction(), 3.0);
            ended |= learner.learn(&error) == Next::Ended;
        }
        assert!(ended);
        let best = learner.passes().iter().map(|pass| pass.rmse).fold(f64::INFINITY, f64::min);
        let again = pass(learner.best(), 3.0);
        let squares: f64 = again.iter().map(|error| error * error).sum();
        assert!(((squares / again.len() as f64).sqrt() - best).abs() < 1e-9);
        assert_eq!(learner.correction(), learner.best());
    }

    #[test]
    fn a_broken_pass_spoils_nothing() {
        let mut learner = Learner::new(100, 1e-3, 3.0);
        learner.learn(&[1.0; 100]);
        assert_eq!(learner.learn(&[f64::NAN; 100]), Next::Ended);
        assert!(learner.correction().iter().all(|added| *added == 0.0));
    }

    #[test]
    fn where_no_frequency_may_be_learnt_from_nothing_is_learnt() {
        let mut learner = Learner::new(100, 1e-3, 0.0);
        assert_eq!(learner.learn(&[1.0; 100]), Next::Ended);
        assert!(learner.correction().iter().all(|added| *added == 0.0));
        assert_eq!(learner.passes().len(), 1);
    }
}
