//! The lag of any proportional regulator, in a recording of the command alone.
//!
//! There the regulator is a part of the chain, and a lag as short as any regulator has is nothing that is wrong. Where such a lag
//! explains a recording as well as a fast cause of the muscle, within the misfit that is left, it takes the place of that. It goes into the model, and is not named.

use super::candidate::Candidate;
use super::cause::Cause;
use super::effect::{Effect, ORDINARY_LAG_S};
use super::physical::parameters;
use super::pure_error::pure_error;
use super::rivals::differ_less_than_misfit;
use super::search::Search;
use super::verdict::Named;

/// The name of a lag's parameter.
const TIME_CONSTANT: &str = "time_constant_s";

/// The best set in which a regulator's lag replaces a fast cause and explains the recording as well; None if no set does.
pub fn with_ordinary_lag(
    search: &Search<'_>,
    set: &Candidate,
    sizes: &[Vec<Candidate>],
) -> Option<Candidate> {
    if set.causes.contains(&Cause::ValveLag) {
        return None;
    }
    let start = Effect::ordinary_lag(search.signals)?;
    let in_place_of = |&cause: &Cause| {
        let kept = search.without(set, cause, sizes)?;
        let runners = search.runners(&kept, Cause::ValveLag, vec![start.clone()]);
        search.race(runners, f64::INFINITY).into_iter().next()
    };
    let fast = set.causes.iter().filter(|cause| cause.is_fast());
    fast.filter_map(in_place_of)
        .filter(|other| differ_less_than_misfit(set.score.mean(), other.score.mean(), search.signals.noise))
        .min_by(|one, other| one.cost().total_cmp(&other.cost()))
}

/// The search with a regulator's ordinary lag in its baseline, where that lag is all that a set has.
pub fn beside_ordinary_lag<'a>(search: &Search<'a>, set: &Candidate) -> Option<Search<'a>> {
    let [Cause::ValveLag] = set.causes[..] else { return None };
    let baseline = Candidate { causes: Vec::new(), ..set.clone() };
    let pure = pure_error(search.signals, &search.basis, &set.fit.seen, &set.residual);
    has_ordinary_lag(search, set).then(|| Search { baseline, pure, ..search.clone() })
}

/// The causes of a set around another one, but for the ordinary lag of the regulator that this one has: that is not named.
pub fn without_ordinary_lag(search: &Search<'_>, set: &Candidate, mut wider: Vec<Cause>) -> Vec<Cause> {
    if has_ordinary_lag(search, set) {
        wider.retain(|cause| *cause != Cause::ValveLag);
    }
    wider
}

/// Whether a set has a lag of the valve that is as short as any regulator's.
fn has_ordinary_lag(search: &Search<'_>, set: &Candidate) -> bool {
    let all = parameters(search.signals, &search.basis, &set.causes, &set.fit);
    let mut of_valve = all.iter().filter(|(cause, _)| *cause == Cause::ValveLag).flat_map(|(_, all)| all);
    of_valve.any(|(name, value)| *name == TIME_CONSTANT && *value <= ORDINARY_LAG_S)
}

/// Whether what is named is the lag of any regulator.
pub fn is_ordinary(named: &Named) -> bool {
    let lag_s = named.parameter(TIME_CONSTANT);
    named.cause == Cause::ValveLag && lag_s.is_some_and(|lag_s| lag_s <= ORDINARY_LAG_S)
}
