//! The search over sets of causes: a beam, then drops and swaps.
//!
//! # Design
//! A set grows by the cause that lowers the held-out error most; the best few sets of each size go on, since the first
//! cause of a true pair is not always the one that gains most alone. All causes of a set are fitted together. At the end
//! causes that a later one has made needless are dropped, and each is tried against all others.

use rayon::prelude::*;

use super::candidate::Candidate;
use super::causes::{Cause, Law};
use super::chance::{FOUND, standard_errors};
use super::effect::{Effect, Form};
use super::fit::fit;
use super::pure_error::pure_error;
use super::race::{Runner, is_same};
use super::regulator;
use super::screen::Screen;
use super::search::{LARGEST, Search};
use super::series::{arrange, beside};

/// What a search has found, and all sets that were looked at, by size.
type Ran = (Candidate, Vec<Vec<Candidate>>);

/// Sets of each size that go on.
const BEAM: usize = 3;
/// Causes that are fitted beside a set, and effects of each.
const PROMISING: usize = 5;
const STARTS: usize = 2;
/// What a cause has to promise, as a share of the sum of squares: far below what any is worth its place for.
const LEAST: f64 = 0.02;
/// The same of a slow cause, as a share of what it has to explain to be worth its place. By first order, in which they are promised, fast
/// ones may show little of what they are.
const PROMISED: f64 = 1.0 / 6.0;
/// The evidence that an effect has to have for it.
pub const EVIDENCE: f64 = 0.12;
/// The same for a delay, a lag or a mass: a misfit of the model's shape hardly ever looks like one of these, so less evidence will do.
const EVIDENCE_OF_FAST: f64 = 0.08;
/// What the held-out error alone has to gain.
const GAIN: f64 = 0.05;
/// How much more evidence one needs beside others, as a share of theirs: what little is left of a large effect that is
/// not quite of our form is still more than nothing.
const MORE: f64 = 0.1;
/// The same of a delay, a lag, a mass.
const MORE_OF_FAST: f64 = 0.05;
/// What a larger set has to be better by than the best smaller one, beside being worth each of its causes.
const BETTER: f64 = 0.05;
/// The least share of the square of the first error that a cause beside others explains.
const SHARE: f64 = 0.03;
/// What it has to gain if it explains less: a cause that removes so much of the remaining error is not just the rest of another cause.
const MUCH: f64 = 0.3;
/// The same of a delay, a lag, a mass, see [`EVIDENCE_OF_FAST`].
const MUCH_OF_FAST: f64 = 0.13;
/// A set that costs more than the best of its size by this is not built upon: of a true pair one cause has always been nearer.
const LEFT_BEHIND: f64 = 1.0;
/// A set that gains less than this over its parent is not built upon.
const HOPELESS: f64 = 0.04;

impl Search<'_> {
    /// The effects that could stand for a cause beside a set.
    fn starts(&self, set: &Candidate, cause: Cause) -> Vec<Effect> {
        beside(&set.fit.effects, cause.starts_beside(self.signals, &set.fit.unseen))
    }

    /// The promising causes beside a set, each with its most promising effects.
    fn promising(&self, set: &Candidate) -> Vec<(Cause, Vec<Effect>)> {
        let Some(screen) = Screen::new(&self.thinned, &self.basis, &set.fit) else { return Vec::new() };
        let others = self.examinable.iter().filter(|cause| !set.causes.contains(cause));
        let mut all: Vec<(f64, Cause, Vec<Effect>)> = others
            .map(|&cause| {
                let promise = |effect: Effect| (screen.promise(&effect), effect);
                let by_promise =
                    |all: &mut Vec<(f64, Effect)>| all.sort_by(|one, other| other.0.total_cmp(&one.0));
                let mut starts: Vec<(f64, Effect)> =
                    self.starts(set, cause).into_iter().map(promise).collect();
                by_promise(&mut starts);
                let mut at = starts.first().map(|(_, effect)| effect.clone());
                while let Some(best) = at {
                    let mut near: Vec<(f64, Effect)> =
                        cause.nearer(&self.thinned, &best).into_iter().map(promise).collect();
                    by_promise(&mut near);
                    at = near.first().map(|(_, effect)| effect.clone());
                    starts.extend(near);
                }
                by_promise(&mut starts);
                let best = starts.first().map_or(0.0, |start| start.0);
                let most =
                    if set.causes.is_empty() && cause.resists_motion() { starts.len() } else { STARTS };
                (best, cause, starts.into_iter().take(most).map(|start| start.1).collect())
            })
            .filter(|(best, cause, _): &(f64, Cause, Vec<Effect>)| {
                let of_slow = if cause.is_fast() { 0.0 } else { explained(self.needed(*cause, set)) };
                *best >= LEAST.max(PROMISED * of_slow)
            })
            .collect();
        all.sort_by(|one, other| other.0.total_cmp(&one.0));
        all.into_iter().take(PROMISING).map(|(_, cause, starts)| (cause, starts)).collect()
    }

    /// A set without one of its causes: the rest fitted from where it stands, or as it was found before if that is better.
    pub fn without(&self, set: &Candidate, cause: Cause, sizes: &[Vec<Candidate>]) -> Option<Candidate> {
        let first = set.fit.effects.len() - set.causes.len();
        let kept = |i: usize| i < first || set.causes[i - first] != cause;
        let mut effects: Vec<Effect> =
            set.fit.effects.iter().enumerate().filter(|(i, _)| kept(*i)).map(|(_, e)| e.clone()).collect();
        if !effects.iter().any(|effect| effect.form == Form::Delay) {
            effects.insert(0, Effect::small_delay(self.signals));
        }
        if regulator::of(&effects).is_none() {
            effects.splice(0..0, self.regulator.clone());
        }
        arrange(&mut effects);
        let causes: Vec<Cause> = set.causes.iter().copied().filter(|&other| other != cause).collect();
        let without = self.candidate(causes, fit(self.signals, &self.basis, &effects)?);
        let before = std::iter::once(&self.baseline).chain(sizes.iter().flatten());
        let alike = before.filter(|set| is_same(&set.causes, &without.causes));
        let better =
            alike.filter(|set| set.cost() < without.cost()).min_by(|a, b| a.cost().total_cmp(&b.cost()));
        Some(better.cloned().unwrap_or(without))
    }

    /// A set with one more cause: the best that was looked at, else what the starts of that cause come to beside the set.
    pub fn with(&self, set: &Candidate, cause: Cause, sizes: &[Vec<Candidate>]) -> Option<Candidate> {
        let wider: Vec<Cause> = set.causes.iter().copied().chain([cause]).collect();
        let alike = sizes.iter().flatten().filter(|other| is_same(&other.causes, &wider));
        let known = alike.min_by(|one, other| one.cost().total_cmp(&other.cost())).cloned();
        let raced = || {
            let runners = self.runners(set, cause, cause.starts(self.signals));
            self.race(runners, f64::INFINITY).into_iter().next()
        };
        known.or_else(raced)
    }

    /// The set that the evidence is for, and all sets that were looked at, by size, the best first.
    ///
    /// It is the best of the largest size that is worth each of its causes, or what is left of one that is not, less those causes
    /// that a later one has made needless, each tried against its closest rivals. No size is looked at beyond one that has no such set.
    ///
    /// `progress` is called with the share of the work that is done.
    pub fn run(&self, progress: &(dyn Fn(f64) + Sync)) -> Ran {
        let mut sizes: Vec<Vec<Candidate>> = Vec::new();
        let mut going = vec![self.baseline.clone()];
        let mut best = (self.baseline.clone(), Vec::new());
        for size in 0..self.largest {
            progress(size as f64 / (self.largest + 1) as f64);
            let distinct = self.grown(&going);
            // Of two fast causes neither need be among the best alone.
            let is_fast = |set: &Candidate| set.causes.iter().all(|cause| cause.is_fast());
            let also = |(rank, set): &(usize, &Candidate)| *rank < BEAM || (size == 0 && is_fast(set));
            let Some(first) = distinct.first() else { break };
            let is_near = |set: &&Candidate| set.cost() < first.cost() + LEFT_BEHIND;
            let chosen = distinct.iter().enumerate().filter(also).map(|(_, set)| set).filter(is_near);
            going = chosen.cloned().collect();
            let before = sizes.last().map_or(&self.baseline, |size: &Vec<Candidate>| &size[0]);
            let hopeless = before.evidence(first) < HOPELESS;
            sizes.push(distinct);
            let smaller = best.0.causes.len();
            best = self.better(best, &sizes);
            // A mass that rings with the force that damps it is one cause still: had it another one beside, that would gain more.
            let is_one = best.0.count() < best.0.causes.len();
            if hopeless || is_one || best.0.causes.len() == smaller {
                break;
            }
        }
        for _ in 0..LARGEST {
            let (set, without) = &best;
            let changed = self.swapped(set, without).or_else(|| self.dropped(set, without).cloned());
            let Some(set) = changed else { break };
            let without = self.without_each(&set, &sizes);
            best = (set, without);
        }
        (best.0, sizes)
    }

    /// Runs the search, and again with the other past of the muscle where the set that was found costs less with that. Returns the search
    /// whose set costs less, and what it has found ([`Self::run`]).
    pub fn run_for_either_past(self, progress: &(dyn Fn(f64) + Sync)) -> (Self, Ran) {
        let (search, found) = self.run_from_best(progress);
        let goes_better = |other: &Self| other.same(&found.0).is_some_and(|set| set.cost() < found.0.cost());
        let Some(other) = search.of_other_past().filter(goes_better) else { return (search, found) };
        let (other, of_other) = other.run_from_best(progress);
        if of_other.0.cost() < found.0.cost() { (other, of_other) } else { (search, found) }
    }

    /// Runs the search; once more where a set without its cause has come down to a better baseline than the first one: beside a bad one
    /// no cause is worth its place, since that has led to the better.
    fn run_from_best(mut self, progress: &(dyn Fn(f64) + Sync)) -> (Self, Ran) {
        let found = self.run(progress);
        if !found.0.causes.is_empty() || !self.is_better(&self.baseline, &found.0) {
            return (self, found);
        }
        self.pure = pure_error(self.signals, &self.basis, &found.0.fit.seen, &found.0.residual);
        self.baseline = found.0;
        let found = self.run(progress);
        (self, found)
    }

    /// The best of the last size that is better than the best smaller set and worth each of its causes, or what is left of one that
    /// is not; else that smaller one.
    fn better(
        &self,
        mut best: (Candidate, Vec<Option<Candidate>>),
        sizes: &[Vec<Candidate>],
    ) -> (Candidate, Vec<Option<Candidate>>) {
        // What comes to more causes than it has is tried against those that do not.
        for comes_to_more in [false, true] {
            let alike = sizes.iter().skip(sizes.len() - 1).flatten();
            let alike = alike.filter(|set| set.comes_to_more() == comes_to_more);
            let better = alike.filter(|set| self.is_better(&best.0, set)).take(BEAM);
            let mut less = Vec::new();
            let mut found = better.cloned().find_map(|set| self.worth(set, sizes, &mut less));
            if found.is_none() {
                // What a larger set comes down to may be none of those that the beam has come by.
                less.retain(|set| self.is_better(&best.0, set));
                found = less.into_iter().find_map(|set| self.worth(set, sizes, &mut Vec::new()));
            }
            best = found.unwrap_or(best);
        }
        best
    }

    /// A set, and what it is without each of its causes; None where one of them is needless, and `less` gets the set without that.
    fn worth(
        &self,
        set: Candidate,
        sizes: &[Vec<Candidate>],
        less: &mut Vec<Candidate>,
    ) -> Option<(Candidate, Vec<Option<Candidate>>)> {
        let without = self.without_each(&set, sizes);
        match self.dropped(&set, &without) {
            None => Some((set, without)),
            Some(needless) => {
                less.push(needless.clone());
                None
            }
        }
    }

    /// Whether a set is better than a smaller one. Where both have or come to as many causes, what a mass costs for the lag that it
    /// contains counts as well.
    fn is_better(&self, smaller: &Candidate, larger: &Candidate) -> bool {
        let is_simpler = smaller.count() < larger.count() && smaller.causes.len() < larger.causes.len();
        let gain = if is_simpler { smaller.evidence(larger) } else { smaller.cost() - larger.cost() };
        gain >= BETTER
    }

    /// The evidence that a cause has to have for it beside a set.
    fn needed(&self, cause: Cause, set: &Candidate) -> f64 {
        let least = if is_distinct(&cause) { EVIDENCE_OF_FAST } else { EVIDENCE };
        least + self.owed(cause, set)
    }

    /// What of its evidence may be due to the others, whose form is not quite ours.
    pub fn owed(&self, cause: Cause, set: &Candidate) -> f64 {
        let more = if is_distinct(&cause) { MORE_OF_FAST } else { MORE };
        more * self.baseline.evidence(set).max(0.0)
    }

    /// Whether a set is worth its last cause beside the others.
    fn is_worth(&self, without: &Candidate, set: &Candidate) -> bool {
        let square = |set: &Candidate| set.score.mean().powi(2);
        let share = (square(without) - square(set)) / square(&self.baseline);
        let last = set.causes.iter().find(|cause| !without.causes.contains(cause));
        let much = if last.is_some_and(is_distinct) { MUCH_OF_FAST } else { MUCH };
        let gain = without.score.gain(&set.score);
        // The evidence that is needed was set for a cause that fits in one way. Of many ways the luckiest gains more by chance: that has to be
        // excluded where the cause does not show by itself.
        let is_beyond_chance = |last: &Cause| {
            let ways = self.examinable.len() * last.hypotheses();
            let least = || standard_errors(FOUND, ways, 1) * without.score.gain_error(&set.score);
            last.hypotheses() == 1 || !set.is_faint() || gain > least()
        };
        last.is_some_and(|last| {
            without.evidence(set) >= self.needed(*last, without) && is_beyond_chance(last)
        }) && gain >= GAIN
            && (without.causes.is_empty() || share >= SHARE || gain >= much)
    }

    /// A set without each of its causes in turn.
    pub fn without_each(&self, set: &Candidate, sizes: &[Vec<Candidate>]) -> Vec<Option<Candidate>> {
        set.causes.par_iter().map(|&cause| self.without(set, cause, sizes)).collect()
    }

    /// The set without its most needless cause, if that is not worth its place.
    fn dropped<'b>(&self, set: &Candidate, without: &'b [Option<Candidate>]) -> Option<&'b Candidate> {
        let least = without.iter().flatten().min_by(|one, other| one.cost().total_cmp(&other.cost()))?;
        (!self.is_worth(least, set)).then_some(least)
    }

    /// The best set with one cause exchanged for a close rival, if that is better.
    pub fn swapped(&self, set: &Candidate, without: &[Option<Candidate>]) -> Option<Candidate> {
        let swaps: Vec<(&Candidate, Cause)> = set
            .causes
            .iter()
            .zip(without)
            .filter_map(|(cause, without)| Some((cause, without.as_ref()?)))
            .flat_map(|(cause, without)| cause.rivals().map(move |rival| (without, rival)))
            .filter(|(_, rival)| self.examinable.contains(rival) && !set.causes.contains(rival))
            .collect();
        swaps
            .par_iter()
            .filter_map(|&(without, rival)| {
                let kept = if set.causes.len() > 1 { without } else { &self.baseline };
                let starts = self.starts(kept, rival);
                self.race(self.runners(kept, rival, starts), f64::INFINITY).into_iter().next()
            })
            .min_by(|one, other| one.cost().total_cmp(&other.cost()))
            .filter(|other| other.cost() < set.cost() - 1e-3)
    }

    /// The sets of one cause more than these, the best first.
    fn grown(&self, going: &[Candidate]) -> Vec<Candidate> {
        let runners: Vec<Runner> = going
            .par_iter()
            .flat_map_iter(|set| {
                let promising = self.promising(set).into_iter();
                promising.flat_map(move |(cause, starts)| self.runners(set, cause, starts))
            })
            .collect();
        self.race(runners, going.first().map_or(f64::INFINITY, |best| self.bar(best)))
    }
}

/// Whether next to no misfit of shape looks like a cause.
fn is_distinct(cause: &Cause) -> bool {
    cause.is_fast() && cause.law() != Law::Width
}

/// The share of the sum of squares that an evidence comes to, which is a difference of logarithms of errors.
fn explained(evidence: f64) -> f64 {
    -(-2.0 * evidence).exp_m1()
}

#[cfg(test)]
mod tests {
    use super::explained;

    #[test]
    fn half_of_the_error_is_three_quarters_of_its_square() {
        assert!((explained(2.0_f64.ln()) - 0.75).abs() < 1e-12);
    }
}
