//! The operator to begin with: identified from what the operators see in the search.
//!
//! A few searches on a thinned recording, since all is refined together afterwards. Envelopes of both forms are tried: many
//! muscles have the paper's, which has four unknowns, and next to none is drawn by few straight lines as well. The operator
//! without effects is identified from all samples too, as `mgpi identify` does it: no model that is written is worse.

use model_core::Kind;
use model_core::envelope::EnvelopeParameters;

use super::Operator;
use crate::Columns;
use crate::candidate::Candidate;
use crate::effect::{Effect, Form};
use crate::equivalent::Stages;
use crate::fit::Fit;
use crate::free_run::free_run;
use crate::output;
use crate::regulator;
use crate::search::Search;
use identification::comparison::choice::penalised;
use identification::{
    self, CONVERGED, IdentificationError, Loss, Options, Problem, Termination, Weights, identify,
};
use recording::figures::Figures;

/// Samples that are scored, about, and as many more that only drive the operator.
const ROWS: usize = 1600;
/// Knots of a piecewise-linear envelope, as `mgpi compare` has by default.
pub const KNOTS: usize = 12;
/// The envelopes that are tried: tanh, and piecewise-linear.
const ENVELOPES: [Option<usize>; 2] = [None, Some(KNOTS)];
/// Sizes of the operator.
const PLAYS: usize = 10;
const DEAD_ZONES: usize = 10;
/// Starts of the search for each envelope.
pub const STARTS: usize = 8;
/// A step that gains less than this share of the sum of squares is their last.
const TOLERANCE: f64 = 1e-4;
/// Their seed.
const SEED: u64 = 1;

/// Input and output of the operators, a value a row of what they are seen in.
pub struct Seen {
    input: Vec<f64>,
    output: Vec<f64>,
}

impl Seen {
    /// Without effects, in a recording.
    pub fn plain(columns: &Columns) -> Self {
        Self { input: columns.input.clone(), output: columns.output.clone() }
    }

    /// Under the effects of a set, in the kept rows: what the baseline has beside them (its small delay, its width) is the operator's here.
    pub fn of(search: &Search<'_>, set: &Candidate) -> Self {
        let signals = search.signals;
        let first = set.fit.effects.len() - set.causes.len();
        let (nuisances, effects) = set.fit.effects.split_at(first);
        let effects = effects.to_vec();
        let mut output = signals.output.clone();
        // An operator cannot say what wider thresholds do: it would take the mean of all speeds for its own.
        if let Some(at_rest) = at_rest(&set.fit) {
            let [wider, at_rest] = [&set.fit, &at_rest].map(|fit| free_run(signals, &search.basis, fit).all);
            for (y, (wider, at_rest)) in output.iter_mut().zip(wider.iter().zip(at_rest)) {
                *y -= wider - at_rest;
            }
        }
        for (i, effect) in effects.iter().enumerate() {
            let (columns, _) = output::columns(effect, signals);
            for (column, weight) in columns.iter().zip(set.fit.output_weights(signals, first + i)) {
                for (row, value) in signals.rows.iter().zip(column) {
                    output[row.at] -= weight * value;
                }
            }
        }
        let regulator = nuisances.iter().filter(|effect| regulator::valve(effect).is_some());
        let before: Vec<Effect> = regulator.cloned().chain(effects).collect();
        Self { input: Stages::new(signals, &before).seen.input, output }
    }
}

/// The fit with its thresholds as they are at rest; None where none follow a rate.
fn at_rest(fit: &Fit) -> Option<Fit> {
    let mut fit = fit.clone();
    let is_wider = |effect: &&mut Effect| matches!(effect.form, Form::Thresholds(_));
    fit.effects.iter_mut().find(is_wider)?.parameters[1].value = 0.0;
    Some(fit)
}

/// The operator that fits best on the given rows, which are in order. It holds for all inputs of the recording, also those of
/// other rows.
///
/// # Errors
/// No operator can be identified.
pub fn operator(seen: &Seen, scored: &[usize]) -> Result<Operator, IdentificationError> {
    operator_of(seen, scored, &ENVELOPES.map(in_passing))
}

/// The best of several searches for such an operator.
///
/// # Errors
/// No operator can be identified.
pub fn operator_of(
    seen: &Seen,
    scored: &[usize],
    searches: &[Options],
) -> Result<Operator, IdentificationError> {
    let kept = kept(&seen.input, scored);
    let of_kept = |values: &[f64]| -> Vec<f64> { kept.iter().map(|&row| values[row]).collect() };
    let counts: Vec<bool> = kept.iter().map(|row| scored.binary_search(row).is_ok()).collect();
    let problem = Problem { input: &of_kept(&seen.input), output: &of_kept(&seen.output), scored: &counts };
    let (operator, _) = best(&problem, searches)?;
    Ok(operator)
}

/// The rows that the search looks at, in order: some of the scored ones, and the lowest and the highest input of each block, for
/// operators remember extremes only. Blocks are as short as the scored rows need them, however many rows follow.
fn kept(input: &[f64], scored: &[usize]) -> Vec<usize> {
    let mut kept: Vec<usize> = scored.iter().copied().step_by(2 * (scored.len() / ROWS).max(1)).collect();
    let scored_end = scored.last().map_or(0, |last| last + 1);
    let block = 2 * (scored_end / ROWS).max(1);
    for first in (0..input.len()).step_by(block) {
        let rows = first..(first + block).min(input.len());
        kept.extend(rows.clone().min_by(|&i, &j| input[i].total_cmp(&input[j])));
        kept.extend(rows.max_by(|&i, &j| input[i].total_cmp(&input[j])));
    }
    kept.sort_unstable();
    kept.dedup();
    kept
}

/// The operator that `mgpi identify` finds by default in all scored samples, and how its search ended.
///
/// # Errors
/// No operator can be identified.
pub fn identified(columns: &Columns) -> Result<(Operator, Termination), IdentificationError> {
    identified_as(columns, as_identify(None))
}

/// The same by another search.
///
/// # Errors
/// No operator can be identified.
pub fn identified_as(
    columns: &Columns,
    options: Options,
) -> Result<(Operator, Termination), IdentificationError> {
    let Columns { input, output, scored, .. } = columns;
    best(&Problem { input, output, scored }, &[options])
}

/// Number of knots of an envelope; None of one that has none.
pub(crate) fn knots(envelope: &EnvelopeParameters<f64>) -> Option<usize> {
    match envelope {
        EnvelopeParameters::PiecewiseLinear(envelope) => Some(envelope.values.len()),
        EnvelopeParameters::Tanh(_) | EnvelopeParameters::Identity => None,
    }
}

/// What `mgpi identify` searches by default, but for the envelope.
pub(super) fn as_identify(knots: Option<usize>) -> Options {
    Options {
        model: Kind::Mgpi,
        knots,
        plays: PLAYS,
        weights: Weights::Exponential,
        dead_zones: DEAD_ZONES,
        loss: Loss::Squares,
        starts: identification::STARTS,
        seed: identification::SEED,
        threads: 0,
        tolerance: CONVERGED,
    }
}

/// The same with the few starts and the tolerance of what is refined later, or only chosen by.
pub(super) fn in_passing(knots: Option<usize>) -> Options {
    Options { starts: STARTS, seed: SEED, tolerance: TOLERANCE, ..as_identify(knots) }
}

/// The best operator of several searches.
fn best(problem: &Problem<'_>, searches: &[Options]) -> Result<(Operator, Termination), IdentificationError> {
    let of_search = |options: &Options| {
        let fit = identify(problem, options, &|_| ())?;
        let rmse = Figures::of(problem.output, &fit.simulated, problem.scored).rmse;
        let operator = Operator { parameters: fit.parameters, density: fit.density };
        Ok((penalised(rmse, options), operator, fit.termination))
    };
    let mut refusal = IdentificationError::Lengths;
    let mut found: Option<(f64, Operator, Termination)> = None;
    for options in searches {
        match of_search(options) {
            Ok(next) if found.as_ref().is_none_or(|best| next.0 < best.0) => found = Some(next),
            Ok(_) => {}
            Err(error) => refusal = error,
        }
    }
    found.map(|(_, operator, termination)| (operator, termination)).ok_or(refusal)
}

#[cfg(test)]
mod tests {
    use super::{ROWS, kept};

    #[test]
    fn rows_behind_the_scored_ones_thin_these_no_further() {
        let input: Vec<f64> = (0..4 * ROWS).map(|row| (0.7 * row as f64).sin()).collect();
        let scored: Vec<usize> = (0..ROWS).collect();
        let alone = kept(&input[..ROWS], &scored);
        let mut followed = kept(&input, &scored);
        followed.retain(|&row| row < ROWS);
        assert_eq!(followed, alone);
    }
}
