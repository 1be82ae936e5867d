//! Operator and extensions together, by Levenberg-Marquardt on the residual of the model that runs free.
//!
//! Derivatives by differences, of the thinned recording: a run is a few milliseconds, and there are about thirty variables. They
//! show the way, and whether it has led anywhere the whole recording says. Where the residual has moved
//! about as the last derivatives said, they are not taken anew but corrected along the step (Broyden), at most [`CORRECTIONS`]
//! times in a row. Rows before the last scored one are run through, and no others.

use std::sync::{Mutex, OnceLock, PoisonError};

use levenberg_marquardt::{LeastSquaresProblem, LevenbergMarquardt};
use model_core::{ExtendedModel, ExtensionParameters};
use nalgebra::{DMatrix, DVector, Dyn, Owned};
use rayon::prelude::*;

use super::rests;
use super::roughness::{ease, roughness, unevenness};
use super::task::Task;
use super::thinned::Thinned;
use super::variables::{Units, of, with};
use super::{Extension, rows};
use crate::Columns;
use identification::{DEAD_ZONES, PLAYS, Termination};
use recording::numbers::range;
use recording::simulation::Rows;

/// The difference that derivatives are taken by.
const STEP: f64 = 1e-4;
/// A step that gains less than this share of the sum of squares is the last.
const ENOUGH: f64 = 4e-3;
/// How exactly a run finds its roots, as a share of the ranges: far below [`STEP`], by which what differences are taken of moves. In
/// shorter steps of time than these more exactly, by their square: a mass takes second differences.
const TOLERANCE: f64 = 1e-8;
const STEP_S: f64 = 0.01;
/// What it costs to move a variable by a step, as a share of the root of the first sum of squares. Nothing beside what a row
/// teaches; but a slope that next to no row teaches would grow without end, which costs the taught rows nothing, and throws those
/// that come later by more than a stroke.
const STAY: f64 = 0.03;
/// What it costs that the logarithms of neighbouring slopes differ by 1, where effects make the operator's input, as a share of the
/// root of the sum of squares that the search has come to.
const EVEN: f64 = 0.15;
/// The same that neighbouring values of what resists motion differ by their mean: fast movements go through few contractions at few
/// speeds, and what a mass seems to be at one may be what the model lacks at another.
const ALIKE: f64 = 1.0;
/// Evaluations at most, per variable.
const PATIENCE: usize = 1;
/// Derivatives are corrected so many times in a row, where the residual has moved by no more than this share otherwise than they said.
const CORRECTIONS: usize = 2;
const OTHERWISE: f64 = 0.4;
/// A size that most operators keep within: their states are copied often.
const SMALL: usize = 16;

/// The problem at a point.
struct Problem<'a> {
    task: Task<'a>,
    units: Units,
    base: Extension,
    /// Where it began, and what it costs to leave that. Output unit.
    start: DVector<f64>,
    stay: f64,
    /// What it costs to be uneven, for the operator and for what resists motion. Output unit.
    even: f64,
    alike: f64,
    /// What the profile of a mass is even beside.
    ease: Vec<f64>,
    /// The square roots of what the rows count, if not all count alike.
    weights: Option<Vec<f64>>,
    /// What derivatives are taken on.
    thinned: Thinned,
    variables: DVector<f64>,
    residuals: OnceLock<Option<DVector<f64>>>,
    derivatives: Mutex<Option<Derivatives>>,
}

/// The derivatives that were last asked for, and where.
#[derive(Clone)]
struct Derivatives {
    variables: DVector<f64>,
    residuals: DVector<f64>,
    jacobian: DMatrix<f64>,
    /// How often they have been corrected since they were taken.
    corrections: usize,
}

impl Derivatives {
    /// Corrected for a step to here, if they have held.
    fn corrected(mut self, variables: &DVector<f64>, residuals: &DVector<f64>) -> Option<Self> {
        let step = variables - &self.variables;
        let moved = residuals - &self.residuals;
        let otherwise = &moved - &self.jacobian * &step;
        let length = step.norm_squared();
        let holds = otherwise.norm() < OTHERWISE * moved.norm() && self.corrections < CORRECTIONS;
        if !holds || length == 0.0 {
            return None;
        }
        self.jacobian.ger(1.0 / length, &otherwise, &step, 1.0);
        self.corrections += 1;
        (self.variables, self.residuals) = (variables.clone(), residuals.clone());
        Some(self)
    }
}

impl Task<'_> {
    /// The model refined from where it stands; None where it does not run through the rows.
    pub fn refined(&self, base: Extension) -> Option<(Extension, Termination)> {
        self.searched(base, true)
    }

    /// As [`Self::refined`], its extensions left as they are.
    pub fn operator_refined(&self, base: Extension) -> Option<Extension> {
        self.searched(base, false).map(|(model, _)| model)
    }

    fn searched(&self, base: Extension, with_extensions: bool) -> Option<(Extension, Termination)> {
        let Columns { time_s, output, input_is_command, .. } = self.columns;
        let (low, high) = range(output);
        let last = self.scored.last()?;
        let units = Units {
            stroke: high - low,
            duration_s: time_s[*last] - time_s[0],
            with_valve: *input_is_command,
            with_extensions,
        };
        let variables = DVector::from_vec(of(&base, &units));
        let first = self.residuals(&with(&base, &units, variables.as_slice()))?.norm();
        let is_alone = base.acting(self.columns) == ExtensionParameters::default();
        let start = variables.clone();
        let reached = self.reached * (self.scored.len() as f64).sqrt();
        let thinned = Thinned::of(self, &base.extensions);
        let rests = || rests::weights(self.columns, self.scored, &base.extensions);
        let weights = self.rests_once.then(rests).flatten();
        let ease = ease(&base);
        let problem = Problem {
            task: *self,
            units,
            base,
            start,
            stay: STAY * first,
            even: if is_alone { 0.0 } else { EVEN * reached },
            alike: ALIKE * reached,
            ease,
            weights,
            thinned,
            variables,
            residuals: OnceLock::new(),
            derivatives: Mutex::new(None),
        };
        let kernel = LevenbergMarquardt::new().with_ftol(ENOUGH).with_patience(PATIENCE).with_stepbound(1.0);
        let (problem, report) = kernel.minimize(problem);
        Some((problem.model(&problem.variables), (&report.termination).into()))
    }

    /// Root mean square error of a model; None where it does not run through the rows. Output unit.
    pub fn rms(&self, model: &Extension) -> Option<f64> {
        self.residuals(model).map(|residuals| residuals.norm() / (self.scored.len() as f64).sqrt())
    }

    /// Simulated less measured, a value a scored row.
    fn residuals(&self, model: &Extension) -> Option<DVector<f64>> {
        let columns = self.columns;
        let extensions = model.acting(columns);
        let end = self.scored.last()? + 1;
        let all = rows(columns);
        let cut = Rows {
            time_s: &all.time_s[..end],
            input: &all.input[..end],
            load: all.load.map(|load| &load[..end]),
            temperature: all.temperature.map(|temperature| &temperature[..end]),
        };
        let step_s = (cut.time_s.last()? - cut.time_s.first()?) / end as f64;
        let tolerance = TOLERANCE * (step_s / STEP_S).min(1.0).powi(2);
        let simulated = match model.parameters.convert::<f64, SMALL, SMALL>() {
            Ok(small) => {
                let model = ExtendedModel::try_new(&small, &extensions).ok()?;
                cut.answer(&model.with_tolerance(tolerance)).ok()?
            }
            Err(_) => {
                let model: ExtendedModel<f64, PLAYS, DEAD_ZONES> =
                    ExtendedModel::try_new(&model.parameters, &extensions).ok()?;
                cut.answer(&model.with_tolerance(tolerance)).ok()?
            }
        };
        let jump = |row: usize| model.jump.map_or(0.0, |jump| jump.at(columns.time_s[row]));
        let errors = self.scored.iter().map(|&row| simulated[row] + jump(row) - columns.output[row]);
        let errors = DVector::from_iterator(self.scored.len(), errors);
        errors.iter().all(|error| error.is_finite()).then_some(errors)
    }
}

impl Problem<'_> {
    fn model(&self, variables: &DVector<f64>) -> Extension {
        with(&self.base, &self.units, variables.as_slice())
    }

    /// The errors of a task's scored rows, and what the variables' ways and roughness cost.
    fn at(&self, task: &Task<'_>, variables: &DVector<f64>) -> Option<DVector<f64>> {
        let model = self.model(variables);
        let mut all: Vec<f64> = task.residuals(&model)?.data.into();
        for (error, weight) in all.iter_mut().zip(self.weights.iter().flatten()) {
            *error *= weight;
        }
        all.extend(variables.iter().zip(&self.start).map(|(variable, start)| self.stay * (variable - start)));
        all.extend(roughness(&model.parameters).iter().map(|rough| self.even * rough));
        all.extend(unevenness(&model.extensions, &self.ease).iter().map(|uneven| self.alike * uneven));
        Some(DVector::from_vec(all))
    }

    /// How many these are.
    fn count(&self) -> usize {
        let rough =
            roughness(&self.base.parameters).len() + unevenness(&self.base.extensions, &self.ease).len();
        self.task.scored.len() + self.start.len() + rough
    }
}

impl LeastSquaresProblem<f64, Dyn, Dyn> for Problem<'_> {
    type ResidualStorage = Owned<f64, Dyn>;
    type JacobianStorage = Owned<f64, Dyn, Dyn>;
    type ParameterStorage = Owned<f64, Dyn>;

    fn set_params(&mut self, variables: &DVector<f64>) {
        self.variables.copy_from(variables);
        self.residuals = OnceLock::new();
    }

    fn params(&self) -> DVector<f64> {
        self.variables.clone()
    }

    fn residuals(&self) -> Option<DVector<f64>> {
        let far = || DVector::from_element(self.count(), 1e3 * self.units.stroke);
        // What cannot be simulated is no better than anything that can.
        Some(self.residuals.get_or_init(|| self.at(&self.task, &self.variables)).clone().unwrap_or_else(far))
    }

    fn jacobian(&self) -> Option<DMatrix<f64>> {
        let here = self.residuals()?;
        let mut last = self.derivatives.lock().unwrap_or_else(PoisonError::into_inner);
        let corrected = last.take().and_then(|last| last.corrected(&self.variables, &here));
        let derivatives = corrected.unwrap_or_else(|| Derivatives {
            variables: self.variables.clone(),
            jacobian: self.differences(),
            residuals: here,
            corrections: 0,
        });
        Some(last.insert(derivatives).jacobian.clone())
    }
}

impl Problem<'_> {
    /// Derivatives by differences, of the thinned recording.
    fn differences(&self) -> DMatrix<f64> {
        let task = self.thinned.task(self.task);
        let moved = |variable: Option<usize>| {
            let mut moved = self.variables.clone();
            variable.into_iter().for_each(|variable| moved[variable] += STEP);
            self.at(&task, &moved)
        };
        let count = self.variables.len();
        let mut errors: Vec<_> =
            (0..=count).into_par_iter().map(|i| moved((i < count).then_some(i))).collect();
        let here = errors.pop().flatten();
        let column = |there: Option<DVector<f64>>| match (there, &here) {
            (Some(there), Some(here)) => (there - here) / STEP,
            _ => DVector::zeros(self.count()),
        };
        DMatrix::from_columns(&errors.into_iter().map(column).collect::<Vec<_>>())
    }
}
