//! Sets of causes that the search hardly tells apart, told apart by the operator model that runs free.
//!
//! # Design
//! The baseline of the search is linear in its weights, may take the form of any hysteresis, and sees the measured rate: it is fitted in
//! no time, and errs by more than an operator model does that has the right cause. Where two sets are near each other by that
//! baseline, the operator model is refined with each, over all rows, and its error decides beside what the search says. On strong
//! single causes nothing is near, and nothing is lost but the question.
//!
//! Only beside single causes: with two the refinement takes longer than the whole search, and says little on the rig, whose forms are not
//! those of the model.
//!
//! Two judges that differ tell neither: a rival with which the simulated model is nearer than with the set that the search is for is not
//! told from it, nor is a larger set that the search alone finds better by more than chance.
//!
//! A larger set is a rival too where the search finds it far better and has only doubted that the last cause is worth its place: if
//! that is a fast one, and the operator model is far better with it.

use rayon::prelude::*;

use super::candidate::Candidate;
use super::causes::Cause;
use super::chance::{FOUND, standard_errors};
use super::extend::{Extender, Extension};
use super::gain::differ_less_than_misfit;
use super::race::is_same;
use super::search::Search;
use super::valve::ValvePart;
use recording::numbers::legible;

/// Sets whose costs differ by more than this are told apart by the search.
const NEAR: f64 = 0.15;
/// Rivals at most.
const MOST: usize = 3;
/// What the logarithm of the operator model's error weighs beside the cost of the search.
const FREE: f64 = 2.0;
/// A larger set costs less by this.
const FAR: f64 = 0.1;
/// The operator model has at most this share of its error with it.
const LEAVES: f64 = 0.7;
/// The operator model decides where its error is at most this many times that of the search's own simulation.
pub(super) const TRUSTED: f64 = 1.1;
/// Sets whose costs differ by less than this cannot be told apart.
const APART: f64 = 0.04;
/// A rival has at least this share of the evidence of the best set.
const SAYS: f64 = 0.7;

/// The set that is left, and those that are not told apart from it.
pub struct Settled {
    /// The set.
    pub set: Candidate,
    /// The others.
    pub alternatives: Vec<Vec<Cause>>,
    /// What the operator model says for it, in words, if that was asked.
    pub evidence: Option<String>,
}

/// Settles between a set and its rivals among those that were looked at: by the operator model that runs free with each, if
/// it can, else by the search alone.
pub fn settled(
    search: &Search<'_>,
    (best, sizes): (&Candidate, &[Vec<Candidate>]),
    extender: &Extender<'_>,
) -> Settled {
    let by_cost = |one: &&Candidate, other: &&Candidate| one.cost().total_cmp(&other.cost());
    let mut alike: Vec<&Candidate> = sizes.iter().flatten().filter(|set| is_rival(best, set)).collect();
    alike.sort_by(by_cost);
    let larger = sizes.iter().flatten().filter(|set| is_larger_rival(best, set)).min_by(by_cost);
    let mut settled = running_free(search, (best, &alike, larger), extender).unwrap_or_else(|| {
        let is_as_good = |set: &&&Candidate| {
            set.causes.len() <= best.causes.len()
                && (set.cost() - best.cost()).max(set.evidence(best)) < APART
                && says_enough(search, best, set)
        };
        Settled {
            set: best.clone(),
            alternatives: alike.iter().filter(is_as_good).map(|set| set.names()).collect(),
            evidence: None,
        }
    });
    let Settled { set, alternatives, .. } = &mut settled;
    let untold = not_told_apart(search, (set, &set.causes), sizes);
    let nearer = nearer_when_simulated(set, sizes, extender);
    untold.into_iter().chain(nearer).for_each(|rival| {
        if !alternatives.iter().any(|other| is_same(other, &rival)) {
            alternatives.push(rival);
        }
    });
    settled
}

/// The rivals of a chosen set, no larger than it, with which the simulated operator model is nearer to the muscle, by more than the
/// standard error: two judges that are for different sets tell neither of them.
fn nearer_when_simulated(
    set: &Candidate,
    sizes: &[Vec<Candidate>],
    extender: &Extender<'_>,
) -> Vec<Vec<Cause>> {
    if set.causes.is_empty() {
        return Vec::new();
    }
    let is_rival = |rival: &&Candidate| {
        rival.shows()
            && rival.outlasts()
            && rival.count() <= set.count()
            && !is_within(rival, set)
            && !is_within(set, rival)
    };
    let mut rivals: Vec<&Candidate> = sizes.iter().flatten().filter(is_rival).collect();
    rivals.sort_by(|one, other| one.cost().total_cmp(&other.cost()));
    rivals.truncate(MOST);
    let sets: Vec<&Candidate> = [set].into_iter().chain(rivals).collect();
    let models: Vec<Option<Extension>> = sets.par_iter().map(|set| extender.model(set)).collect();
    let Some((Some(own), others)) = models.split_first() else { return Vec::new() };
    let is_nearer = |model: &Option<Extension>| {
        let gain = model.as_ref().and_then(|model| extender.gain_between(own, model));
        gain.is_some_and(|gain| gain.is_sure())
    };
    let nearer = sets[1..].iter().zip(others).filter(|(_, model)| is_nearer(model));
    nearer.map(|(rival, _)| rival.names()).collect()
}

/// The sets that the search does not tell apart from a chosen one, of whose causes these are named: none where none is.
pub fn not_told_apart(
    search: &Search<'_>,
    (set, named): (&Candidate, &[Cause]),
    sizes: &[Vec<Candidate>],
) -> Vec<Vec<Cause>> {
    // All that the recording can show are asked, though few look so promising that they are fitted.
    let asked = search.examinable.iter().filter(|cause| !named.contains(cause)).count();
    let gains = |less: &Candidate, larger: &Candidate| {
        let more = larger.causes.iter().filter(|cause| !less.causes.contains(cause));
        let hypotheses: usize = more.map(|cause| cause.hypotheses()).product();
        let beyond_chance = standard_errors(FOUND, asked * hypotheses, 1);
        less.score.gain(&larger.score) > beyond_chance * less.score.gain_error(&larger.score)
    };
    // What the baseline gains where the larger set has led it is no gain of its causes.
    let less = |larger: &Candidate| {
        let more = larger.causes.iter().filter(|cause| !set.causes.contains(cause));
        more.copied().try_fold(larger.clone(), |less, cause| search.without(&less, cause, sizes))
    };
    let is_better = |larger: &Candidate| {
        is_larger((set, named), larger)
            && gains(set, larger)
            && less(larger).is_some_and(|less| gains(&less, larger))
    };
    let untold = |rival: &&Candidate| is_untold(search, (set, named), rival) || is_better(rival);
    let untold = sizes.iter().flatten().filter(|_| !named.is_empty()).filter(untold);
    untold.map(Candidate::names).collect()
}

/// Whether a rival with no more causes is not told apart from the chosen set: its error on blocks that no fit has seen is larger by no
/// more than the standard error of that difference; or, where it comes to fewer names, by less than the misfit of the chosen set, which is
/// its error beyond the noise: a model that is so far from the muscle does not show that the simpler form is wrong, however small the noise
/// is. A damped mass is one cause under two names: that a delay has one makes it the simpler one, and no proof. But it is no rival of
/// the lag that it has in it.
pub(super) fn is_untold(
    search: &Search<'_>,
    (set, named): (&Candidate, &[Cause]),
    rival: &Candidate,
) -> bool {
    let is_rival = rival.shows()
        && rival.outlasts()
        && rival.causes.len() <= set.causes.len()
        && !named.iter().all(|cause| rival.names().contains(cause))
        && !has_all(&rival.causes, set);
    let is_by_chance = || rival.score.gain(&set.score) <= rival.score.gain_error(&set.score);
    let is_simpler = || {
        rival.count() < set.count()
            && differ_less_than_misfit(set.score.mean(), rival.score.mean(), search.signals.noise)
            && says_enough(search, set, rival)
    };
    is_rival && (is_by_chance() || is_simpler())
}

/// Of causes that an excitation shows alike.
#[derive(Default)]
pub struct Alike {
    /// Sets with another one of them in the place of one of a chosen set, which the search does not tell from it beyond chance.
    pub untold: Vec<Vec<Cause>>,
    /// Those that it does, and the set's own.
    pub told: Vec<Cause>,
}

/// Tries the causes of a `group` that the excitation shows alike in the place of those that a set has of it: between them less is by
/// chance than between others.
pub fn alike(search: &Search<'_>, set: &Candidate, group: &[Cause], sizes: &[Vec<Candidate>]) -> Alike {
    let has = |cause: &&Cause| set.causes.contains(cause);
    let others: Vec<Cause> = group.iter().filter(|cause| !has(cause)).copied().collect();
    let beyond_chance = standard_errors(FOUND, others.len(), 1);
    let mut alike = Alike::default();
    for &own in group.iter().filter(has) {
        let Some(kept) = search.without(set, own, sizes) else { continue };
        let rivals = others.par_iter().map(|&other| (other, search.with(&kept, other, sizes)));
        for (other, rival) in rivals.collect::<Vec<_>>() {
            let is_untold = |rival: &Candidate| {
                let gain = rival.score.gain(&set.score);
                rival.shows()
                    && rival.outlasts()
                    && gain <= beyond_chance * rival.score.gain_error(&set.score)
            };
            match rival.filter(is_untold) {
                Some(rival) => alike.untold.push(rival.names()),
                None => alike.told.extend([own, other]),
            }
        }
    }
    alike
}

/// Sets with the valve's lag in the place of a fast cause, or with a fast one in the place of that, which explain a recording of the command
/// as well within the misfit of the set. A regulator has a form of its own, which nobody has seen: what is late by it may be late in the muscle.
pub fn alike_in_chain(search: &Search<'_>, set: &Candidate, sizes: &[Vec<Candidate>]) -> Vec<Vec<Cause>> {
    let is_lag = |cause: &Cause| matches!(cause.about().in_valve, Some((ValvePart::Lag, _)));
    let is_new = |cause: &Cause| !set.causes.contains(cause);
    let others = |own: Cause| {
        let takes_place = move |cause: &Cause| if is_lag(&own) { cause.is_fast() } else { is_lag(cause) };
        search.examinable.iter().copied().filter(is_new).filter(takes_place)
    };
    let own = set.causes.iter().copied().filter(|cause| cause.is_fast() || is_lag(cause));
    let pairs: Vec<(Cause, Cause)> = own.flat_map(|own| others(own).map(move |other| (own, other))).collect();
    let exchanged = pairs.into_par_iter().filter_map(|(own, other)| {
        let rival = search.with(&search.without(set, own, sizes)?, other, sizes)?;
        let is_untold = rival.shows()
            && rival.outlasts()
            && differ_less_than_misfit(set.score.mean(), rival.score.mean(), search.signals.noise);
        is_untold.then(|| rival.names())
    });
    exchanged.collect()
}

/// Whether a set has all named causes and more.
fn is_larger((set, named): (&Candidate, &[Cause]), larger: &Candidate) -> bool {
    larger.shows()
        && larger.outlasts()
        && larger.causes.len() > named.len()
        && has_all(named, larger)
        && !is_same(&set.causes, &larger.causes)
}

/// What the operator model makes of a set, of those alike, and of a larger one; None where there are no others, or where the model is
/// not as near with the first or the best of them as the search has come: its form is then too far from the muscle's to decide.
fn running_free(
    search: &Search<'_>,
    (best, alike, larger): (&Candidate, &[&Candidate], Option<&Candidate>),
    extender: &Extender<'_>,
) -> Option<Settled> {
    let mut alike: Vec<&Candidate> = [best].into_iter().chain(alike.iter().copied().take(MOST)).collect();
    if best.causes.len() > 1 || alike.len() == 1 && larger.is_none() {
        return None;
    }
    let errors_of = |sets: &[&Candidate]| -> Vec<f64> {
        sets.par_iter().map(|set| extender.with(set).unwrap_or(f64::INFINITY)).collect()
    };
    let mut errors = errors_of(&[best].into_iter().chain(larger).collect::<Vec<_>>());
    // Where the larger one is far better than the best, those alike need not be asked.
    match errors.get(1).is_some_and(|larger| *larger < LEAVES * errors[0]) {
        true => alike.truncate(1),
        false => drop(errors.splice(1..1, errors_of(&alike[1..]))),
    }
    let sets: Vec<&Candidate> = alike.iter().copied().chain(larger).collect();
    let costs: Vec<f64> = alike.iter().zip(&errors).map(|(set, error)| total(set.cost(), *error)).collect();
    let place = decided(&costs, &errors)?;
    let set = sets[place];
    if [0, place].iter().any(|&one| errors[one] > TRUSTED * sets[one].simulated_error()) {
        return None;
    }
    let is_as_good = |&other: &usize| {
        other != place && costs[other] < costs[place] + APART && says_enough(search, set, alike[other])
    };
    let as_good =
        if place < costs.len() { (0..costs.len()).filter(is_as_good).collect() } else { Vec::new() };
    let others = (0..sets.len()).filter(|&other| other != place);
    let next = others.min_by(|&one, &other| errors[one].total_cmp(&errors[other]))?;
    Some(Settled {
        set: set.clone(),
        alternatives: as_good.into_iter().map(|other| alike[other].names()).collect(),
        evidence: Some(format!(
            "simulated, the operator model with {} is off by {} over all rows, with {} by {} {}",
            names(set),
            legible(errors[place], 3),
            names(sets[next]),
            legible(errors[next], 3),
            extender.output_unit()
        )),
    })
}

/// What a set costs by the search and by the error of the operator model.
fn total(cost: f64, error: f64) -> f64 {
    cost + FREE * error.max(1e-12).ln()
}

/// The place of the least of the costs, or the one behind them if the model has so much less of an error there.
fn decided(costs: &[f64], errors: &[f64]) -> Option<usize> {
    let (alike, _) = costs.iter().enumerate().min_by(|one, other| one.1.total_cmp(other.1))?;
    let is_larger = errors.get(costs.len()).is_some_and(|larger| *larger < LEAVES * errors[alike]);
    Some(if is_larger { costs.len() } else { alike })
}

/// Whether a rival of the best set has something to say itself.
fn says_enough(search: &Search<'_>, best: &Candidate, rival: &Candidate) -> bool {
    search.baseline.evidence(rival) > SAYS * search.baseline.evidence(best)
}

/// Whether a set may stand in the place of the best one.
fn is_rival(best: &Candidate, set: &Candidate) -> bool {
    set.shows()
        && !best.causes.is_empty()
        && set.count() <= best.count()
        && !is_within(set, best)
        && !is_within(best, set)
        && set.cost() - best.cost() < NEAR
}

/// Whether a set has a fast cause more, and has been dropped though it costs far less.
fn is_larger_rival(best: &Candidate, set: &Candidate) -> bool {
    let more = || set.causes.iter().filter(|cause| !best.causes.contains(cause));
    set.shows()
        && best.causes.len() == 1
        && is_within(best, set)
        && set.count() > best.count()
        && more().count() == 1
        && more().all(|cause| cause.is_fast())
        && set.cost() < best.cost() - FAR
}

/// Whether all causes of a set are in another one.
fn is_within(one: &Candidate, other: &Candidate) -> bool {
    has_all(&one.causes, other)
}

/// Whether a set has all of these causes.
fn has_all(causes: &[Cause], set: &Candidate) -> bool {
    causes.iter().all(|cause| set.causes.contains(cause))
}

fn names(set: &Candidate) -> String {
    let names: Vec<&str> = set.causes.iter().map(|cause| cause.name()).collect();
    names.join(" and ")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn of_sets_near_each_other_the_one_is_left_that_the_free_running_model_errs_less_with() {
        let costs = [total(0.0, 0.155), total(0.05, 0.087)];
        assert_eq!(decided(&costs, &[0.155, 0.087]), Some(1));
    }

    #[test]
    fn a_model_that_does_not_run_decides_for_the_others() {
        let costs = [total(0.0, f64::INFINITY), total(0.1, 0.3)];
        assert_eq!(decided(&costs, &[f64::INFINITY, 0.3]), Some(1));
    }

    #[test]
    fn a_larger_set_has_to_leave_far_less() {
        assert_eq!(decided(&[0.0], &[0.90, 0.45]), Some(1));
        assert_eq!(decided(&[0.0], &[0.68, 0.52]), Some(0));
    }
}
