//! Whether what the search names holds in a model that is simulated.

use std::sync::OnceLock;

use super::DiagnosisError;
use super::candidate::Candidate;
use super::causes::Cause;
use super::chance::{NOT_EXCLUDED, standard_errors};
use super::extend::{Extended, Extender, Operator};
use super::placebo::{Placebos, is_large};
use super::reject::{Unexplained, no_gain, unexplained};
use super::valve::ValveFit;
use identification::IdentificationError;
use rayon::prelude::*;

/// The search, and the simulated models.
const JUDGES: i32 = 2;

/// The model that is simulated, and what it says of the named causes.
pub struct Proven {
    /// The causes of the muscle that hold.
    pub set: Candidate,
    /// Sets with one cause more that are not excluded, see [`not_excluded`].
    pub wider: Vec<Vec<Cause>>,
    /// The model.
    pub extended: Extended,
    /// Why the named causes explain nothing, if they do not.
    pub refuted: Option<Unexplained>,
    /// Whether they are needless: they gain nothing, and nothing is left unexplained without them. The model is then that
    /// without them.
    pub is_needless: bool,
}

/// Extends the operator model by a set of causes and those of the valve, and asks what that gains: all together, and each of the muscle
/// beside the others, since what a set gains may be the gain of one of its causes alone. The fit starts from the `given` operator, if
/// there is one and its form is rich enough. `progress` is called with the share of the work done so far.
///
/// # Errors
/// No model can be simulated, not even one without causes.
pub fn proven(
    extender: &Extender<'_>,
    (set, valve): (&Candidate, Option<&ValveFit>),
    sizes: &[Vec<Candidate>],
    given: Option<&Operator>,
    progress: &(dyn Fn(f64) + Sync),
) -> Result<Proven, DiagnosisError> {
    let search = extender.search;
    let plainly = || {
        let without = |valve| extender.extend(&search.baseline, valve, given, progress);
        // An ordinary valve is left out where the model cannot have it.
        let plain = without(valve.filter(|valve| valve.named.is_empty())).or_else(|| without(None));
        plain.ok_or(DiagnosisError::NoModel(IdentificationError::Lengths))
    };
    let named = !set.causes.is_empty() || valve.is_some_and(|valve| !valve.named.is_empty());
    if !named {
        return Ok(Proven {
            set: set.clone(),
            wider: Vec::new(),
            extended: plainly()?,
            refuted: None,
            is_needless: false,
        });
    }
    let Some(extended) = extender.extend(set, valve, given, progress) else {
        return Ok(Proven {
            set: set.clone(),
            wider: Vec::new(),
            extended: plainly()?,
            refuted: Some(Unexplained::NotSimulated),
            is_needless: false,
        });
    };
    let (set, extended) = holding(extender, (set.clone(), extended), valve, (sizes, given));
    let refuted = no_gain(&extended);
    if refuted.is_some() && unexplained(search, &search.baseline).is_none() {
        return Ok(Proven { set, wider: Vec::new(), extended: plainly()?, refuted: None, is_needless: true });
    }
    let wider = match refuted {
        None => not_excluded(extender, (&set, &extended), valve, (sizes, given)),
        Some(_) => Vec::new(),
    };
    Ok(Proven { set, wider, extended, refuted, is_needless: false })
}

/// What is left of a set and of its model when each cause of the muscle has gone that gains nothing beside the others, the valve's and the
/// regulator, the most needless first.
fn holding(
    extender: &Extender<'_>,
    (mut set, mut extended): (Candidate, Extended),
    valve: Option<&ValveFit>,
    (sizes, given): (&[Vec<Candidate>], Option<&Operator>),
) -> (Candidate, Extended) {
    let search = extender.search;
    let of_valve = valve.map_or(0, |valve| valve.named.len());
    let is_alone = |set: &Candidate| set.causes.len() + of_valve == 1 && search.regulator.is_none();
    while !set.causes.is_empty() && !is_alone(&set) {
        let without: Vec<(Candidate, Extended)> = set
            .causes
            .par_iter()
            .filter_map(|&cause| {
                let without = search.without(&set, cause, sizes)?;
                let model = extender.extend(&without, valve, given, &|_| ())?;
                Some((without, model))
            })
            .collect();
        let is_needless = |less: &Extended| extender.gain_of_muscle(&extended, less).is_none();
        let needless = without.into_iter().filter(|(_, without)| is_needless(without));
        let least = needless.min_by(|(_, one), (_, other)| one.extended_rmse.total_cmp(&other.extended_rmse));
        let Some(least) = least else { break };
        (set, extended) = least;
    }
    (set, extended)
}

/// The sets with one cause more which two judges find better, each by more than is by chance: the search, on blocks of time that no fit has
/// seen or, for a fast cause, beyond what placebos gain in all rows; and the simulated models. The search does not name that cause, since
/// it is not worth its place; but to call a recording explained says that nothing else is in it, and both of them see something else.
fn not_excluded(
    extender: &Extender<'_>,
    (set, extended): (&Candidate, &Extended),
    valve: Option<&ValveFit>,
    (sizes, given): (&[Vec<Candidate>], Option<&Operator>),
) -> Vec<Vec<Cause>> {
    let search = extender.search;
    let others: Vec<Cause> =
        search.examinable.iter().copied().filter(|cause| !set.causes.contains(cause)).collect();
    let beyond_chance =
        |cause: Cause| standard_errors(NOT_EXCLUDED, others.len() * cause.hypotheses(), JUDGES);
    let placebos = OnceLock::new();
    let placebos = || placebos.get_or_init(|| Placebos::of(search, set, &others)).as_ref();
    let is_better = |cause: Cause, wider: &Candidate| {
        // What the baseline gains where the wider set has led it is no gain of the cause.
        let Some(less) = search.without(wider, cause, sizes) else { return false };
        let (gain, error) = (less.score.gain(&wider.score), less.score.gain_error(&wider.score));
        // What goes slowly takes up what the form lacks; next to nothing else looks like a fast cause. Of squares, so twice what is owed
        // of errors.
        let own = || search.gain(&less, wider) - 2.0 * search.owed(cause, set);
        let is_found =
            || cause.acts_at_once() && is_large(own()) && placebos().is_some_and(|all| all.find(own()));
        wider.shows() && wider.outlasts() && (gain > beyond_chance(cause) * error || is_found())
    };
    let gains = |cause: Cause, wider: Candidate| {
        let model = extender.extend(&wider, valve, given, &|_| ())?;
        let gain = extender.gain_of_muscle(&model, extended)?;
        gain.is_beyond(beyond_chance(cause)).then(|| wider.names())
    };
    others
        .par_iter()
        .filter_map(|&cause| Some((cause, search.with(set, cause, sizes)?)))
        .filter(|(cause, wider)| is_better(*cause, wider))
        .filter_map(|(cause, wider)| gains(cause, wider))
        .collect()
}
