//! Operators of other forms, for a recording that is hysteresis and nothing else, of a form that the plain model cannot have.
//!
//! Tried where the plain model is far from what a hysteresis of any form comes to, and nothing else is seen. All forms that
//! `mgpi compare` tries are fitted to the samples before the split; the one that predicts those behind it best is taken.

use model_core::ExtensionParameters;

use super::{Operator, Plain, Split, start};
use crate::Columns;
use identification::Options;
use identification::comparison::choice::{candidates, penalised};
use recording::numbers::root_mean_square;

impl Plain {
    /// The form that predicts the samples behind the split best; None where none can be identified.
    pub fn of_other_form(columns: &Columns, scored: &[usize]) -> Option<Self> {
        let Split { taught: first, untaught, .. } = Split::of(columns, scored);
        let seen = start::Seen::plain(columns);
        let plainly = |operator: Operator| operator.valid_for(columns).with(ExtensionParameters::default());
        let predicted = |options: &Options| {
            let taught = plainly(start::operator_of(&seen, &first, &[*options]).ok()?);
            let answer = taught.answer(columns)?;
            let errors: Vec<f64> = untaught.iter().map(|&row| columns.output[row] - answer[row]).collect();
            Some((penalised(root_mean_square(&errors), options), *options, taught))
        };
        // One by one: each search runs its starts on all threads.
        let (_, options, taught) = candidates(&start::in_passing(None), start::KNOTS)
            .iter()
            .filter_map(predicted)
            .min_by(|one, other| one.0.total_cmp(&other.0))?;
        let to_the_end = Options { tolerance: identification::CONVERGED, ..options };
        let (operator, termination) = start::identified_as(columns, to_the_end).ok()?;
        Some(Self { taught, whole: plainly(operator), termination })
    }

    /// The plain model of the input as it was measured, where it was smoothed: that is what will drive it.
    pub fn of_measured(columns: &Columns, scored: &[usize]) -> Option<Self> {
        columns.measured_input.as_ref()?;
        let measured = &*columns.as_measured();
        let plainly = |operator: Operator| operator.with(ExtensionParameters::default());
        let taught =
            start::operator(&start::Seen::plain(measured), &Split::of(columns, scored).taught).ok()?;
        let (whole, termination) = start::identified(measured).ok()?;
        Some(Self { taught: plainly(taught), whole: plainly(whole), termination })
    }
}
