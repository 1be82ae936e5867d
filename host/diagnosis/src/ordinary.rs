//! The lag of any proportional regulator, in a recording of the command alone.
//!
//! There the regulator is a part of the chain, and a lag as short as any regulator has is nothing that is wrong. Where such a lag
//! explains a recording as well as a fast cause of the muscle, within the misfit that is left, it takes the place of that. It goes into the model, and is not named.

use super::candidate::Candidate;
use super::causes::{Cause, Ordinary};
use super::fitted::{Parameters, value};
use super::physical::parameters;
use super::pure_error::pure_error;
use super::rivals::differ_less_than_misfit;
use super::search::Search;

/// The best set in which a regulator's lag replaces a fast cause and explains the recording as well; None if no set does.
pub fn with_ordinary_lag(
    search: &Search<'_>,
    set: &Candidate,
    sizes: &[Vec<Candidate>],
) -> Option<Candidate> {
    let ordinary = |cause: Cause| Some((cause, (cause.about().ordinary?.start)(search.signals)?));
    let (lag, start) = Cause::ALL.into_iter().find_map(ordinary)?;
    if set.causes.contains(&lag) {
        return None;
    }
    let in_place_of = |&cause: &Cause| {
        let kept = search.without(set, cause, sizes)?;
        let runners = search.runners(&kept, lag, vec![start.clone()]);
        search.race(runners, f64::INFINITY).into_iter().next()
    };
    let fast = set.causes.iter().filter(|cause| cause.is_fast());
    fast.filter_map(in_place_of)
        .filter(|other| differ_less_than_misfit(set.score.mean(), other.score.mean(), search.signals.noise))
        .min_by(|one, other| one.cost().total_cmp(&other.cost()))
}

/// The search with a regulator's ordinary lag in its baseline, where that lag is all that a set has.
pub fn beside_ordinary_lag<'a>(search: &Search<'a>, set: &Candidate) -> Option<Search<'a>> {
    if set.causes.len() != 1 {
        return None;
    }
    ordinary_lag(search, set)?;
    let baseline = Candidate { causes: Vec::new(), ..set.clone() };
    let pure = pure_error(search.signals, &search.basis, &set.fit.seen, &set.residual);
    Some(Search { baseline, pure, ..search.clone() })
}

/// The causes of a set around another one, but for the ordinary lag of the regulator that this one has: that is not named.
pub fn without_ordinary_lag(search: &Search<'_>, set: &Candidate, mut wider: Vec<Cause>) -> Vec<Cause> {
    if let Some(lag) = ordinary_lag(search, set) {
        wider.retain(|cause| *cause != lag);
    }
    wider
}

/// The lag of a set that is as short as any regulator's, if it has one.
fn ordinary_lag(search: &Search<'_>, set: &Candidate) -> Option<Cause> {
    let all = parameters(search.signals, &search.basis, &set.causes, &set.fit);
    all.iter().find(|(cause, parameters)| is_ordinary(*cause, parameters)).map(|(cause, _)| *cause)
}

/// Whether a cause with these parameters is what any recording of a command has.
pub fn is_ordinary(cause: Cause, parameters: &Parameters) -> bool {
    cause.about().ordinary.is_some_and(|Ordinary { up_to: (name, most), .. }| {
        value(parameters, name).is_some_and(|value| value <= most)
    })
}
