//! A cause that acts at once and that the search has overlooked.
//!
//! The baseline of the search is linear in its weights and errs by more than an operator model does; what adds less than that is
//! hardly seen there, such as the ringing of a small mass after a few jumps. So where nothing is named and nothing unexplained is
//! seen, the causes that act at once are tried once more, each in the operator model that runs free, of all rows.
//! That model alone does not decide where its error is larger than the search's: a cause may then only correct the form of its hysteresis.
//! A fast cause is found where it takes a fifth of that model's error away; any that acts at once where both find it by more than chance:
//! the simulated model, and the search on blocks of time that no fit has seen or beyond what placebos gain.
//!
//! Only these, since next to nothing else looks like them: without any a warm-up takes away up to a sixth of the model's error,
//! a mass, a delay, a lag or a width up to a twentieth. Where the command alone was recorded no fast cause is asked again: no regulator is
//! quite of our form, and what is left of it looks like one.

use std::sync::OnceLock;

use rayon::prelude::*;

use super::candidate::Candidate;
use super::causes::Cause;
use super::chance::{FOUND, standard_errors};
use super::extend::{Extender, Extension};
use super::placebo::{Placebos, is_large};
use super::rivals::{Settled, TRUSTED};
use super::search::Search;
use recording::numbers::legible;

/// A cause leaves at most this share of the operator model's error.
const LEAVES: f64 = 0.8;
/// Causes that leave less than so many times the best one's are not told apart from it.
const ALIKE: f64 = 1.05;

/// The overlooked cause, if there is one. `base`: the set without it, which has no cause.
pub fn overlooked(
    search: &Search<'_>,
    (base, sizes): (&Candidate, &[Vec<Candidate>]),
    extender: &Extender<'_>,
) -> Option<Settled> {
    let alone = || clearly(search, sizes.first()?, extender);
    let alone = search.regulator.is_none().then(alone).flatten();
    let (set, others, [with, without]) = alone.or_else(|| found(search, (base, sizes), extender))?;
    Some(Settled {
        alternatives: others.iter().map(Candidate::names).collect(),
        set,
        evidence: Some(format!(
            "simulated, the operator model with it is off by {} instead of {} {} over all rows",
            legible(with, 3),
            legible(without, 3),
            extender.output_unit()
        )),
    })
}

/// A set, others that do as well, and the errors of the simulated operator model with the set and without. Output unit.
pub type Found = (Candidate, Vec<Candidate>, [f64; 2]);

/// Of the fast sets that were looked at the one that takes most of the operator model's error away, if that is much.
fn clearly(search: &Search<'_>, singles: &[Candidate], extender: &Extender<'_>) -> Option<Found> {
    let is_fast = |set: &&Candidate| set.shows() && set.causes.iter().all(|cause| cause.is_fast());
    let fast: Vec<&Candidate> = singles.iter().filter(is_fast).collect();
    if fast.is_empty() {
        return None;
    }
    let models: Vec<Option<Extension>> = fast.par_iter().map(|set| extender.model(set)).collect();
    let error = |model: &Option<Extension>| extender.error(model.as_ref()?);
    let errors: Vec<f64> = models.iter().map(|model| error(model).unwrap_or(f64::INFINITY)).collect();
    let (first, _) = clear(extender.without, &errors)?;
    // The plain model may have come to a worse end than the search's operators or that of the cause lead to, without any cause.
    let without = models[first].as_ref().map_or(extender.without, |model| extender.without_from(model));
    let without = extender.with(&search.baseline).map_or(without, |error| error.min(without));
    let (best, others) = clear(without, &errors)?;
    let others = others.into_iter().map(|other| fast[other].clone()).collect();
    let is_trusted = errors[best] <= TRUSTED * fast[best].simulated_error();
    is_trusted.then(|| (fast[best].clone(), others, [errors[best], without]))
}

/// The set that two judges find beside a base, see [`beyond_chance`], with a cause that acts at once.
fn found(
    search: &Search<'_>,
    (base, sizes): (&Candidate, &[Vec<Candidate>]),
    extender: &Extender<'_>,
) -> Option<Found> {
    let is_asked = |cause: &Cause| cause.acts_at_once() && (search.regulator.is_none() || !cause.is_fast());
    let asked: Vec<Cause> = search.examinable.iter().copied().filter(is_asked).collect();
    beyond_chance(search, (&asked, &search.examinable), (base, sizes), extender)
}

/// Of single causes beside a base the one that costs least of those that two judges find, each by more than is by chance: the search, and
/// the simulated operator models. The search on blocks of time that no fit has seen, or beyond what placebos of all causes that are `asked`
/// gain in all rows. And the others of them.
pub fn beyond_chance(
    search: &Search<'_>,
    (causes, asked): (&[Cause], &[Cause]),
    (base, sizes): (&Candidate, &[Vec<Candidate>]),
    extender: &Extender<'_>,
) -> Option<Found> {
    let least = standard_errors(FOUND, causes.len(), 1);
    let placebos = OnceLock::new();
    let placebos = || placebos.get_or_init(|| Placebos::of(search, base, asked)).as_ref();
    let of = |&cause: &Cause| {
        let set = search.with(base, cause, sizes)?;
        let without = search.without(&set, cause, sizes)?;
        let is_foretold = || without.score.gain(&set.score) > least * without.score.gain_error(&set.score);
        let is_no_placebo = || {
            let gain = search.gain(&without, &set);
            is_large(gain) && placebos().is_some_and(|all| all.find(gain))
        };
        (set.shows() && set.outlasts() && (is_foretold() || is_no_placebo())).then_some(set)
    };
    let promising: Vec<Candidate> = causes.par_iter().filter_map(of).collect();
    if promising.is_empty() {
        return None;
    }
    let plain = extender.model(base)?;
    let found = promising.into_iter().filter_map(|set| {
        let gain = extender.gain_between(&plain, &extender.model(&set)?)?;
        gain.is_beyond(least).then_some((set, [gain.after.rmse, gain.before.rmse]))
    });
    let mut found: Vec<(Candidate, [f64; 2])> = found.collect();
    found.sort_by(|(one, _), (other, _)| one.cost().total_cmp(&other.cost()));
    let mut found = found.into_iter();
    let (set, errors) = found.next()?;
    Some((set, found.map(|(set, _)| set).collect(), errors))
}

/// The place of the least error, if that is clearly less than `without`, and those of the errors that are hardly more than it.
fn clear(without: f64, errors: &[f64]) -> Option<(usize, Vec<usize>)> {
    let (best, least) = errors.iter().copied().enumerate().min_by(|one, other| one.1.total_cmp(&other.1))?;
    let is_alike = |place: &usize| *place != best && errors[*place] < ALIKE * least;
    (least < LEAVES * without).then(|| (best, (0..errors.len()).filter(is_alike).collect()))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_cause_that_takes_away_little_is_not_one_that_was_overlooked() {
        assert_eq!(clear(0.30, &[0.29, 0.25]), None);
        assert_eq!(clear(0.30, &[]), None);
        assert_eq!(clear(0.30, &[f64::INFINITY]), None);
    }

    #[test]
    fn causes_that_leave_about_the_same_are_not_told_apart() {
        assert_eq!(clear(0.49, &[0.26, 0.09, 0.25]), Some((1, vec![])));
        assert_eq!(clear(0.35, &[0.276, 0.284, 0.33]), Some((0, vec![1])));
    }
}
