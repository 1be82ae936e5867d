//! From named causes to an extended model that runs free, and what it gains on data that its fit has not seen.
//!
//! # Design
//! | file | what it does |
//! |---|---|
//! | `beginnings` | the better of what two beginnings come to |
//! | `carry` | from the effects of the search, and the valve, to the extensions of the model |
//! | [`jump`] | a jump of the sensor's zero, which is the recording's and not the muscle's |
//! | `known` | what takes long to make, and is asked for again |
//! | `plain` | the model without extensions |
//! | `start` | the operator to begin with, identified from what the operators see in the search |
//! | `variables` | operator and extensions as numbers that a search can move |
//! | `shape` | operators of other forms than the plain model's |
//! | `slow` | what stays near where the search has it |
//! | `side` | whether a viscous lag is a force before the hysteresis or a lag behind it |
//! | `refine` | all of them together by Levenberg-Marquardt, on the residual of the model that runs free |
//! | `rests` | what the rows of a rest count where there is a mass |
//! | [`split`] | the rows that models are fitted to, and those that they are compared on |
//! | `roughness` | how unevenly an operator rises, and what resists motion, which costs where effects make its input |
//! | `compensating` | what the inverse goes by where thresholds follow the rate of the input |
//! | `thinned` | the rows that derivatives are taken on |
//! | [`given`] | what is said of an operator model that the user has |
//! | [`heldout`] | the gain on rows that took no part in the fit |
//! | [`written`] | which model is written, and what it is worth beside the plain one |
//!
//! # Contract
//! What is fitted has seen nothing of the output but the scored rows before the split, when the models are compared behind
//! it; then it is fitted further, with all rows. The model without extensions is fitted in the same way, of the same size, from the
//! extended one's operator too, but that its operator, which sees what was recorded, is free to rise as unevenly as that says; with
//! all rows, and the input as it was measured, it is never worse than what `mgpi identify` finds. Where nothing explains the
//! recording, other sets of causes are tried too, for what is written alone.
//!
//! # Limits
//! The causes, and where the fit begins, come from the whole recording, but for what stays near there (`slow`); a gain that is free
//! of that too takes another recording. A delay that was found between command and pressure has no place in the chain, and is left out.

mod beginnings;
mod carry;
mod compensating;
pub mod given;
pub mod heldout;
pub mod jump;
mod known;
mod plain;
mod refine;
mod rests;
mod roughness;
mod shape;
mod side;
mod slow;
pub mod split;
pub(super) mod start;
mod task;
mod thinned;
mod variables;
pub mod written;

use std::borrow::Cow;

use model_core::ExtensionParameters;
use rayon::prelude::*;

use super::Columns;
use super::candidate::Candidate;
use super::causes::Cause;
use super::race::is_same;
use super::search::Search;
use super::simulated::Simulated;
use super::valve::ValveFit;
use beginnings::{continued, nearer, plainer};
use compensating::compensating;
pub use given::Given;
pub use heldout::HeldOutGain;
use identification::{Density, HostExtendedModel, HostParameters, Options, Termination, Weights};
use jump::Jump;
use known::Known;
pub use plain::Plain;
use recording::figures::Figures;
use recording::numbers::{range, root_mean_square};
use recording::simulation::Rows;
use recording::unit::Unit;
use slow::Slow;
pub use split::Split;
use task::Task;
pub use written::Written;

/// An operator.
#[derive(Clone, Debug)]
pub struct Operator {
    /// Its raw parameters.
    pub parameters: HostParameters,
    /// What its plays come from.
    pub density: Density,
}

impl Operator {
    /// The same, valid for all inputs of a recording too.
    fn valid_for(mut self, columns: &Columns) -> Self {
        if let HostParameters::Cascade(cascade) = &mut self.parameters {
            let (low, high) = range(&columns.input);
            cascade.input_min = cascade.input_min.min(low);
            cascade.input_max = cascade.input_max.max(high);
        }
        self
    }

    fn with(&self, extensions: ExtensionParameters<f64>) -> Extension {
        Extension { parameters: self.parameters.clone(), density: self.density, extensions, jump: None }
    }
}

/// An operator with extensions.
#[derive(Clone, Debug)]
pub struct Extension {
    /// The operator.
    pub parameters: HostParameters,
    /// What its plays come from.
    pub density: Density,
    /// What the muscle does beside hysteresis.
    pub extensions: ExtensionParameters<f64>,
    /// What the sensor's zero did in the recording.
    pub jump: Option<Jump>,
}

/// A model extended by the named causes, and the same without.
#[derive(Clone, Debug)]
pub struct Extended {
    /// With the extensions.
    pub model: Extension,
    /// Its free-running answer, a value a row of the recording. Output unit.
    pub simulated: Vec<f64>,
    /// Without.
    pub plain: Extension,
    /// Its answer.
    pub plain_simulated: Vec<f64>,
    /// Root mean square error without, over the scored rows.
    pub baseline_rmse: f64,
    /// The same with the extensions.
    pub extended_rmse: f64,
    /// What it gains behind the split, by models of the rows before.
    pub heldout: HeldOutGain,
    /// How the last refinement ended, of the model with the extensions and of that without.
    terminations: (Termination, Termination),
    /// What is said of the operator model that was given, if one was.
    pub given: Option<Given>,
    /// Whether one of the causes is the valve's: the gain is then counted from the command.
    pub valve_is_named: bool,
    /// The causes of the set that extends it.
    pub(super) causes: Vec<Cause>,
    /// Models with other sets or of another form, which are written in its place where they predict better.
    pub(super) others: Vec<Extended>,
    /// The plain model of the input as it was measured, where that was smoothed.
    of_measured: Option<Plain>,
    counted: Counted,
}

/// What two models answer to the same input, a value a row. Output unit.
#[derive(Clone, Debug)]
pub struct Answers {
    /// Without extensions.
    pub plain: Vec<f64>,
    /// With them.
    pub extended: Vec<f64>,
    /// The command, where that was the input and the pressure was recorded too. Unit: bar.
    pub from_command: Option<Vec<f64>>,
}

/// What the gain was counted with.
#[derive(Clone, Debug)]
struct Counted {
    /// The scored rows.
    split: Split,
    /// What the search erred by.
    reached: f64,
    /// The models that were fitted to those that teach.
    plain: Extension,
    extended: Extension,
}

impl Extension {
    /// The free-running answer to a recording, a value a row; from a measured pressure without the valve. None where the
    /// model refuses a row. Output unit.
    pub fn answer(&self, columns: &Columns) -> Option<Vec<f64>> {
        let model = HostExtendedModel::try_new(&self.parameters, &self.acting(columns)).ok()?;
        let mut answer = rows(columns).answer(&model).ok()?;
        if let Some(jump) = self.jump {
            answer.iter_mut().zip(&columns.time_s).for_each(|(y, &time_s)| *y += jump.at(time_s));
        }
        Some(answer)
    }

    /// Measured less simulated at some rows of a recording; None where the model refuses a row. Output unit.
    pub(super) fn errors(&self, columns: &Columns, rows: &[usize]) -> Option<Vec<f64>> {
        let simulated = self.answer(columns)?;
        Some(rows.iter().map(|&row| columns.output[row] - simulated[row]).collect())
    }

    /// The model of the muscle alone, with the sensor's zero as it was at the end: for other recordings, and for the board.
    pub fn of_muscle(&self) -> Self {
        let Some(jump) = self.jump else { return self.clone() };
        Self { parameters: jump.behind(self.parameters.clone()), jump: None, ..self.clone() }
    }

    fn jumping(self, jump: Option<Jump>) -> Self {
        Self { jump, ..self }
    }

    /// The same, for what causes read from it; None where it cannot be simulated.
    pub fn simulated(&self) -> Option<Simulated<'_>> {
        Simulated::of(&self.parameters, &self.extensions).map(|model| model.jumping(self.jump))
    }

    /// The operator's form, as `mgpi compare` calls it.
    pub fn form(&self) -> String {
        let knots = match &self.parameters {
            HostParameters::Cascade(cascade) => start::knots(&cascade.envelope),
            HostParameters::Agpi(_) | HostParameters::Egpi(_) => None,
        };
        let weights = match self.density {
            Density::Exponential { .. } => Weights::Exponential,
            Density::Free { .. } => Weights::Free,
        };
        Options { model: self.parameters.kind(), knots, weights, ..Options::default() }.form()
    }

    /// Root mean square error over all rows of a recording that are scored; infinite where the model refuses a row. Output unit.
    fn rmse(&self, columns: &Columns) -> f64 {
        let rmse = |simulated: Vec<f64>| Figures::of(&columns.output, &simulated, &columns.scored).rmse;
        self.answer(columns).map(rmse).filter(|rmse| rmse.is_finite()).unwrap_or(f64::INFINITY)
    }

    /// The same behind the valve of another model.
    fn with_valve_of(mut self, other: &Self) -> Self {
        let ExtensionParameters { valve_lag, valve_deadband, supply_saturation, .. } = other.extensions;
        self.extensions =
            ExtensionParameters { valve_lag, valve_deadband, supply_saturation, ..self.extensions };
        self
    }

    /// The extensions behind the input of a recording.
    fn acting(&self, columns: &Columns) -> ExtensionParameters<f64> {
        if columns.input_is_command { self.extensions.clone() } else { self.extensions.without_valve() }
    }
}

impl Extended {
    /// An operator of another form in the place of the model, behind the same valve; None where it does not run through the recording.
    pub(super) fn reshaped(&self, shape: Plain, columns: &Columns) -> Option<Self> {
        let Plain { taught, whole, termination } = shape;
        let [taught, whole] = [taught, whole].map(|operator| operator.with_valve_of(&self.model));
        let models = (&self.counted.plain, &taught);
        let seen = self.seen_from(columns);
        Some(Self {
            heldout: heldout::gain(&seen, &self.counted.split, models, self.heldout.noise_floor)?,
            simulated: whole.answer(&seen)?,
            extended_rmse: whole.rmse(&seen),
            model: whole,
            terminations: (termination, self.terminations.1),
            counted: Counted { extended: taught, ..self.counted.clone() },
            ..self.clone()
        })
    }

    /// What the model of the muscle is off by at some rows of a recording, from the pressure where that was recorded; None where it does
    /// not run through it. Output unit.
    pub(super) fn errors(&self, columns: &Columns, rows: &[usize]) -> Option<Vec<f64>> {
        self.model.errors(columns, rows)
    }

    /// What other extensions gain in the place of those that were found, the operator fitted anew beside them, counted as
    /// [`Self::heldout`] is. `other` makes them from the model that the rows before the split have taught: [`Self::model`] has seen
    /// those that the gain is counted on. None where there are none, or no model runs through the recording.
    pub fn gain_with(
        &self,
        columns: &Columns,
        other: impl FnOnce(&Extension) -> Option<ExtensionParameters<f64>>,
    ) -> Option<HeldOutGain> {
        let Counted { split, reached, plain, extended } = &self.counted;
        let extensions = other(extended)?;
        let task = Task { columns, scored: &split.taught, reached: *reached, rests_once: true };
        let there = task.operator_refined(Extension { extensions, ..extended.clone() })?;
        // It began where other extensions had led it.
        let fitted = task.operator_refined(there)?;
        let seen = self.seen_from(columns);
        heldout::gain(&seen, split, (plain, &fitted), self.heldout.noise_floor)
    }

    /// What the models without and with the extensions answer to a recording, a value a row, from the input that the gain is
    /// counted from. None where one of them does not run through it. Output unit.
    pub fn answers(&self, columns: &Columns) -> Option<Answers> {
        let seen = self.seen_from(columns);
        let from_command = matches!(seen, Cow::Owned(_)).then(|| seen.input.clone());
        Some(Answers { plain: self.plain.answer(&seen)?, extended: self.model.answer(&seen)?, from_command })
    }

    /// A recording with the input that the gain is counted from: where something is wrong with the valve the command, also
    /// where the pressure was recorded.
    fn seen_from<'a>(&self, columns: &'a Columns) -> Cow<'a, Columns> {
        seen_from(columns, self.valve_is_named)
    }
}

fn seen_from(columns: &Columns, valve_is_named: bool) -> Cow<'_, Columns> {
    match &columns.command {
        Some(command) if valve_is_named => Cow::Owned(Columns {
            // A recording may begin before the valve has come to its first command: the model's valve begins at the first pressure.
            input: columns.input.iter().take(1).chain(command.iter().skip(1)).copied().collect(),
            input_is_command: true,
            command: None,
            ..columns.clone()
        }),
        _ => Cow::Borrowed(columns),
    }
}

/// What drives a model of a recording.
pub(super) fn rows(columns: &Columns) -> Rows<'_> {
    Rows {
        time_s: &columns.time_s,
        input: &columns.input,
        load: columns.load_n.as_deref(),
        temperature: columns.temperature_c.as_deref(),
    }
}

/// Sets of each size whose models are tried where the search's own choice explains nothing.
const LIKELY: usize = 2;

/// The set that the search has chosen and the best of each size, without the set of the given causes: where no cause can be named,
/// a model with one of them may still predict better.
pub fn likely<'a>((best, sizes): (&'a Candidate, &'a [Vec<Candidate>]), but: &[Cause]) -> Vec<&'a Candidate> {
    let mut likely: Vec<&Candidate> = Vec::new();
    for set in [best].into_iter().chain(sizes.iter().flat_map(|size| size.iter().take(LIKELY))) {
        let is_known = |causes: &[Cause]| is_same(causes, &set.causes);
        if !set.causes.is_empty() && !is_known(but) && !likely.iter().any(|other| is_known(&other.causes)) {
            likely.push(set);
        }
    }
    likely
}

/// Which beginning an operator is: the causes of the set beside it, what that costs, and the rows that it was identified from.
type StartOf = (Vec<Cause>, f64, Taught);

/// Rows that teach.
#[derive(Clone, Copy, PartialEq)]
enum Taught {
    /// Those before the split, or between the stretches that are held out.
    ByPart,
    /// All.
    ByAll,
}

/// Where the operator model of a recording is extended by sets of causes.
pub struct Extender<'a> {
    columns: &'a Columns,
    /// What was searched.
    pub search: &'a Search<'a>,
    scored: Vec<usize>,
    split: Split,
    plain: Plain,
    of_measured: Option<Plain>,
    /// The plain model's error over all scored rows, root mean square. Output unit.
    pub without: f64,
    /// What the operator begins with beside sets that were tried.
    starts: Known<StartOf, Option<Operator>>,
    /// The models of all scored rows that were asked for, by what names a set and its fit.
    models: Known<(Vec<Cause>, f64), Option<Extension>>,
}

impl<'a> Extender<'a> {
    /// From the plain model.
    pub fn new(columns: &'a Columns, search: &'a Search<'a>, plain: Plain) -> Self {
        let scored = search.signals.scored();
        let without = Task::alone(columns, &scored).rms(&plain.whole).unwrap_or(f64::INFINITY);
        let of_measured = Plain::of_measured(columns, &scored);
        let split = Split::of(columns, &scored);
        Self {
            columns,
            search,
            scored,
            split,
            plain,
            of_measured,
            without,
            starts: Known::default(),
            models: Known::default(),
        }
    }

    /// Unit of the output.
    pub fn output_unit(&self) -> Unit {
        self.columns.output_unit
    }

    /// The error of the model with the causes of a set over all scored rows; None where no such model runs through them. Output unit.
    pub fn with(&self, set: &Candidate) -> Option<f64> {
        self.error(&self.model(set)?)
    }

    /// That model.
    pub fn model(&self, set: &Candidate) -> Option<Extension> {
        let fitted = || {
            let extensions = carry::extensions(self.columns, self.search, set);
            self.found(&self.task(set, &self.scored), set, extensions, &self.plain.whole)
        };
        self.models.get((set.causes.clone(), set.cost()), fitted)
    }

    /// The error of a model over all scored rows; None where it does not run through them. Output unit.
    pub fn error(&self, model: &Extension) -> Option<f64> {
        Task::alone(self.columns, &self.scored).rms(model)
    }

    /// The plain model's error over all scored rows where it may begin from the operator of another model too. Output unit.
    pub fn without_from(&self, other: &Extension) -> f64 {
        let plain = plainer(&Task::alone(self.columns, &self.scored), self.plain.whole.clone(), other);
        self.error(&plain).unwrap_or(self.without)
    }

    fn task<'b>(&self, set: &Candidate, scored: &'b [usize]) -> Task<'b>
    where
        'a: 'b,
    {
        Task { reached: root_mean_square(&set.residual), ..Task::alone(self.columns, scored) }
    }

    /// The operator with the extensions of a set, fitted to the rows of a task; None where no model runs through them.
    fn found(
        &self,
        task: &Task<'_>,
        set: &Candidate,
        extensions: ExtensionParameters<f64>,
        plain: &Extension,
    ) -> Option<Extension> {
        let jump = carry::jump(self.columns, self.search, set);
        let start = self.start(set, Taught::ByPart)?.with(extensions.clone()).jumping(jump);
        let (found, _) = task.refined(start)?;
        side::nearer(task, nearer(task, found, plain, extensions)?)
    }

    /// What the operator begins with beside a set.
    fn start(&self, set: &Candidate, taught: Taught) -> Option<Operator> {
        let identified = || {
            let kept = self.search.signals.rows.iter().map(|row| row.at);
            let rows: Vec<usize> =
                kept.filter(|&row| taught == Taught::ByAll || self.split.teaches(row)).collect();
            let operator = start::operator(&start::Seen::of(self.search, set), &rows).ok()?;
            Some(operator.valid_for(self.columns))
        };
        self.starts.get((set.causes.clone(), set.cost(), taught), identified)
    }

    /// What a model gains over another one on all scored rows; None where one does not run through them.
    pub fn gain_between(&self, one: &Extension, other: &Extension) -> Option<HeldOutGain> {
        heldout::on_all(self.columns, (one, other))
    }

    /// What the plain model is off by at the scored rows; None where it does not run through them. Output unit.
    pub fn errors_without(&self) -> Option<Vec<f64>> {
        self.plain.whole.errors(self.columns, &self.scored)
    }

    /// What a model of the muscle gains over another one that has less, if that is clear: from the pressure where that was recorded, since
    /// what the valve is off by would hide it.
    pub fn gain_of_muscle(&self, extended: &Extended, less: &Extended) -> Option<HeldOutGain> {
        let models = (&less.counted.extended, &extended.counted.extended);
        let heldout = heldout::gain(self.columns, &self.split, models, extended.heldout.noise_floor)?;
        let [before, after] = [less, extended].map(|extended| extended.model.rmse(self.columns));
        heldout.is_clear(before, after).then_some(heldout)
    }

    /// Extends the operator model by each of a few sets; a set with which no model can be simulated is left out.
    pub fn extend_each(
        &self,
        sets: &[&Candidate],
        valve: Option<&ValveFit>,
        given: Option<&Operator>,
    ) -> Vec<Extended> {
        sets.par_iter().filter_map(|set| self.extend(set, valve, given, &|_| ())).collect()
    }

    /// Extends the operator model by the causes of a set and those of the valve, to be compared with the plain one; None where no
    /// model runs through the recording. The operator goes on from a given one, unless there is none or its form is too poor.
    /// `progress` is called with the share of the work that is done.
    pub fn extend(
        &self,
        set: &Candidate,
        valve: Option<&ValveFit>,
        given: Option<&Operator>,
        progress: &(dyn Fn(f64) + Sync),
    ) -> Option<Extended> {
        let Self { columns, search, scored, split, .. } = self;
        let Split { taught, .. } = split;
        let [before, whole] =
            [taught, &scored[..]].map(|scored| Task { rests_once: true, ..self.task(set, scored) });
        let Plain { taught: mut plain, whole: mut plain_of_all, termination: mut plain_ended } =
            self.plain.clone();

        let mut extensions = carry::extensions(columns, search, set);
        let is_plain = set.causes.is_empty() && extensions == ExtensionParameters::default();
        let slow = Slow::of(&extensions);
        if let Some(slow) = Slow::taught(columns, search, set, split) {
            slow.put(&mut extensions);
        }
        carry::add_valve(&mut extensions, valve);
        let mut extended = if is_plain {
            Extension { extensions, ..plain.clone() }
        } else {
            let found = self.found(&before, set, extensions, &plain)?;
            plain = plainer(&Task::alone(columns, taught), plain, &found);
            progress(0.4);
            found
        };
        let given = match given {
            None => None,
            Some(operator) => {
                let before_it = |all: &_| carry::before_operator(all, search, set);
                let (given, refitted) = given::judge(&before, operator, (&plain, &extended), before_it)?;
                if !given.is_too_poor() {
                    (plain, _) = before.refined(operator.with(ExtensionParameters::default()))?;
                    (plain_of_all, plain_ended) = whole.refined(plain.clone())?;
                    extended = refitted;
                }
                Some(given)
            }
        };
        progress(0.7);
        let valve_is_named = valve.is_some_and(|fit| !fit.named.is_empty());
        let seen = seen_from(columns, valve_is_named);
        let heldout = heldout::gain(&seen, split, (&plain, &extended), search.signals.noise)?;

        let reached = whole.reached;
        let counted = Counted { split: split.clone(), reached, plain, extended: extended.clone() };
        let mut model = Extension { extensions: extended.extensions.clone(), ..plain_of_all.clone() };
        let mut ended = plain_ended;
        if !is_plain {
            slow.put(&mut extended.extensions);
            let from_search = || {
                let mut extensions = carry::extensions(columns, search, set);
                carry::add_valve(&mut extensions, valve);
                let jump = carry::jump(columns, search, set);
                Some(self.start(set, Taught::ByAll)?.with(extensions).jumping(jump))
            };
            let from_search: Option<&dyn Fn() -> _> = given.is_none().then_some(&from_search);
            (model, ended) = continued(&whole, extended, &plain_of_all, from_search)?;
            let plainer = plainer(&Task::alone(columns, scored), plain_of_all.clone(), &model);
            if plainer.rmse(columns) < plain_of_all.rmse(columns) {
                plain_of_all = plainer;
            }
        }
        let model = compensating(model);
        let (simulated, plain_simulated) = (model.answer(&seen)?, plain_of_all.answer(&seen)?);
        progress(1.0);
        Some(Extended {
            baseline_rmse: plain_of_all.rmse(&seen),
            extended_rmse: model.rmse(&seen),
            model,
            simulated,
            plain: plain_of_all,
            plain_simulated,
            heldout,
            terminations: (ended, plain_ended),
            given,
            valve_is_named,
            causes: set.causes.clone(),
            others: Vec::new(),
            of_measured: self.of_measured.clone(),
            counted,
        })
    }
}

#[cfg(test)]
pub mod tests;
