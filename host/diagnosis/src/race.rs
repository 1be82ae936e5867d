//! Many starts, few finishes: sets of causes are begun from several starts each on a thinned recording, and only those that do
//! well early are fitted on the whole one.

use rayon::prelude::*;

use super::candidate::Candidate;
use super::causes::{Cause, Law};
use super::effect::{Effect, Form};
use super::fit::{Descent, Fit, fit};
use super::regulator;
use super::search::{Search, WIDTHS};
use super::series::arrange;
use super::swing::Running;

/// Heats: the steps since the start, and how many starts of a set go on then.
const HEATS: [(usize, usize); 2] = [(1, 6), (3, 3)];
/// Sets that are fitted to the end.
const SETS: usize = 8;
/// Fits of the same effects whose root mean squares differ by less than this share are the same.
const SAME: f64 = 2.5e-3;
/// Of ends with the same effects those are tuned whose sums of squares, running free, are within so many times the best one's.
const NEAR: f64 = 1.2;
/// Of sets with more causes than this the best one alone.
const NEAR_UP_TO: usize = 2;
/// A start whose sum of squares is more than so many times the best one's is not fitted to the end, of two causes and of more: running
/// free costs a set less than that. Of single causes all are, since a pair may begin with any.
const BEHIND: [f64; 2] = [4.0, 2.0];
/// Of sets of three those are fitted to the end that have come to less than this share of the best pair's sum of squares: to be worth its
/// place the third cause has to take away more. As many steps are made for the pair. Of pairs all go on: what a single cause is has
/// often been found best by way of one.
const LESS: f64 = 0.92;
/// Sets, beside the best one, that are tried with its nuisances.
const BORROWERS: usize = 2;
/// Delays that a pair begins from lie from the first to below the second. Unit: s.
const DELAYS_S: [f64; 2] = [0.03, 0.2];

/// A set of causes at a start.
pub struct Runner {
    causes: Vec<Cause>,
    /// Nuisances, then an effect a cause.
    effects: Vec<Effect>,
}

impl Search<'_> {
    /// The starts of a set with one more cause, which these effects could stand for.
    pub fn runners(&self, set: &Candidate, cause: Cause, starts: Vec<Effect>) -> Vec<Runner> {
        let causes: Vec<Cause> = set.causes.iter().copied().chain([cause]).collect();
        let of_start = |start: Effect| {
            let is_regulator = |effect: &Effect| regulator::valve(effect).is_some();
            let replaces = |effect: &Effect| {
                start.form == Form::Delay && effect.form == Form::Delay
                    || is_regulator(&start) && is_regulator(effect)
            };
            let mut effects: Vec<Effect> =
                set.fit.effects.iter().filter(|effect| !replaces(effect)).cloned().collect();
            effects.push(start);
            // Envelope and width of the baseline may have tried to be what the cause is: from their starts once more.
            let mut restarted = effects.clone();
            lend(&Effect::nuisances(self.signals, WIDTHS[0], None), &mut restarted);
            let pairs = self.pairs(set, &restarted);
            [effects, restarted].into_iter().chain(pairs)
        };
        let runner = |mut effects: Vec<Effect>| {
            arrange(&mut effects);
            Runner { causes: causes.clone(), effects }
        };
        starts.into_iter().flat_map(of_start).map(runner).collect()
    }

    /// A pair of fast causes from the starts of the first one: alone it has tried to be both.
    fn pairs(&self, set: &Candidate, pair: &[Effect]) -> Vec<Vec<Effect>> {
        let [cause] = set.causes[..] else { return Vec::new() };
        let place = pair.len() - 2;
        if !cause.is_fast() {
            return Vec::new();
        }
        let is_near = |start: &Effect| {
            start.form != Form::Delay || (DELAYS_S[0]..DELAYS_S[1]).contains(&start.parameters[0].value)
        };
        let with_start = |start: Effect| {
            let mut effects = pair.to_vec();
            effects[place] = start;
            effects
        };
        cause.starts(self.signals).into_iter().filter(is_near).map(with_start).collect()
    }

    /// What sets with one more cause than this have to come below in the heats: a sum of squares.
    pub fn bar(&self, set: &Candidate) -> f64 {
        let [.., (steps, _)] = HEATS;
        let squares = |mut descent: Descent<'_>| {
            descent.advance(steps);
            LESS * descent.squares()
        };
        let descent = || Descent::new(&self.thinned, &self.basis, set.fit.effects.clone());
        (set.causes.len() > 1).then(descent).flatten().map_or(f64::INFINITY, squares)
    }

    /// The sets of these starts whose sums of squares come to less than `most` in the heats, fitted and judged, the best first.
    pub fn race(&self, runners: Vec<Runner>, most: f64) -> Vec<Candidate> {
        let start =
            |Runner { causes, effects }| Some((causes, Descent::new(&self.thinned, &self.basis, effects)?));
        let mut running: Vec<(Vec<Cause>, Descent<'_>)> = runners.into_par_iter().filter_map(start).collect();
        let mut sets: Vec<(Vec<Cause>, usize)> = Vec::new();
        for (steps, going) in HEATS {
            running.par_iter_mut().for_each(|(_, descent)| descent.advance(steps));
            running.sort_by(|one, other| one.1.squares().total_cmp(&other.1.squares()));
            sets.clear();
            running.retain(|(causes, _)| match sets.iter_mut().find(|(set, _)| is_same(set, causes)) {
                Some((_, count)) => {
                    *count += 1;
                    *count <= going
                }
                None => {
                    sets.push((causes.clone(), 1));
                    true
                }
            });
        }
        running.retain(|(causes, descent)| descent.squares() < most || is_viscous_width(causes));
        let best = running.first().map_or(0.0, |(_, descent)| descent.squares());
        sets.truncate(SETS);
        running.retain(|(causes, descent)| {
            let times = match causes.len() {
                1 => f64::INFINITY,
                2 => BEHIND[0],
                _ => BEHIND[1],
            };
            descent.squares() <= times * best && sets.iter().any(|(set, _)| is_same(set, causes))
        });
        let finished: Vec<(Vec<Cause>, Fit)> = running
            .into_par_iter()
            .filter_map(|(causes, descent)| {
                Some((causes, fit(self.signals, &self.basis, descent.effects())?))
            })
            .collect();
        let mut found: Vec<Candidate> = self
            .worth_tuning(finished)
            .into_par_iter()
            .map(|(causes, running)| self.judged(causes, running))
            .collect();
        let sort =
            |found: &mut Vec<Candidate>| found.sort_by(|one, other| one.cost().total_cmp(&other.cost()));
        sort(&mut found);
        // The same set may be reached by several ways: the best is kept.
        let mut distinct: Vec<Candidate> = Vec::new();
        for candidate in found {
            if !distinct.iter().any(|other| is_same(&other.causes, &candidate.causes)) {
                distinct.push(candidate);
            }
        }
        self.borrow(&mut distinct);
        sort(&mut distinct);
        distinct
    }

    /// Of the ends of starts each once, and, of those with the same effects, none that runs free far worse than another.
    fn worth_tuning(&self, mut finished: Vec<(Vec<Cause>, Fit)>) -> Vec<(Vec<Cause>, Running)> {
        finished.sort_by(|one, other| one.1.rms().total_cmp(&other.1.rms()));
        let mut ends: Vec<(Vec<Cause>, Fit)> = Vec::new();
        for (causes, fit) in finished {
            let is_same =
                |(_, other): &(_, Fit)| fit.rms() < (1.0 + SAME) * other.rms() && has_forms_of(&fit, other);
            if !ends.iter().any(is_same) {
                ends.push((causes, fit));
            }
        }
        let running: Vec<(Vec<Cause>, Running)> = ends
            .into_par_iter()
            .map(|(causes, fit)| (causes, Running::of(self.signals, &self.basis, fit)))
            .collect();
        let is_far = |(causes, one): &(Vec<Cause>, Running)| {
            let times = if causes.len() > NEAR_UP_TO { 1.0 } else { NEAR };
            let is_behind = |other: &Running| one.squares() > times * other.squares();
            // What runs out of all bounds may be tuned back into them.
            let is_bounded = one.squares().is_finite();
            is_bounded
                && running.iter().any(|(_, other)| is_behind(other) && has_forms_of(&one.fit, &other.fit))
        };
        let far: Vec<bool> = running.iter().map(is_far).collect();
        running.into_iter().zip(far).filter(|(_, is_far)| !is_far).map(|(one, _)| one).collect()
    }

    /// A set of another baseline, fitted beside this one.
    pub fn same(&self, set: &Candidate) -> Option<Candidate> {
        let mut effects = set.fit.effects.clone();
        lend(&self.baseline.fit.effects, &mut effects);
        Some(self.candidate(set.causes.clone(), fit(self.signals, &self.basis, &effects)?))
    }

    /// The sets after the best one from where its nuisances stand: a tie is not to be decided by those.
    fn borrow(&self, sets: &mut [Candidate]) {
        let Some((best, others)) = sets.split_first_mut() else { return };
        others.par_iter_mut().take(BORROWERS).for_each(|set| {
            let mut effects = set.fit.effects.clone();
            lend(&best.fit.effects, &mut effects);
            let other = fit(self.signals, &self.basis, &effects);
            let other = other.map(|fit| self.candidate(set.causes.clone(), fit));
            if let Some(other) = other.filter(|other| other.cost() < set.cost()) {
                *set = other;
            }
        });
    }
}

/// Puts the envelope and the width of one set into another.
fn lend(from: &[Effect], to: &mut [Effect]) {
    let lent = from.iter().filter(|effect| matches!(effect.form, Form::Envelope | Form::Width));
    for nuisance in lent {
        if let Some(standing) = to.iter_mut().find(|effect| effect.form == nuisance.form) {
            *standing = nuisance.clone();
        }
    }
}

/// Whether these have a width and a viscous force, which may have taken the other's part, see [`Candidate::with_viscosity`].
fn is_viscous_width(causes: &[Cause]) -> bool {
    [Law::Width, Law::Viscosity].iter().all(|law| causes.iter().any(|cause| cause.law() == *law))
}

/// Whether two fits have the same effects, in whatever order.
fn has_forms_of(one: &Fit, other: &Fit) -> bool {
    let has = |effect: &Effect| other.effects.iter().any(|other| other.form == effect.form);
    one.effects.len() == other.effects.len() && one.effects.iter().all(has)
}

/// Whether the causes are the same, in whatever order.
pub(crate) fn is_same(one: &[Cause], other: &[Cause]) -> bool {
    one.len() == other.len() && one.iter().all(|cause| other.contains(cause))
}
