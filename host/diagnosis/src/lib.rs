//! What a model gets wrong about a recording, the physical cause of it, and whether there is one that can be named.
//!
//! # Design
//! | file | what it does |
//! |---|---|
//! | [`anatomy`] | shows the residual: what it goes with, where it is worst, what is noise, what the recording can show |
//! | [`causes`] | the causes that can be named: a file each |
//! | [`candidate`] | a set of them with its fit |
//! | `misfit`, `states` | what the baseline gets wrong in the same way at every visit to a state |
//! | `row` | a scored row, and the block of time that it is in |
//! | [`signals`] | the recording, prepared: rates, tents, scored rows, blocks of time |
//! | `rates` | how a measured signal moves |
//! | `command`, `delay` | what is known of a command; a signal later |
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
//! | `chance` | what may be by chance of it |
//! | `placebo`, `autoregression` | what causes gain of errors that are drawn by chance |
//! | `regulator` | the regulator's own lag where the command alone was recorded |
//! | [`search`] | what is searched, and how a set is judged |
//! | [`screen`], [`race`], [`beam`] | which sets are tried |
//! | `rivals` | sets that the search hardly tells apart |
//! | `overlooked` | a fast cause that the search does not see |
//! | [`valve`] | the valve, told apart from the muscle |
//! | [`reject`], [`stuck`], [`slips`] | what is wrong but none of the causes |
//! | `proven` | whether what is named holds in a model that is simulated, all together and each cause |
//! | [`mod@poor`], [`trivial`] | whether the model that is written describes the recording |
//! | `noisy_input` | the input smoothed where its noise would pass for movement |
//! | [`turn`] | the loop over the whole range: its slope and its width |
//! | [`fitted`], [`physical`] | what a cause reads from a fitted set: parameters in units that people measure in, doubts |
//! | [`carrier`] | how its effect becomes an extension of the model |
//! | [`simulated`] | what it reads from a model that is simulated |
//! | `second_order` | mass and viscosity together |
//! | [`shown`] | their names and units, those of the recording |
//! | [`mod@extend`] | the operator model extended by the named causes, running free, and its gain |
//! | `measured` | the named causes' parameters as that has them |
//! | [`diagnosed`] | all of it from a table to the model that is written |
//! | [`json`] | a diagnosis for programs |
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
mod autoregression;
pub mod basis;
pub mod beam;
pub mod candidate;
pub mod carrier;
pub mod causes;
mod chance;
mod command;
mod delay;
mod design;
pub mod diagnosed;
pub mod effect;
pub mod equivalent;
pub mod extend;
pub mod fit;
pub mod fitted;
mod follower;
pub mod free_run;
pub mod gain;
pub mod json;
mod low_pass;
mod measured;
mod misfit;
mod noisy_input;
pub mod output;
mod overlooked;
pub mod physical;
mod placebo;
pub mod plan;
pub mod poor;
mod proven;
pub mod pure_error;
pub mod race;
mod rates;
mod recorded;
mod regulator;
pub mod reject;
mod rivals;
mod row;
mod scored;
pub mod screen;
pub mod search;
mod second_order;
mod series;
pub mod shown;
pub mod signals;
pub mod simulated;
pub mod slips;
pub mod smoothing;
mod states;
pub mod stuck;
mod swing;
#[cfg(test)]
#[path = "../../recording/src/synthetic.rs"]
mod synthetic;
mod thinning;
pub mod trivial;
pub mod turn;
mod unexamined;
pub mod valve;
pub mod verdict;
pub mod words;

#[cfg(test)]
mod tests;

use thiserror::Error;

use anatomy::examinable::{Examinable, Inseparable, examinable, inseparable};
use anatomy::excitation::Excitation;
use anatomy::{Anatomy, LEAST_ROWS, Residual, TooShort};
use candidate::Candidate;
use causes::needs::ValveView;
use causes::{Cause, Fits};
use extend::{Extended, Extender, Operator, Plain, likely};
use identification::IdentificationError;
use measured::measure;
pub use noisy_input::Smoothing;
use overlooked::overlooked;
use poor::{Better, Poor, poor};
use proven::{Proven, proven};
use race::is_same;
use recording::drop_out::DropOut;
use recording::noise::{self, NoiseFloor};
use recording::numbers::{range, root_mean_square};
use recording::unit::Unit;
use reject::{Unexplained, is_repeatable, no_gain, unexplained as unexplained_by};
use rivals::{Alike, Settled, alike, alike_in_chain, not_told_apart, settled};
use scored::Scored;
use search::Search;
use signals::Signals;
use unexamined::{unexamined, unexcited};
use valve::{ValveFit, examine};
pub use verdict::{Named, Tried, Verdict};

/// The columns of a recording.
#[derive(Clone, Debug, Default)]
pub struct Columns {
    /// Unit: s.
    pub time_s: Vec<f64>,
    /// What the muscle is modelled from.
    pub input: Vec<f64>,
    /// Unit of the input, and of the command beside it.
    pub input_unit: Unit,
    /// Unit of the output, for what is said of its errors.
    pub output_unit: Unit,
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
    /// No row before is scored since its past is unknown, see [`recording::history`]; None where all pasts are known. Unit: s.
    pub past_unknown_until_s: Option<f64>,
    /// How the input was smoothed, see [`Self::with_smooth_input`]; None where it is as measured.
    pub smoothing: Option<Smoothing>,
    /// The input as it was measured, where it was smoothed. Input unit.
    pub measured_input: Option<Vec<f64>>,
    /// What the sensors did not measure; it is not scored, and straight lines are in its place.
    pub drop_outs: Vec<DropOut>,
}

impl Columns {
    /// The noise of the output in the scored rows. Output unit.
    pub fn noise_floor(&self) -> NoiseFloor {
        noise::floor(&self.of_scored(&self.time_s), &self.of_scored(&self.output))
    }

    /// What a column has in the rows that may be scored.
    fn of_scored(&self, values: &[f64]) -> Vec<f64> {
        values.iter().zip(&self.scored).filter(|(_, scored)| **scored).map(|(value, _)| *value).collect()
    }
}

/// The share of the work behind which causes without an excitation are asked.
const AGAIN_FROM: f64 = 0.9;
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
    /// No operator model can be identified, or simulated.
    #[error("no operator model can be made of the recording: {0}")]
    NoModel(IdentificationError),
}

/// A diagnosis. Errors in the output's unit.
#[derive(Clone, Debug)]
pub struct Diagnosis {
    /// What it comes to.
    pub verdict: Verdict,
    /// The named causes; none where the verdict names none.
    pub causes: Vec<Named>,
    /// The causes that fit best where they do not explain the recording.
    pub best_fit: Vec<Named>,
    /// Other sets of causes that do as well.
    pub alternatives: Vec<Vec<Cause>>,
    /// What is seen and not explained.
    pub unexplained: Option<Unexplained>,
    /// What the recording can show.
    pub examinable: Vec<Examinable>,
    /// Causes that it could show, and not tell apart.
    pub inseparable: Inseparable,
    /// A set with causes that it cannot show, which does as well as the named one, or leaves nothing unexplained; where the verdict is
    /// [`Verdict::Adequate`], causes each of which does more than is by chance. None where there are no such.
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
    /// How the input was smoothed, if it was.
    pub smoothing: Option<Smoothing>,
}

impl Diagnosis {
    /// Whether a cause is found between command and pressure, and not in the muscle.
    pub fn is_judged_at_the_valve(&self, cause: Cause) -> bool {
        of_valve(self.valve.as_ref()).any(|found| found == cause)
    }
}

/// Diagnoses a recording. `progress` is called with a share of the work and what is being done.
///
/// # Errors
/// See [`DiagnosisError`].
pub fn diagnose(
    columns: &Columns,
    progress: &(dyn Fn(f64, &str) + Sync),
) -> Result<Diagnosis, DiagnosisError> {
    Ok(diagnose_and_extend(columns, None, progress)?.0)
}

/// The same, and the operator model extended by what is named. The named causes' parameters are then those of that model, if it is
/// near enough, but for a lag before a mass: of the two it has no more than the second order. A given operator model is gone on
/// from, unless its form is too poor: that is then named too.
///
/// # Errors
/// See [`DiagnosisError`].
pub fn diagnose_and_extend(
    columns: &Columns,
    given: Option<&Operator>,
    progress: &(dyn Fn(f64, &str) + Sync),
) -> Result<(Diagnosis, Extended), DiagnosisError> {
    check(columns)?;
    let shown = among((columns, given), Asked::Excited, progress)?;
    let (verdict, beyond) = (shown.0.verdict, &shown.0.unexamined);
    if verdict != Verdict::Unexplained || beyond.is_empty() {
        return Ok(shown);
    }
    // What would leave nothing unexplained is asked in earnest, with all its rivals.
    let again = |share, what: &str| progress(AGAIN_FROM + (1.0 - AGAIN_FROM) * share, what);
    let (mut all, extended) = among((columns, given), Asked::All, &again)?;
    if all.verdict == Verdict::Unexplained {
        return Ok(shown);
    }
    unexamined::admit(&mut all);
    Ok((all, extended))
}

/// Which causes of the muscle are searched for.
#[derive(Clone, Copy, PartialEq)]
enum Asked {
    /// Those that the recording has an excitation for.
    Excited,
    /// Those too that it only has the columns for.
    All,
}

/// A diagnosis of a recording that was checked.
fn among(
    (columns, given): (&Columns, Option<&Operator>),
    asked: Asked,
    progress: &(dyn Fn(f64, &str) + Sync),
) -> Result<(Diagnosis, Extended), DiagnosisError> {
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
    let examinable = examinable(&excitation, view, columns.input_unit.symbol());
    let is_excited =
        |cause: Cause| examinable.iter().any(|judged| judged.cause == cause && judged.examinable);
    let can_show =
        |cause: Cause| is_excited(cause) || asked == Asked::All && cause.about().fits != Fits::Excited;
    let is_behind_input = |cause: Cause| cause.about().fits != Fits::Command || columns.input_is_command;
    let muscle = Cause::ALL.into_iter().filter(|&cause| can_show(cause) && is_behind_input(cause)).collect();
    progress(0.1, "baseline");
    let (input_noise, scored_rows) = (signals.input_noise, signals.scored());
    let searched = || {
        let search = Search::new(&mut signals, muscle, excitation.longest_hold_s())?;
        Some(search.run_for_either_past(&|share| progress(0.15 + 0.6 * share, "sets of causes")))
    };
    // What the valve does and the model without causes say nothing about the muscle's.
    let beside = || (examine(columns, input_noise), Plain::new(columns, &scored_rows));
    let ((valve, plain), searched) = rayon::join(beside, searched);
    let (search, (best, sizes)) = searched.ok_or(DiagnosisError::NoBaseline)?;
    let extender = Extender::new(columns, &search, plain.map_err(DiagnosisError::NoModel)?);
    let mut found = settled(&search, (&best, &sizes), &extender);
    // No choice of the search, so its rivals are those of the width alone.
    found.set = found.set.with_viscosity(&sizes).unwrap_or(found.set);
    progress(0.8, "what is left");
    let unexplained = unexplained_by(&search, &found.set);
    let unexplained = beside_model(&search, &found.set, unexplained, || extender.errors_without());
    let is_named = unexplained.is_none();
    let look = |base: &Candidate| overlooked(&search, (base, &sizes), &extender);
    let is_silent = found.set.causes.is_empty() && is_named;
    if let Some(overlooked) = is_silent.then(|| look(&found.set)).flatten() {
        found = overlooked;
    }
    let simulating = |share| progress(0.8 + 0.2 * share, "the extended model");
    let prove = |set| proven(&extender, (set, valve.as_ref()), &sizes, given, &simulating);
    // Where nothing is named, nothing of the muscle extends the model.
    let mut proof = prove(if is_named { &found.set } else { &search.baseline })?;
    // Where the simulated model gains nothing from what the search has found, it is asked what it finds itself.
    if let Some(overlooked) = proof.is_needless.then(|| look(&search.baseline)).flatten() {
        proof = prove(&overlooked.set)?;
        found = overlooked;
    }
    let Settled { set: best, alternatives, evidence } = found;
    let named = if is_named { &best } else { &search.baseline };
    let Proven { set, wider, mut extended, refuted, is_needless } = proof;
    // What is left of the causes may leave something unexplained.
    let is_less = set.causes.len() < named.causes.len();
    let unexplained = if is_less { unexplained_by(&search, &set) } else { unexplained };
    let (best, mut alternatives, evidence) = match is_less {
        true => {
            let alternatives = not_told_apart(&search, (&set, &set.causes), &sizes);
            (set, alternatives, None)
        }
        false => (best, alternatives, evidence),
    };
    let mut inseparable = inseparable(&examinable, &excitation);
    let Alike { untold, told } = alike(&search, &best, &inseparable.causes, &sizes);
    if untold.is_empty() {
        inseparable.leave_out(&told);
    }
    let in_chain = || alike_in_chain(&search, &best, &sizes);
    let in_chain = columns.input_is_command.then(in_chain).into_iter().flatten();
    for rival in wider.into_iter().chain(untold).chain(in_chain) {
        if !alternatives.iter().any(|other| is_same(other, &rival)) {
            alternatives.push(rival);
        }
    }
    let named = if is_named { &best } else { &search.baseline };
    let errors = || extended.errors(columns, &scored_rows);
    let unexplained = beside_model(&search, &best, unexplained, errors);
    let unexplained = unexplained.or(refuted);
    let is_third_order = !is_needless && named.is_third_order();
    let beyond = || unexamined(&search, (&best, &sizes), unexplained.as_ref(), &examinable);
    let unexamined = (!is_needless).then(beyond).flatten().unwrap_or_default();
    let has_unexamined_rival = unexplained.is_none() && !unexamined.is_empty();
    // A form that is wrong by more than visits to the same state differ by comes before that.
    let is_form_asked = match unexplained {
        None => true,
        Some(Unexplained::NotRepeatable { .. }) => best.causes.is_empty(),
        Some(_) => false,
    };
    let poor = is_form_asked.then(|| shaped(&search, columns, &mut extended)).flatten();
    // Where nothing else is seen, the form of a good model is what it gets wrong, and has a name.
    let (form, poor) = match poor {
        Some(poor) if unexplained.is_none() && poor.is_form() => (Some(poor), None),
        poor => (None, poor),
    };
    let unexplained = poor.map(Unexplained::Poor).or(unexplained);
    if unexplained.is_some() {
        let sets = likely((&best, &sizes), &extended.causes);
        let others = extender.extend_each(&sets, valve.as_ref(), given);
        extended.others = others.into_iter().chain(of_other_form(&search, columns, &extended)).collect();
    }
    let (best, mut alternatives, evidence, valve) = match is_needless {
        true => (search.baseline.clone(), Vec::new(), None, None),
        false => (best, alternatives, evidence, valve),
    };
    if has_unexamined_rival {
        alternatives.push(unexamined.clone());
    }
    let mut diagnosis =
        conclude((columns, &search), best, &sizes, (unexplained, alternatives), valve, examinable)?;
    if let Some(named) = diagnosis.causes.first_mut() {
        named.evidence.extend(evidence);
    }
    diagnosis.inseparable = inseparable;
    diagnosis.unexamined = unexamined;
    measure(&mut diagnosis, &extended, is_third_order, noise::steps(&columns.time_s).0);
    if let Some(given) = extended.given.as_ref().filter(|given| given.is_too_poor()) {
        diagnosis.causes.extend(Named::given_shape(given, &extended.model.parameters, columns.output_unit));
    }
    diagnosis.causes.extend(form.and_then(|form| Named::shape(&form, columns.output_unit)));
    if diagnosis.verdict == Verdict::Adequate && !diagnosis.causes.is_empty() {
        diagnosis.verdict = Verdict::Explained;
    }
    match diagnosis.verdict {
        Verdict::Adequate => diagnosis.unexamined = unexcited(&search, &extender, &diagnosis.examinable),
        Verdict::Unexplained => diagnosis.best_fit = std::mem::take(&mut diagnosis.causes),
        Verdict::Explained | Verdict::Confounded => {}
    }
    Ok((diagnosis, extended))
}

/// What is unexplained beside a set, where a model with its causes is off by these `errors`: without causes, visits to the same state that
/// are alike in that model are so.
fn beside_model(
    search: &Search<'_>,
    set: &Candidate,
    unexplained: Option<Unexplained>,
    errors: impl FnOnce() -> Option<Vec<f64>>,
) -> Option<Unexplained> {
    let is_alike = || errors().is_some_and(|errors| is_repeatable(search, &errors));
    match unexplained {
        Some(Unexplained::NotRepeatable { .. }) if set.causes.is_empty() && is_alike() => None,
        seen => seen,
    }
}

/// Whether the model that is written is too poor. Where a hysteresis of any form is better than the model without extensions, operators
/// of other forms are tried first, and the best of them is then what is written.
fn shaped(search: &Search<'_>, columns: &Columns, extended: &mut Extended) -> Option<Poor> {
    let first = poor(search, columns, extended)?;
    let is_form = matches!(first.better, Some((Better::AnyHysteresis, _)));
    if !extended.causes.is_empty() || !is_form {
        return Some(first);
    }
    let reshaped = of_other_form(search, columns, extended);
    match reshaped.filter(|reshaped| no_gain(reshaped).is_none()) {
        None => Some(first),
        Some(reshaped) => {
            *extended = reshaped;
            poor(search, columns, extended)
        }
    }
}

/// The model without extensions of the form that predicts best.
fn of_other_form(search: &Search<'_>, columns: &Columns, extended: &Extended) -> Option<Extended> {
    extended.reshaped(Plain::of_other_form(columns, &search.signals.scored())?, columns)
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
    let causes = verdict::named(search, &best, sizes, valve.as_ref(), columns.output_unit);
    let mut alternatives = if causes.is_empty() { Vec::new() } else { alternatives };
    // What the valve does stands apart from the muscle, whose causes alone have rivals.
    for alternative in &mut alternatives {
        let more: Vec<Cause> =
            of_valve(valve.as_ref()).filter(|cause| !alternative.contains(cause)).collect();
        alternative.extend(more);
    }
    // Of second order, a set may come to other names than its causes'.
    let names: Vec<Cause> = causes.iter().map(|named| named.cause).collect();
    alternatives.retain(|alternative| !is_same(alternative, &names));
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
        best_fit: Vec::new(),
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
        past_unknown_until_s: columns.past_unknown_until_s,
        smoothing: columns.smoothing,
    })
}

/// The causes that are found between command and pressure.
fn of_valve(valve: Option<&ValveFit>) -> impl Iterator<Item = Cause> {
    let named = valve.into_iter().flat_map(|fit| &fit.named);
    named.filter_map(|(part, _)| Cause::of_valve(*part)).map(|(cause, _)| cause)
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
