//! What an effect would gain to first order, without fitting it: a search looks at all and fits the promising ones.
//!
//! The effect's columns (those on the output; for strengths and shapes the difference that a small or the starting value
//! makes) are projected off the fitted ones, and the least squares of the residual on what is left is solved with the
//! signs that the effect demands.

use nalgebra::{Cholesky, DMatrix, DVector, Dyn};
use rand::Rng;

use super::basis::{Basis, COLUMNS, Weights};
use super::effect::{Effect, Form};
use super::fit::{Fit, Point};
use super::misfit::Misfit;
use super::output;
use super::signals::Signals;
use super::states;

/// A fit, prepared for looking at further effects.
pub struct Screen<'a> {
    signals: &'a Signals,
    basis: &'a Basis,
    point: Point,
    weights: Weights,
    sensitivities: Vec<Vec<f64>>,
    /// The baseline's part of the fitted values, a value a scored row.
    fitted: Vec<f64>,
    free: Vec<usize>,
    factor: Cholesky<f64, Dyn>,
    /// What these columns have in common with the misfit's.
    shared: Option<DMatrix<f64>>,
    /// What the fit leaves.
    own: Errors,
}

impl<'a> Screen<'a> {
    /// Prepares a fit.
    pub fn new(signals: &'a Signals, basis: &'a Basis, fit: &Fit) -> Option<Self> {
        let misfit = states::late(signals, basis, &fit.effects);
        let point = Point::new(signals, basis, fit.effects.clone(), misfit)?;
        let sensitivities = point.sensitivities(signals, basis);
        let all = point.design.with(&sensitivities);
        let misfit = point.misfit.as_deref();
        let normal = all.of_all(misfit, |row| point.residual[row]);
        let shared = normal.shared.clone();
        let normal = normal.beside(misfit.map(Misfit::usual));
        let normal = normal.with_prior(point.design.smoothness, &point.weights);
        let free = point.movable(&normal);
        let (_, factor) = normal.solve(&free)?;
        let weights = Weights::new(&point.weights);
        let fitted = basis.sums(&point.stages.seen, &signals.rows, &weights);
        let shared = shared.map(|shared| shared.columns.select_columns(&free));
        let own = Errors::new(point.misfit.as_deref(), point.residual.clone());
        Some(Self { signals, basis, point, weights, sensitivities, fitted, free, factor, shared, own })
    }

    /// By how much the effect would lower the sum of squares, as a share of it.
    pub fn promise(&self, effect: &Effect) -> f64 {
        self.promises(effect, std::slice::from_ref(&self.own))[0]
    }

    /// The same where the errors are these.
    pub fn promises(&self, effect: &Effect, errors: &[Errors]) -> Vec<f64> {
        let further = self.further(effect);
        errors.iter().map(|errors| further.reduction(errors) / errors.squares.max(1e-300)).collect()
    }

    /// What the fit and its misfit leave, a value a scored row.
    pub fn left(&self) -> Vec<f64> {
        let Some((misfit, shared)) = self.point.misfit.as_ref().zip(self.own.shared.as_ref()) else {
            return self.own.values.clone();
        };
        let weights = misfit.usual().solve(shared);
        self.own.values.iter().enumerate().map(|(row, own)| own - misfit.value(row, &weights)).collect()
    }

    /// These errors beside a misfit drawn from its prior, less what the fitted columns make of both.
    pub fn drawn(&self, mut values: Vec<f64>, random: &mut impl Rng) -> Errors {
        let misfit = self.point.misfit.as_deref();
        if let Some(misfit) = misfit {
            let weights = misfit.drawn(self.own.squares / values.len() as f64, values.len(), random);
            values.iter_mut().enumerate().for_each(|(row, value)| *value += misfit.value(row, &weights));
        }
        let all = self.point.design.with(&self.sensitivities);
        let mut right = vec![0.0; COLUMNS + all.dense.len()];
        for (row, value) in values.iter().enumerate() {
            all.of_row(row).for_each(|(at, entry)| right[at] += entry * value);
        }
        let mut right = DVector::from_fn(self.free.len(), |i, _| right[self.free[i]]);
        if let Some((misfit, shared)) = misfit.zip(self.shared.as_ref()) {
            right -= shared.tr_mul(&misfit.usual().solve(&misfit.shared(&values)));
        }
        let mut weights = vec![0.0; COLUMNS + all.dense.len()];
        self.free
            .iter()
            .zip(self.factor.solve(&right).iter())
            .for_each(|(&at, weight)| weights[at] = *weight);
        values.iter_mut().enumerate().for_each(|(row, value)| *value -= all.predict(row, &weights));
        Errors::new(misfit, values)
    }

    /// The effect's columns, and which of their weights must not be negative.
    fn columns(&self, effect: &Effect) -> (Vec<Vec<f64>>, Vec<bool>) {
        let (mut columns, one_sign) = output::columns(effect, self.signals);
        let mut bounded = vec![one_sign; columns.len()];
        if matches!(effect.form, Form::Delay | Form::SecondOrder | Form::Orifice | Form::Ceiling) {
            columns.push(self.difference(effect));
            bounded.push(true);
        }
        for (i, parameter) in effect.parameters.iter().enumerate().filter(|(_, p)| p.value == 0.0) {
            let mut moved = effect.clone();
            moved.parameters[i].value = parameter.step;
            columns.push(self.difference(&moved));
            bounded.push(parameter.low >= 0.0);
        }
        (columns, bounded)
    }

    /// What the effect, with its parameters, changes in the baseline's part.
    fn difference(&self, effect: &Effect) -> Vec<f64> {
        let mut effects = self.point.effects.clone();
        effects.retain(|other| effect.form != Form::Delay || other.form != Form::Delay);
        effects.push(effect.clone());
        let Some(seen) = self.point.stages.with(self.signals, &effects, effects.len() - 1) else {
            return vec![0.0; self.fitted.len()];
        };
        let mut column = self.basis.sums(&seen, &self.signals.rows, &self.weights);
        column.iter_mut().zip(&self.fitted).for_each(|(there, here)| *there -= here);
        column
    }

    /// An effect's columns beside the fitted ones.
    fn further(&self, effect: &Effect) -> Further {
        let (columns, bounded) = self.columns(effect);
        let count = columns.len();
        let all = self.point.design.with(&self.sensitivities);
        let mut place = vec![None; COLUMNS + all.dense.len()];
        for (i, &column) in self.free.iter().enumerate() {
            place[column] = Some(i);
        }
        let mut cross = DMatrix::<f64>::zeros(self.free.len(), count);
        let mut own = DMatrix::<f64>::zeros(count, count);
        for row in 0..self.own.values.len() {
            for (j, column) in columns.iter().enumerate() {
                let value = column[row];
                for (at, entry) in all.of_row(row) {
                    if let Some(i) = place[at] {
                        cross[(i, j)] += entry * value;
                    }
                }
                for k in 0..=j {
                    own[(j, k)] += value * columns[k][row];
                }
            }
        }
        own.fill_upper_triangle_with_lower_triangle();
        let shared = self.point.misfit.as_ref().zip(self.shared.as_ref()).filter(|_| count > 0);
        let taken_up = shared.map(|(misfit, shared)| {
            let with: Vec<DVector<f64>> = columns.iter().map(|column| misfit.shared(column)).collect();
            let with = DMatrix::from_columns(&with);
            let taken_up = misfit.usual().solve(&with);
            own -= with.tr_mul(&taken_up);
            cross -= shared.tr_mul(&taken_up);
            taken_up
        });
        let left = own.clone() - cross.transpose() * self.factor.solve(&cross);
        // What the fitted columns make already is no column of its own.
        let kept = (0..count).filter(|&j| left[(j, j)] > 1e-6 * own[(j, j)]).collect();
        Further { columns, bounded, taken_up, left, kept }
    }
}

/// Errors that fitted columns make nothing more of.
pub struct Errors {
    /// A value a scored row.
    values: Vec<f64>,
    /// What they have in common with the misfit's columns.
    shared: Option<DVector<f64>>,
    /// Their sum of squares beside the misfit. Unit: square of theirs.
    squares: f64,
}

impl Errors {
    fn new(misfit: Option<&Misfit>, values: Vec<f64>) -> Self {
        let squares = values.iter().map(|value| value * value).sum::<f64>();
        let shared = misfit.map(|misfit| misfit.shared(&values));
        let taken_up = misfit.zip(shared.as_ref());
        let taken_up = taken_up.map_or(0.0, |(misfit, shared)| shared.dot(&misfit.usual().solve(shared)));
        Self { values, shared, squares: squares - taken_up }
    }
}

/// An effect's columns beside fitted ones.
struct Further {
    columns: Vec<Vec<f64>>,
    /// Which of their weights must not be negative.
    bounded: Vec<bool>,
    /// What the misfit takes up of them, as weights of its own.
    taken_up: Option<DMatrix<f64>>,
    /// Their products, less what the misfit and the fitted columns take up.
    left: DMatrix<f64>,
    /// Those of which something is left.
    kept: Vec<usize>,
}

impl Further {
    /// By how much they lower the sum of squares of errors.
    fn reduction(&self, errors: &Errors) -> f64 {
        let dot = |column: &Vec<f64>| column.iter().zip(&errors.values).map(|(a, b)| a * b).sum::<f64>();
        let mut right = DVector::from_iterator(self.columns.len(), self.columns.iter().map(dot));
        if let Some((taken_up, shared)) = self.taken_up.as_ref().zip(errors.shared.as_ref()) {
            right -= taken_up.tr_mul(shared);
        }
        let mut kept = self.kept.clone();
        while !kept.is_empty() {
            let matrix = DMatrix::from_fn(kept.len(), kept.len(), |i, j| {
                let value = self.left[(kept[i], kept[j])];
                if i == j { value * (1.0 + 1e-6) } else { value }
            });
            let wanted = DVector::from_fn(kept.len(), |i, _| right[kept[i]]);
            let Some(factor) = Cholesky::new(matrix) else { return 0.0 };
            let solution = factor.solve(&wanted);
            let worst = (0..kept.len())
                .filter(|&i| self.bounded[kept[i]] && solution[i] < 0.0)
                .min_by(|&i, &j| (solution[i] * wanted[i]).total_cmp(&(solution[j] * wanted[j])));
            match worst {
                Some(i) => {
                    kept.remove(i);
                }
                None => return solution.dot(&wanted),
            }
        }
        0.0
    }
}
