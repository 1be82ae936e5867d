//! The operator to begin with: identified from what the operators see in the search.
//!
//! A few searches on a thinned recording, since all is refined together afterwards. Envelopes of both forms are tried: many
//! muscles have the paper's, which has four unknowns, and next to none is drawn by few straight lines as well.

use model_core::Kind;

use super::Operator;
use crate::comparison::choice::penalised;
use crate::diagnosis::Columns;
use crate::diagnosis::candidate::Candidate;
use crate::diagnosis::effect::{Effect, Form};
use crate::diagnosis::equivalent::Stages;
use crate::diagnosis::fit::Fit;
use crate::diagnosis::free_run::free_run;
use crate::diagnosis::output;
use crate::diagnosis::search::Search;
use crate::figures::Figures;
use crate::identification::{Loss, Options, Problem, Weights, identify};

/// Rows that are looked at, about.
const ROWS: usize = 1600;
/// The envelopes that are tried: tanh, and piecewise-linear with so many knots.
const ENVELOPES: [Option<usize>; 2] = [None, Some(12)];
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
        let effects: Vec<Effect> = set.fit.effects[first..].to_vec();
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
        Self { input: Stages::new(signals, &effects).seen.input, output }
    }
}

/// The fit with its thresholds as they are at rest; None where none follow a rate.
fn at_rest(fit: &Fit) -> Option<Fit> {
    let mut fit = fit.clone();
    let is_wider = |effect: &&mut Effect| matches!(effect.form, Form::Thresholds(_));
    fit.effects.iter_mut().find(is_wider)?.parameters[1].value = 0.0;
    Some(fit)
}

/// The operator that fits best on the given rows, which are in order.
pub fn operator(seen: &Seen, scored: &[usize]) -> Option<Operator> {
    let end = scored.last().map_or(0, |last| last + 1);
    let block = 2 * (end / ROWS).max(1);
    // The lowest and the highest input of a block: operators remember extremes only.
    let mut kept: Vec<usize> = scored.iter().copied().step_by(block).collect();
    for first in (0..end).step_by(block) {
        let rows = first..(first + block).min(end);
        kept.extend(rows.clone().min_by(|&i, &j| seen.input[i].total_cmp(&seen.input[j])));
        kept.extend(rows.max_by(|&i, &j| seen.input[i].total_cmp(&seen.input[j])));
    }
    kept.sort_unstable();
    kept.dedup();
    let of_kept = |values: &[f64]| -> Vec<f64> { kept.iter().map(|&row| values[row]).collect() };
    let counts: Vec<bool> = kept.iter().map(|row| scored.binary_search(row).is_ok()).collect();
    let problem = Problem { input: &of_kept(&seen.input), output: &of_kept(&seen.output), scored: &counts };
    let fits = ENVELOPES.iter().filter_map(|&knots| {
        let options = Options {
            model: Kind::Mgpi,
            knots,
            plays: PLAYS,
            weights: Weights::Exponential,
            dead_zones: DEAD_ZONES,
            loss: Loss::Squares,
            starts: STARTS,
            seed: SEED,
            threads: 0,
            tolerance: TOLERANCE,
        };
        let fit = identify(&problem, &options, &|_| ()).ok()?;
        let rmse = Figures::of(problem.output, &fit.simulated, problem.scored).rmse;
        Some((penalised(rmse, &options), fit))
    });
    let (_, fit) = fits.min_by(|(one, _), (other, _)| one.total_cmp(other))?;
    Some(Operator { parameters: fit.parameters, density: fit.density })
}
