//! The better of what two beginnings come to.

use model_core::ExtensionParameters;

use super::Extension;
use super::task::Task;
use identification::Termination;

/// An extended model with more than this share of the plain one's error is tried from another start too.
const LITTLE: f64 = 0.5;

/// A refined model with extensions, or, where it gains little over the plain one, whichever is better of it and the plain
/// operator with the same extensions, refined: what the operators see in the search is not always a good beginning.
pub fn nearer(
    task: &Task<'_>,
    found: Extension,
    plain: &Extension,
    extensions: ExtensionParameters<f64>,
) -> Option<Extension> {
    let reached = task.rms(&found)?;
    if reached < LITTLE * task.rms(plain)? {
        return Some(found);
    }
    let other = task.refined(Extension { extensions, jump: found.jump, ..plain.clone() });
    let other =
        other.map(|(other, _)| other).filter(|other| task.rms(other).is_some_and(|rms| rms < reached));
    Some(other.unwrap_or(found))
}

/// The model without extensions, or, if it errs by less, what it comes to from the operator of another one: few starts lead to it, and
/// what a cause gains is not to be what another beginning does.
pub fn plainer(task: &Task<'_>, plain: Extension, other: &Extension) -> Extension {
    let begin = Extension { extensions: ExtensionParameters::default(), jump: None, ..other.clone() };
    let errs_less = |from_other: &Extension| Some(task.rms(from_other)? < task.rms(&plain)?);
    let from_other = task.refined(begin).map(|(from_other, _)| from_other);
    from_other.filter(|from_other| errs_less(from_other).unwrap_or(false)).unwrap_or(plain)
}

/// An extended model that was fitted to some of the rows, fitted further to all of them.
///
/// The fit starts twice: from this model, and from its extensions with the plain model's operator. If the better result still errs
/// by more than the search with the same causes, a third fit starts from `from_search`, where there is one. The best one is returned.
pub fn continued(
    whole: &Task<'_>,
    taught: Extension,
    plain: &Extension,
    from_search: Option<&dyn Fn() -> Option<Extension>>,
) -> Option<(Extension, Termination)> {
    let better = |one: (Extension, Termination), other: Option<Extension>| {
        let other = other.and_then(|other| whole.refined(other));
        other.filter(|other| other.0.rmse(whole.columns) < one.0.rmse(whole.columns)).unwrap_or(one)
    };
    let (extensions, jump) = (taught.extensions.clone(), taught.jump);
    let other = Extension { extensions, jump, ..plain.clone() };
    let model = better(whole.refined(taught)?, Some(other));
    let is_near = model.0.rmse(whole.columns) <= whole.reached;
    let from_search = from_search.filter(|_| !is_near).and_then(|begin| begin());
    Some(better(model, from_search))
}
