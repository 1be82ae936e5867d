//! The misfit beside effects: its states are those that what is late and what is wider make of the input.

use std::sync::Arc;

use super::basis::{Basis, Seen};
use super::effect::{Effect, Form};
use super::equivalent::{Arrived, Stages};
use super::misfit::Misfit;
use super::signals::Signals;

/// What a baseline gets wrong in the same way at every visit to a state, where the input is as late as these effects make it; None where
/// no such thing is asked for.
pub fn late(signals: &Signals, basis: &Basis, effects: &[Effect]) -> Option<Arc<Misfit>> {
    let late_s = effects.iter().map(Effect::late_s).sum();
    signals.misfits(basis)?.late(late_s, |delay_s| Arrived::new(signals, &[Effect::delay(delay_s)]).input)
}

/// The same where thresholds follow a rate, with the states as these effects make them.
pub fn seen(signals: &Signals, basis: &Basis, effects: &[Effect]) -> Option<Arc<Misfit>> {
    let is_wider = |effect: &Effect| matches!(effect.form, Form::Thresholds(_));
    if !effects.iter().any(is_wider) {
        return late(signals, basis, effects);
    }
    let Seen { wider, .. } = Stages::new(signals, effects).seen;
    signals.misfits(basis)?.seen(Seen { input: Arrived::new(signals, effects).input, wider, bend: 0.0 })
}
