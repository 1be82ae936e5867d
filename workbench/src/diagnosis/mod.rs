//! What a model gets wrong about a recording, the physical cause of it, and whether there is one that can be named.
//!
//! # Design
//! | file | what it does |
//! |---|---|
//! | [`anatomy`] | shows the residual: what it goes with, where it is worst, what is noise, what the recording can show |
//! | [`cause`], [`candidate`] | the causes that can be named, and a set of them with its fit |
//! | [`signals`] | the recording, prepared: rates, tents, scored rows, blocks of time |
//! | `history` | from when on it tells what the muscle has been through |
//! | `rates` | how a measured signal moves |
//! | `recorded` | all rows of it, for what is quicker than the kept ones show |
//! | `scored` | the scored rows of it |
//! | `thinning` | the rows of it that are enough for a direction or a rank |
//! | [`basis`] | the baseline: any rate-independent hysteresis, linear in its weights |
//! | [`effect`], [`equivalent`], [`output`] | each cause as a nested extension in its physical place |
//! | [`fit`] | baseline and effects together by Gauss-Newton, and tried on blocks that it has not seen |
//! | `series` | a lag before a mass on the output, as one form |
//! | `follower` | what follows a goal by a linear law, exactly |
//! | [`free_run`], `swing` | the same without the measured contraction, and tuned to run free |
//! | [`gain`], [`pure_error`] | what a set of causes is judged by |
//! | [`screen`], [`search`] | which sets are tried |
//! | `rivals` | sets that the search hardly tells apart |
//! | `overlooked` | a fast cause that the search does not see |
//! | [`valve`] | the valve, told apart from the muscle |
//! | [`reject`], [`stuck`] | what is wrong but none of the causes |
//! | [`physical`] | the parameters in units that people measure in |
//! | [`mod@extend`] | the operator model extended by the named causes, running free, and its gain |
//! | `measured` | the named causes' parameters as that has them |
//! | [`words`] | the verdict in a sentence, and the experiment that is left to be made |
//!
//! # Contract
//! The verdict does not depend on the number of threads. A cause is named only where the recording can show it, where
//! the evidence on blocks of time that its fit has not seen is clear, and where no other set does as well.
//!
//! # Limits
//! The thresholds of the evidence were found on simulated plants of two kinds and hold where the noise, the number of
//! cycles and the misfit of the operator model are of that order. A cause whose form is far from ours may come out as a
//! neighbour of it; the pure error then says that something is left.

pub mod anatomy;
pub mod basis;
pub mod candidate;
pub mod cause;
mod design;
pub mod effect;
pub mod equivalent;
pub mod extend;
pub mod fit;
mod follower;
pub mod free_run;
pub mod gain;
mod history;
mod measured;
pub mod output;
mod overlooked;
pub mod physical;
pub mod pure_error;
pub mod race;
mod rates;
mod recorded;
pub mod reject;
mod rivals;
mod scored;
pub mod screen;
pub mod search;
mod series;
pub mod signals;
pub mod stuck;
mod swing;
mod thinning;
mod unexamined;
pub mod valve;
pub mod verdict;
pub mod words;

#[cfg(test)]
mod tests;

use thiserror::Error;

use crate::numbers::{range, root_mean_square};
use anatomy::examinable::{Examinable, Inseparable, ValveView, examinable, inseparable};
use anatomy::excitation::Excitation;
use anatomy::noise::NoiseFloor;
use anatomy::{Anatomy, LEAST_ROWS, Residual, TooShort};
use candidate::Candidate;
use cause::Cause;
use extend::{Extended, Extender, Operator, Plain};
use measured::measure;
use overlooked::{Overlooked, overlooked};
use reject::{Unexplained, no_gain, unexplained};
use rivals::{Settled, settled};
use scored::Scored;
use search::Search;
use signals::Signals;
use unexamined::unexamined;
use valve::{ValveFit, examine};
pub use verdict::{Named, Tried, Verdict};

/// The columns of a recording.
#[derive(Clone, Debug, Default)]
pub struct Columns {
    /// Unit: s.
    pub time_s: Vec<f64>,
    /// What the muscle is modelled from.
    pub input: Vec<f64>,
    /// Whether that is the command, the pressure unknown.
    pub input_is_command: bool,
    /// The command, where the input is the measured pressure.
    pub command: Option<Vec<f64>>,
    /// Measured contraction.
    pub output: Vec<f64>,
    /// Which rows are scored.
    pub scored: Vec<bool>,
    /// Unit: N.
    pub load_n: Option<Vec<f64>>,
    /// Unit: degree Celsius.
    pub temperature_c: Option<Vec<f64>>,
    /// No row before is scored since its past is unknown, see [`Self::with_known_past`]; None where all pasts are known. Unit: s.
    pub past_unknown_until_s: Option<f64>,
}

impl Columns {
    /// The noise of the output in the scored rows. Output unit.
    pub fn noise_floor(&self) -> NoiseFloor {
        anatomy::noise::floor(&self.of_scored(&self.time_s), &self.of_scored(&self.output))
    }

    /// What a column has in the rows that may be scored.
    fn of_scored(&self, values: &[f64]) -> Vec<f64> {
        values.iter().zip(&self.scored).filter(|(_, scored)| **scored).map(|(value, _)| *value).collect()
    }
}

/// Seed of what the anatomy measures chance with.
const ANATOMY_SEED: u64 = 1;

/// Why there is no diagnosis.
#[derive(Debug, Error, PartialEq)]
pub enum DiagnosisError {
    /// Too few rows.
    #[error(transparent)]
    TooShort(#[from] TooShort),
    /// The input or the output is constant.
    #[error("the {0} does not move: nothing can be diagnosed")]
    Still(&'static str),
    /// The baseline cannot be fitted.
    #[error("no baseline can be fitted to the recording")]
    NoBaseline,
}

/// A diagnosis. Errors in the output's unit.
#[derive(Clone, Debug)]
pub struct Diagnosis {
    /// What it comes to.
    pub verdict: Verdict,
    /// The named causes.
    pub causes: Vec<Named>,
    /// Other sets of causes that do as well.
    pub alternatives: Vec<Vec<Cause>>,
    /// What is seen and not explained.
    pub unexplained: Option<Unexplained>,
    /// What the recording can show.
    pub examinable: Vec<Examinable>,
    /// Causes that it could show, and not tell apart.
    pub inseparable: Inseparable,
    /// A set with causes that it cannot show, which does better than the named one, or leaves nothing unexplained. None where there is no
    /// such.
    pub unexamined: Vec<Cause>,
    /// Root mean square before and with the causes.
    pub rmse: (f64, f64),
    /// The same on blocks that the fit has not seen.
    pub heldout: (f64, f64),
    /// What visits to the same state differ by, before and with the causes; None where too few states are visited twice.
    pub pure_error: Option<(f64, f64)>,
    /// The residuals' rows, and the residuals before and with the causes.
    pub rows: Vec<usize>,
    /// Before.
    pub residual_before: Vec<f64>,
    /// With the causes.
    pub residual_after: Vec<f64>,
    /// The residual taken apart, before.
    pub anatomy: Anatomy,
    /// All sets of causes that were looked at, by size, the best first.
    pub tried: Vec<Tried>,
    /// The valve, if it can be told apart.
    pub valve: Option<ValveFit>,
    /// Rows before are not scored since their past is unknown, if there are such. Unit: s.
    pub past_unknown_until_s: Option<f64>,
}

/// Diagnoses a recording. `progress` is called with a share of the work and what is being done.
///
/// # Errors
/// See [`DiagnosisError`].
pub fn diagnose(
    columns: &Columns,
    progress: &(dyn Fn(f64, &str) + Sync),
) -> Result<Diagnosis, DiagnosisError> {
    Ok(diagnose_and(columns, progress, |_, _, _| Beyond { there: (), is_needless: false })?.0)
}

/// The same, and the operator model extended by what is named; None where there is none that runs through the recording.
/// The named causes' parameters are then those of that model, if it is near enough, but for a lag before a mass: of the two it has no more than
/// the second order. A given operator model is gone on from, unless its form is too poor: that is then named too.
///
/// # Errors
/// See [`DiagnosisError`].
pub fn diagnose_and_extend(
    columns: &Columns,
    given: Option<&Operator>,
    progress: &(dyn Fn(f64, &str) + Sync),
) -> Result<(Diagnosis, Option<Extended>), DiagnosisError> {
    let (mut diagnosis, (extended, is_third_order)) =
        diagnose_and(columns, progress, |found, valve, extender| {
            let progress = |share| progress(0.8 + 0.2 * share, "the extended model");
            let extend = |set: &Candidate| extender?.extend(set, valve, given, &progress);
            let extended = extend(found);
            let is_needless = !found.causes.is_empty() && extended.as_ref().and_then(no_gain).is_some();
            match extender.map(|extender| extender.search).filter(|_| is_needless) {
                Some(search) if unexplained(search, &search.baseline).is_none() => {
                    Beyond { there: (extend(&search.baseline), false), is_needless }
                }
                _ => Beyond { there: (extended, found.is_third_order()), is_needless: false },
            }
        })?;
    measure(&mut diagnosis, extended.as_ref(), is_third_order, anatomy::steps(&columns.time_s).0);
    if matches!(diagnosis.verdict, Verdict::Explained | Verdict::Confounded)
        && let Some(no_gain) = extended.as_ref().and_then(no_gain)
    {
        diagnosis.verdict = Verdict::Unexplained;
        diagnosis.unexplained = Some(no_gain);
    }
    if let Some(extended) = &extended
        && let Some(given) = extended.given.as_ref().filter(|given| given.is_too_poor())
    {
        diagnosis.causes.push(Named::shape(given, &extended.model.parameters));
        if diagnosis.verdict == Verdict::Adequate {
            diagnosis.verdict = Verdict::Explained;
        }
    }
    Ok((diagnosis, extended))
}

/// What is gone on to from what was found.
struct Beyond<T> {
    there: T,
    /// Whether the causes that were found are needless: they gain nothing, and nothing is left unexplained without them.
    is_needless: bool,
}

/// Diagnoses a recording, and goes on from what was found, with what extends the operator model, if one runs through the recording.
fn diagnose_and<T>(
    columns: &Columns,
    progress: &(dyn Fn(f64, &str) + Sync),
    go_on: impl FnOnce(&Candidate, Option<&ValveFit>, Option<&Extender<'_>>) -> Beyond<T>,
) -> Result<(Diagnosis, T), DiagnosisError> {
    check(columns)?;
    progress(0.0, "preparing");
    let mut signals = Signals::new(columns);
    let scored = Scored::of(columns);
    let excitation = Excitation::of(&scored.residual(&scored.output));
    let of_command = scored
        .command
        .as_ref()
        .map(|command| Excitation::of(&Residual { input: command, ..scored.residual(&scored.output) }));
    let view = match (&of_command, columns.input_is_command) {
        (Some(excitation), _) => ValveView::Beside(excitation),
        (None, true) => ValveView::InChain,
        (None, false) => ValveView::Unseen,
    };
    let examinable = examinable(&excitation, view, "bar");
    let can_show = |cause: Cause| examinable.iter().any(|judged| judged.cause == cause && judged.examinable);
    let muscle = Cause::ALL
        .into_iter()
        .filter(|&cause| can_show(cause) && (cause != Cause::ValveLag || columns.input_is_command));
    let muscle = muscle.collect();
    progress(0.1, "baseline");
    let (input_noise, scored_rows) = (signals.input_noise, signals.scored());
    let searched = || {
        let search = Search::new(&mut signals, muscle)?;
        let found = search.run(&|share| progress(0.15 + 0.6 * share, "sets of causes"));
        Some((search, found))
    };
    // What the valve does and the model without causes say nothing about the muscle's.
    let beside = || (examine(columns, input_noise), Plain::new(columns, &scored_rows));
    let ((valve, plain), searched) = rayon::join(beside, searched);
    let (search, (best, sizes)) = searched.ok_or(DiagnosisError::NoBaseline)?;
    let extender = plain.and_then(|plain| Extender::new(columns, &search, plain));
    let Settled { set: best, alternatives, evidence } = settled(&search, (&best, &sizes), extender.as_ref());
    // No choice of the search, so its rivals are those of the width alone.
    let best = best.with_viscosity(&sizes).unwrap_or(best);
    progress(0.8, "what is left");
    let unexplained = unexplained(&search, &best);
    let is_silent = best.causes.is_empty() && unexplained.is_none();
    let look = |extender: &Extender<'_>| overlooked(&search, sizes.first()?, extender);
    let (best, alternatives, evidence) = match extender.as_ref().filter(|_| is_silent).and_then(look) {
        Some(Overlooked { set, alternatives, evidence }) => (set, alternatives, Some(evidence)),
        None => (best, alternatives, evidence),
    };
    // Where nothing is named, nothing of the muscle extends the model.
    let named = if unexplained.is_some() { &search.baseline } else { &best };
    let Beyond { there, is_needless } = go_on(named, valve.as_ref(), extender.as_ref());
    let beyond = || unexamined(&search, (&best, &sizes), unexplained.as_ref(), &examinable);
    let unexamined = (!is_needless).then(beyond).flatten().unwrap_or_default();
    let (best, mut alternatives, evidence) = match is_needless {
        true => (search.baseline.clone(), Vec::new(), None),
        false => (best, alternatives, evidence),
    };
    if unexplained.is_none() && !unexamined.is_empty() {
        alternatives.push(unexamined.clone());
    }
    let inseparable = inseparable(&examinable, &excitation);
    let mut diagnosis =
        conclude((columns, &search), best, &sizes, (unexplained, alternatives), valve, examinable)?;
    if let Some(named) = diagnosis.causes.first_mut() {
        named.evidence.extend(evidence);
    }
    let past_unknown_until_s = columns.past_unknown_until_s;
    Ok((Diagnosis { inseparable, unexamined, past_unknown_until_s, ..diagnosis }, there))
}

fn conclude(
    (columns, search): (&Columns, &Search<'_>),
    best: Candidate,
    sizes: &[Vec<Candidate>],
    (unexplained, alternatives): (Option<Unexplained>, Vec<Vec<Cause>>),
    valve: Option<ValveFit>,
    examinable: Vec<Examinable>,
) -> Result<Diagnosis, DiagnosisError> {
    let baseline = &search.baseline;
    let causes = verdict::named(search, &best, sizes, valve.as_ref());
    let verdict = verdict::verdict(&causes, unexplained.as_ref(), &alternatives);
    let signals = search.signals;
    let of_rows = |values: &[f64]| -> Vec<f64> { signals.rows.iter().map(|row| values[row.at]).collect() };
    let rows = signals.scored();
    // As recorded: people look at these, and the search has them less their means.
    let recorded = |column: &Option<Vec<f64>>| -> Option<Vec<f64>> {
        column.as_ref().map(|values| rows.iter().map(|&row| values[row]).collect())
    };
    let (load, temperature) = (recorded(&columns.load_n), recorded(&columns.temperature_c));
    let residual = Residual {
        time_s: &of_rows(&signals.time_s),
        residual: &baseline.fit.residual,
        input: &of_rows(&signals.input),
        output: &of_rows(&signals.output),
        load: load.as_deref(),
        temperature: temperature.as_deref(),
    };
    // The floor is that of all rows: thinned ones are too far apart to tell noise from movement.
    let anatomy = Anatomy { noise: signals.noise_floor, ..Anatomy::of(&residual, ANATOMY_SEED)? };
    Ok(Diagnosis {
        verdict,
        causes,
        alternatives,
        unexplained,
        examinable,
        inseparable: Inseparable::default(),
        unexamined: Vec::new(),
        rmse: (root_mean_square(&baseline.residual), root_mean_square(&best.residual)),
        heldout: (baseline.score.mean(), best.score.mean()),
        pure_error: baseline.pure_error.zip(best.pure_error),
        residual_before: baseline.fit.residual.clone(),
        residual_after: best.residual.clone(),
        tried: verdict::tried(search, sizes),
        rows,
        anatomy,
        valve,
        past_unknown_until_s: None,
    })
}

fn check(columns: &Columns) -> Result<(), DiagnosisError> {
    let rows = columns.scored.iter().filter(|&&scored| scored).count();
    if rows < LEAST_ROWS {
        return Err(TooShort { rows }.into());
    }
    let moves = |values: &[f64]| {
        let (low, high) = range(values);
        high > low
    };
    if !moves(&columns.input) {
        return Err(DiagnosisError::Still("input"));
    }
    if !moves(&columns.output) {
        return Err(DiagnosisError::Still("contraction"));
    }
    Ok(())
}
