//! What causes would do that the recording cannot show.
//!
//! A cause without an excitation of its own is named only where nothing else explains the recording, and it does, in a search among all
//! causes: else whatever the model lacks may look like it. But what is named in its place would be a guess. So where a cause that is not examinable does better than a close rival of it that is named, or as well within
//! the standard error, neither is told from the other; and where such a cause leaves nothing of what is unexplained, that is said.
//!
//! What goes with time or travel alone is no such rival: where nothing is repeated it can take the place of any slow cause that the
//! recording does show. A creep without a hold cannot: it follows from the input.

use super::Diagnosis;
use super::anatomy::examinable::Examinable;
use super::candidate::Candidate;
use super::causes::{Cause, Fits, Law};
use super::extend::Extender;
use super::overlooked::beyond_chance;
use super::reject::{Unexplained, unexplained};
use super::rivals::is_untold;
use super::search::Search;

/// Causes of the largest set that is looked for where something is unexplained.
const LARGEST: usize = 2;

/// The set with causes that are not examinable which does better than the named ones, one exchanged for a rival, or as well, or leaves
/// nothing of what these leave. None if no set does, if everything is examinable, or if what is left comes from the sensor.
pub fn unexamined(
    search: &Search<'_>,
    (set, sizes): (&Candidate, &[Vec<Candidate>]),
    left: Option<&Unexplained>,
    judged: &[Examinable],
) -> Option<Vec<Cause>> {
    if matches!(left, Some(Unexplained::Outliers { .. } | Unexplained::Stuck(_) | Unexplained::Slips(_))) {
        return None;
    }
    let leaves_something = left.is_some();
    let is_new = |cause: &Cause| !search.examinable.contains(cause);
    let goes_alone = |cause: &Cause| cause.law() == Law::Progress;
    let can_stand =
        |cause: &Cause| cause.about().fits == Fits::Any && (leaves_something || !goes_alone(cause));
    let all = judged.iter().map(|judged| judged.cause).filter(|cause| is_new(cause) && can_stand(cause));
    let new: Vec<Cause> = all.collect();
    let is_rival = |cause: &Cause| set.causes.iter().any(|named| named.rivals().any(|rival| rival == *cause));
    let found = if leaves_something && !new.is_empty() {
        let examinable = search.examinable.iter().chain(&new).copied().collect();
        let wider = Search { examinable, largest: LARGEST, ..search.clone() };
        Some(wider.run(&|_| ()).0).filter(|found| unexplained(&wider, found).is_none())
    } else if new.iter().any(is_rival) {
        let others = Search { examinable: new, ..search.clone() };
        let without = search.without_each(set, sizes);
        others.swapped(set, &without).or_else(|| as_good(&others, set, &without))
    } else {
        None
    };
    found.map(|found| found.names()).filter(|causes| causes.iter().any(is_new))
}

/// Where nothing is named and nothing seems to be left: the causes that are not examinable, each of which does more than is by chance, the
/// one that costs least first.
pub fn unexcited(search: &Search<'_>, extender: &Extender<'_>, judged: &[Examinable]) -> Vec<Cause> {
    let all = judged.iter().map(|judged| judged.cause).filter(|cause| cause.about().fits == Fits::Any);
    let new: Vec<Cause> = all.filter(|cause| !search.examinable.contains(cause)).collect();
    let others = Search { examinable: new.clone(), ..search.clone() };
    let found = beyond_chance(&others, (&new, &new), (&others.baseline, &[]), extender);
    found
        .into_iter()
        .flat_map(|(set, more, _)| set.causes.into_iter().chain(more.into_iter().flat_map(|set| set.causes)))
        .collect()
}

/// Of the sets in which a rival replaces one of the causes, the best that is not told apart from `set`; None if all are.
fn as_good(others: &Search<'_>, set: &Candidate, without: &[Option<Candidate>]) -> Option<Candidate> {
    let places = set.causes.iter().zip(without).filter_map(|(cause, kept)| Some((cause, kept.as_ref()?)));
    let exchanged = places.flat_map(|(cause, kept)| {
        let rivals = cause.rivals().filter(|rival| others.examinable.contains(rival));
        rivals.filter_map(|rival| others.with(kept, rival, &[]))
    });
    let untold = exchanged.filter(|rival| is_untold(others, (set, &set.causes), rival));
    untold.min_by(|one, other| one.cost().total_cmp(&other.cost()))
}

/// Says of the named causes without an excitation why they are named all the same.
pub fn admit(diagnosis: &mut Diagnosis) {
    let named = |cause: Cause| diagnosis.causes.iter().any(|named| named.cause == cause);
    for judged in diagnosis.examinable.iter_mut().filter(|judged| !judged.examinable && named(judged.cause)) {
        judged.examinable = true;
        judged.why.push_str(
            "; but no cause that it has an excitation for explains the recording, and this one does",
        );
    }
}
