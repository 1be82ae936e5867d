//! What is read from a fitted set: the parameters of its causes, in the units that people measure in, and what speaks against them.

use super::basis::Basis;
use super::causes::Cause;
use super::fit::Fit;
use super::fitted::{Doubt, Fitted, FittedSet, Parameters};
use super::signals::Signals;

/// The parameters of every cause of a set.
pub fn parameters(signals: &Signals, basis: &Basis, causes: &[Cause], fit: &Fit) -> Vec<(Cause, Parameters)> {
    of_each((signals, basis), causes, fit, |cause, fitted| (cause, cause.parameters(fitted)))
}

/// What speaks against the causes of a set. `longest_hold_s`: of the recording.
pub fn doubts(
    signals: &Signals,
    basis: &Basis,
    causes: &[Cause],
    fit: &Fit,
    longest_hold_s: f64,
) -> Vec<Doubt> {
    let doubt = |cause: Cause, fitted: &Fitted<'_>| cause.doubt(fitted, longest_hold_s);
    of_each((signals, basis), causes, fit, doubt).into_iter().flatten().collect()
}

/// What each cause says of its effect: the last effects of a fit are the causes'.
fn of_each<T>(
    (signals, basis): (&Signals, &Basis),
    causes: &[Cause],
    fit: &Fit,
    ask: impl Fn(Cause, &Fitted<'_>) -> T,
) -> Vec<T> {
    let set = FittedSet::new(signals, basis, fit);
    let first = fit.effects.len() - causes.len();
    causes.iter().enumerate().map(|(i, &cause)| ask(cause, &set.effect(first + i))).collect()
}
