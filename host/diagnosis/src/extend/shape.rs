//! Operators of other forms, for a recording that is hysteresis and nothing else, of a form that the plain model cannot have.
//!
//! Tried where the plain model is far from what a hysteresis of any form comes to, and nothing else is seen. All forms that
//! `mgpi compare` tries are fitted to the samples before the split; the one that predicts those behind it best is taken.

use model_core::ExtensionParameters;

use super::{Extension, Operator, split, start};
use crate::Columns;
use identification::comparison::choice::{candidates, penalised};
use identification::{Options, Problem, Termination, identify};
use recording::numbers::root_mean_square;

/// Knots of the piecewise-linear envelopes that are tried: those of `mgpi compare`.
const KNOTS: usize = 10;

/// An operator without extensions that may be written in the place of the plain model.
#[derive(Clone, Debug)]
pub struct Shape {
    /// Fitted to the scored samples before the split.
    pub(super) taught: Extension,
    /// Fitted to all of them.
    pub(super) whole: Extension,
    pub(super) termination: Termination,
}

impl Shape {
    /// The form that predicts the samples behind the split best; None where none can be identified.
    pub fn best(columns: &Columns, scored: &[usize]) -> Option<Self> {
        let (first, untaught) = split(scored);
        let kept = start::kept(&columns.input, first);
        let predicted = |options: &Options| {
            let (operator, _) = fitted(columns, &kept, first, options)?;
            let taught = operator.with(ExtensionParameters::default());
            let answer = taught.answer(columns)?;
            let errors: Vec<f64> = untaught.iter().map(|&row| columns.output[row] - answer[row]).collect();
            Some((penalised(root_mean_square(&errors), options), *options, taught))
        };
        // One by one: each search runs its starts on all threads.
        let base = Options { starts: start::STARTS, ..start::as_identify(None) };
        let (_, options, taught) = candidates(&base, KNOTS)
            .iter()
            .filter_map(predicted)
            .min_by(|one, other| one.0.total_cmp(&other.0))?;
        let all: Vec<usize> = (0..columns.input.len()).collect();
        let (operator, termination) = fitted(columns, &all, scored, &options)?;
        let whole = operator.with(ExtensionParameters::default());
        Some(Self { taught, whole, termination })
    }

    /// The plain model of the input as it was measured, where it was smoothed: that is what will drive it.
    pub fn of_measured(columns: &Columns, scored: &[usize]) -> Option<Self> {
        columns.measured_input.as_ref()?;
        let measured = &*columns.as_measured();
        let plainly = |operator: Operator| operator.with(ExtensionParameters::default());
        let taught = start::operator(&start::Seen::plain(measured), split(scored).0).ok()?;
        let (whole, termination) = start::identified(measured).ok()?;
        Some(Self { taught: plainly(taught), whole: plainly(whole), termination })
    }
}

/// An operator of a form that fits best on the scored ones of the kept rows; None where there is none.
fn fitted(
    columns: &Columns,
    kept: &[usize],
    scored: &[usize],
    options: &Options,
) -> Option<(Operator, Termination)> {
    let of_kept = |values: &[f64]| -> Vec<f64> { kept.iter().map(|&row| values[row]).collect() };
    let (input, output) = (of_kept(&columns.input), of_kept(&columns.output));
    let counts: Vec<bool> = kept.iter().map(|row| scored.binary_search(row).is_ok()).collect();
    let fit =
        identify(&Problem { input: &input, output: &output, scored: &counts }, options, &|_| ()).ok()?;
    let operator = Operator { parameters: fit.parameters, density: fit.density };
    Some((operator.valid_for(columns), fit.termination))
}
