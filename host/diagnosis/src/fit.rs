//! Fits the baseline and a set of effects together, and tries the fit on blocks of time that it has not seen.
//!
//! # Design
//! The weights of the baseline and of the columns on the output are linear; strengths and shapes of the effects are not.
//! Gauss-Newton on both at once: the effects' sensitivities, by differences, stand as columns beside the linear ones,
//! which for these is exact. At the end the same columns make the cross-validation cheap: each fold's fit is a solution of
//! the normal equations less the fold's part.

use std::ops::Range;
use std::sync::Arc;

use nalgebra::{Cholesky, DVector, Dyn};

use super::basis::{Basis, COLUMNS, Seen, Weights};
use super::design::{Columns, Design, Normal};
use super::effect::Effect;
use super::equivalent::Stages;
use super::misfit::{Misfit, STRENGTHS};
use super::output;
use super::signals::{FOLDS, Signals};
use super::states;

/// Gauss-Newton steps at most.
const STEPS: usize = 20;
/// A step that gains less than this share of the sum of squares is the last. Where it was 2e-3, envelope and width of the baseline were
/// still on their way, and a larger set gained what its own had left.
const ENOUGH: f64 = 5e-4;

/// A fitted set of effects.
#[derive(Clone, Debug)]
pub struct Fit {
    /// The effects, their parameters found.
    pub effects: Vec<Effect>,
    /// What the operators see.
    pub seen: Seen,
    /// Weights of the baseline, then of the effects' columns on the output.
    pub weights: Vec<f64>,
    /// Measured less fitted, a value a scored row.
    pub residual: Vec<f64>,
    /// The same, each row fitted without its own fold.
    pub unseen: Vec<f64>,
}

impl Fit {
    /// The places of the weights of each effect's columns on the output.
    pub fn output_places(&self, signals: &Signals) -> Vec<Range<usize>> {
        let place = |last: &mut usize, effect: &Effect| {
            let first = *last;
            *last += output::count(effect, signals);
            Some(first..*last)
        };
        self.effects.iter().scan(COLUMNS, place).collect()
    }

    /// The weights of an effect's columns on the output.
    pub fn output_weights(&self, signals: &Signals, effect: usize) -> &[f64] {
        &self.weights[self.output_places(signals)[effect].clone()]
    }

    /// Root mean square of the residual. Output unit.
    pub fn rms(&self) -> f64 {
        (self.residual.iter().map(|e| e * e).sum::<f64>() / self.residual.len().max(1) as f64).sqrt()
    }
}

/// Where a search stands.
pub(super) struct Point {
    pub(super) effects: Vec<Effect>,
    pub(super) stages: Stages,
    pub(super) design: Design,
    /// Linear weights, and those columns that may differ from 0.
    pub(super) weights: Vec<f64>,
    free: Vec<usize>,
    pub(super) residual: Vec<f64>,
    pub(super) squares: f64,
    /// What the baseline gets wrong in the same way at every visit to a state.
    pub(super) misfit: Option<Arc<Misfit>>,
}

impl Point {
    pub(super) fn new(
        signals: &Signals,
        basis: &Basis,
        effects: Vec<Effect>,
        misfit: Option<Arc<Misfit>>,
    ) -> Option<Self> {
        let stages = Stages::new(signals, &effects);
        let design = Design::new(signals, basis, &effects, &stages.seen);
        let target = |row: usize| signals.output[signals.rows[row].at];
        let columns = design.with(&[]);
        let normal = columns.of_all(misfit.as_deref(), target).beside(misfit.as_deref().map(Misfit::usual));
        let normal = normal.with_prior(design.smoothness, &[0.0; COLUMNS]);
        let mut free: Vec<usize> = (0..design.columns()).collect();
        let weights = loop {
            let (weights, _) = normal.solve(&free)?;
            let wrong = (0..design.dense.len())
                .filter(|&i| design.one_sign[i] && weights[COLUMNS + i] < 0.0)
                .min_by(|&i, &j| weights[COLUMNS + i].total_cmp(&weights[COLUMNS + j]));
            match wrong {
                Some(i) => free.retain(|&column| column != COLUMNS + i),
                None => break weights,
            }
        };
        let residual: Vec<f64> =
            (0..design.rows.len()).map(|row| target(row) - columns.predict(row, &weights)).collect();
        let squares = squares(misfit.as_deref(), &residual);
        Some(Self { effects, stages, design, weights, free, residual, squares, misfit })
    }

    /// The change of the fitted values with every nonlinear parameter, as columns.
    pub(super) fn sensitivities(&self, signals: &Signals, basis: &Basis) -> Vec<Vec<f64>> {
        let weights = Weights::new(&self.weights);
        // Summed up in the same way as what is compared with it: what changes nothing has a difference of exactly 0.
        let here = basis.sums(&self.stages.seen, &signals.rows, &weights);
        let mut columns = Vec::new();
        for (i, effect) in self.effects.iter().enumerate() {
            for j in 0..effect.parameters.len() {
                let mut moved = self.effects.clone();
                let parameter = &mut moved[i].parameters[j];
                let mut column = vec![0.0; here.len()];
                if parameter.low < parameter.high {
                    let step = if parameter.value + parameter.step > parameter.high {
                        -parameter.step
                    } else {
                        parameter.step
                    };
                    parameter.value += step;
                    if let Some(seen) = self.stages.with(signals, &moved, i) {
                        column = basis.sums(&seen, &signals.rows, &weights);
                        column.iter_mut().zip(&here).for_each(|(there, here)| *there -= here);
                    }
                    let own = output::columns(&moved[i], signals).0;
                    let before = self.design.firsts[i]..;
                    let before =
                        self.design.dense[before.clone()].iter().zip(&self.weights[COLUMNS..][before]);
                    for (own, (before, weight)) in own.iter().zip(before) {
                        for ((sum, there), here) in column.iter_mut().zip(own).zip(before) {
                            *sum += weight * (there - here);
                        }
                    }
                    column.iter_mut().for_each(|change| *change /= step);
                }
                columns.push(column);
            }
        }
        columns
    }
}

/// The sum of squares of a residual beside a misfit, if there is one. Unit: square of the output unit.
pub(super) fn squares(misfit: Option<&Misfit>, residual: &[f64]) -> f64 {
    match misfit {
        Some(misfit) => misfit.squares(residual),
        None => residual.iter().map(|e| e * e).sum(),
    }
}

impl Point {
    /// The columns that can move, of the linear ones and then of the sensitivities: not those of a parameter at a bound.
    pub(super) fn movable(&self, normal: &Normal) -> Vec<usize> {
        let first = self.design.columns();
        let parameters = self.effects.iter().flat_map(|effect| &effect.parameters).enumerate();
        let moving = parameters.filter(|(i, parameter)| {
            parameter.value > parameter.low
                && parameter.value < parameter.high
                && normal.matrix[(first + i, first + i)] > 0.0
        });
        self.free.iter().copied().chain(moving.map(|(i, _)| first + i)).collect()
    }
}

/// Fits effects from where their parameters stand; None where the normal equations cannot be solved.
pub fn fit(signals: &Signals, basis: &Basis, effects: &[Effect]) -> Option<Fit> {
    Some(Descent::new(signals, basis, effects.to_vec())?.finish())
}

/// A fit on its way.
pub struct Descent<'a> {
    signals: &'a Signals,
    basis: &'a Basis,
    point: Point,
    /// Those of the last step; of the point itself where none was made.
    sensitivities: Vec<Vec<f64>>,
    steps: usize,
}

impl<'a> Descent<'a> {
    /// From where the effects' parameters stand; None where the normal equations cannot be solved.
    pub fn new(signals: &'a Signals, basis: &'a Basis, effects: Vec<Effect>) -> Option<Self> {
        let misfit = states::late(signals, basis, &effects);
        let point = Point::new(signals, basis, effects, misfit)?;
        Some(Self { signals, basis, point, sensitivities: Vec::new(), steps: 0 })
    }

    /// The effects as they stand.
    pub fn effects(&self) -> &[Effect] {
        &self.point.effects
    }

    /// Sum of squares so far.
    pub fn squares(&self) -> f64 {
        self.point.squares
    }

    /// Goes on to so many steps since the start, or to where another one gains too little.
    pub fn advance(&mut self, steps: usize) {
        while self.steps < steps {
            self.sensitivities = self.point.sensitivities(self.signals, self.basis);
            let next = step(&self.point, &self.sensitivities)
                .and_then(|step| descend(self.signals, self.basis, &self.point, &step));
            let before = self.point.squares;
            let Some(next) = next else {
                self.steps = STEPS;
                return;
            };
            self.point = next;
            self.steps = if self.squares() > (1.0 - ENOUGH) * before { STEPS } else { self.steps + 1 };
        }
    }

    /// The fit at the end of the way, tried on rows that it has not seen.
    pub fn finish(mut self) -> Fit {
        self.advance(STEPS);
        // With the states as its delay and its thresholds have come to make them.
        let effects = &self.point.effects;
        let misfit = states::seen(self.signals, self.basis, effects);
        let is_same = match (&misfit, &self.point.misfit) {
            (Some(one), Some(other)) => Arc::ptr_eq(one, other),
            (one, other) => one.is_none() && other.is_none(),
        };
        if !is_same
            && let Some(point) = Point::new(self.signals, self.basis, self.point.effects.clone(), misfit)
        {
            (self.point, self.sensitivities, self.steps) = (point, Vec::new(), 0);
            self.advance(STEPS);
        }
        cross_validate(self.signals, self.point, &self.sensitivities)
    }
}

/// The Gauss-Newton step of the nonlinear parameters, within their bounds.
fn step(point: &Point, sensitivities: &[Vec<f64>]) -> Option<Vec<f64>> {
    let all = point.design.with(sensitivities);
    let misfit = point.misfit.as_deref();
    let normal = all.of_all(misfit, |row| point.residual[row]).beside(misfit.map(Misfit::usual));
    let normal = normal.with_prior(point.design.smoothness, &point.weights);
    let first = point.design.columns();
    let parameters: Vec<_> = point.effects.iter().flat_map(|effect| &effect.parameters).collect();
    let mut moving: Vec<usize> = (0..parameters.len())
        .filter(|&i| parameters[i].high > parameters[i].low && normal.matrix[(first + i, first + i)] > 0.0)
        .collect();
    loop {
        let free: Vec<usize> = point.free.iter().copied().chain(moving.iter().map(|i| first + i)).collect();
        let (solution, _) = normal.solve(&free)?;
        // What stands at a bound and wants beyond it stays.
        let blocked = moving.iter().position(|&i| {
            let (parameter, change) = (parameters[i], solution[first + i]);
            (parameter.value <= parameter.low && change < 0.0)
                || (parameter.value >= parameter.high && change > 0.0)
        });
        match blocked {
            Some(place) => {
                moving.remove(place);
            }
            None => return Some(solution[first..].to_vec()),
        }
    }
}

/// The first point on the way that is better, halving the step a few times.
fn descend(signals: &Signals, basis: &Basis, point: &Point, step: &[f64]) -> Option<Point> {
    let mut share = 1.0;
    for _ in 0..5 {
        let mut effects = point.effects.clone();
        for (parameter, change) in effects.iter_mut().flat_map(|effect| &mut effect.parameters).zip(step) {
            parameter.value = (parameter.value + share * change).clamp(parameter.low, parameter.high);
        }
        let next = Point::new(signals, basis, effects, point.misfit.clone());
        if let Some(next) = next.filter(|next| next.squares < point.squares) {
            return Some(next);
        }
        share *= 0.3;
    }
    None
}

/// What the rows that teach each fold say of a fit's columns.
struct Folds<'a> {
    point: &'a Point,
    all: Columns<'a>,
    taught: [Normal; FOLDS],
    /// The columns that may move.
    free: Vec<usize>,
}

impl<'a> Folds<'a> {
    fn new(signals: &Signals, point: &'a Point, sensitivities: &'a [Vec<f64>]) -> Self {
        let all = point.design.with(sensitivities);
        // Those of each fold, then those near its blocks.
        let part = |row: usize| -> [bool; 2 * FOLDS] {
            let row = &signals.rows[row];
            std::array::from_fn(|i| if i < FOLDS { row.fold() == i } else { row.near == Some(i - FOLDS) })
        };
        let parts = all.normal(point.misfit.as_deref(), |row| point.residual[row], part);
        let (folds, near) = parts.split_at(FOLDS);
        let total = folds[1..].iter().fold(folds[0].clone(), |sum, fold| &sum + fold);
        let free = point.movable(&total.clone().with_prior(point.design.smoothness, &point.weights));
        let taught = std::array::from_fn(|fold| &(&total - &folds[fold]) - &near[fold]);
        Self { point, all, taught, free }
    }

    /// The change of the weights that the rows teach which teach a fold, beside a misfit whose factor for them this is.
    fn solved(
        &self,
        fold: usize,
        misfit: Option<&Cholesky<f64, Dyn>>,
    ) -> Option<(Vec<f64>, Cholesky<f64, Dyn>)> {
        let taught = self.taught[fold].clone().beside(misfit);
        taught.with_prior(self.point.design.smoothness, &self.point.weights).solve(&self.free)
    }

    /// The residual of each fold from a fit without it, under a strength of the misfit, if there is one.
    fn unseen(&self, signals: &Signals, misfit: Option<(&Misfit, usize)>) -> Vec<f64> {
        let mut unseen = self.point.residual.clone();
        for (fold, taught) in self.taught.iter().enumerate() {
            let misfit = misfit.map(|(misfit, strength)| (misfit, misfit.taught(strength, fold)));
            let Some((change, _)) = self.solved(fold, misfit.map(|(_, factor)| factor)) else { continue };
            let repeated = misfit.zip(taught.shared.as_ref()).map(|((misfit, factor), shared)| {
                let left = &shared.target - &shared.columns * DVector::from_column_slice(&change);
                (misfit, factor.solve(&left))
            });
            for row in (0..unseen.len()).filter(|&row| signals.rows[row].fold() == fold) {
                let repeated = repeated.as_ref().map_or(0.0, |(misfit, weights)| misfit.value(row, weights));
                unseen[row] -= self.all.predict(row, &change) + repeated;
            }
        }
        unseen
    }
}

/// Residuals of each fold from a fit without it, under the strength of the misfit with which they are least.
fn cross_validate(signals: &Signals, point: Point, sensitivities: &[Vec<f64>]) -> Fit {
    let folds = Folds::new(signals, &point, sensitivities);
    let squares = |unseen: &Vec<f64>| unseen.iter().map(|e| e * e).sum::<f64>();
    let unseen = match point.misfit.as_deref() {
        None => folds.unseen(signals, None),
        Some(misfit) => (1..STRENGTHS.len())
            .map(|strength| folds.unseen(signals, Some((misfit, strength))))
            .fold(folds.unseen(signals, Some((misfit, 0))), |least, next| {
                if squares(&next) < squares(&least) { next } else { least }
            }),
    };
    let Point { effects, stages, weights, residual, .. } = point;
    Fit { effects, seen: stages.seen, weights, residual, unseen }
}

/// Leverage of each row on a fit of these effects without its fold, as a multiple of the mean; None where the normal equations cannot
/// be solved.
pub fn leverage(signals: &Signals, basis: &Basis, effects: &[Effect]) -> Option<Vec<f64>> {
    let point = Point::new(signals, basis, effects.to_vec(), None)?;
    let sensitivities = point.sensitivities(signals, basis);
    let folds = Folds::new(signals, &point, &sensitivities);
    let mut place = vec![None; folds.all.count()];
    for (i, &column) in folds.free.iter().enumerate() {
        place[column] = Some(i);
    }
    let mut leverage = vec![0.0; point.residual.len()];
    for fold in 0..FOLDS {
        let Some((_, factor)) = folds.solved(fold, None) else { continue };
        let inverse = factor.inverse();
        for row in (0..leverage.len()).filter(|&row| signals.rows[row].fold() == fold) {
            let here: Vec<(usize, f64)> =
                folds.all.of_row(row).filter_map(|(column, value)| Some((place[column]?, value))).collect();
            leverage[row] = here
                .iter()
                .map(|&(i, a)| a * here.iter().map(|&(j, b)| inverse[(i, j)] * b).sum::<f64>())
                .sum();
        }
    }
    let mean = folds.free.len() as f64 / leverage.len().max(1) as f64;
    leverage.iter_mut().for_each(|leverage| *leverage /= mean.max(1e-300));
    Some(leverage)
}
