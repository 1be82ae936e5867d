//! What an effect would gain to first order, without fitting it: a search looks at all and fits the promising ones.
//!
//! The effect's columns (those on the output; for strengths and shapes the difference that a small or the starting value
//! makes) are projected off the fitted ones, and the least squares of the residual on what is left is solved with the
//! signs that the effect demands.

use nalgebra::{Cholesky, DMatrix, DVector, Dyn};

use super::basis::{Basis, COLUMNS, Weights};
use super::effect::{Effect, Form};
use super::fit::{Fit, Point};
use super::misfit::{Misfit, Shared};
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
    shared: Option<Shared>,
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
        Some(Self { signals, basis, point, weights, sensitivities, fitted, free, factor, shared })
    }

    /// By how much the effect would lower the sum of squares, as a share of it.
    pub fn promise(&self, effect: &Effect) -> f64 {
        let (columns, bounded) = self.columns(effect);
        self.reduction(&columns, &bounded).unwrap_or(0.0) / self.point.squares.max(1e-300)
    }

    /// The effect's columns, and which of their weights must not be negative.
    fn columns(&self, effect: &Effect) -> (Vec<Vec<f64>>, Vec<bool>) {
        let (mut columns, one_sign) = output::columns(effect, self.signals);
        let mut bounded = vec![one_sign; columns.len()];
        if matches!(effect.form, Form::Delay | Form::Lag) {
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

    fn reduction(&self, columns: &[Vec<f64>], bounded: &[bool]) -> Option<f64> {
        let count = columns.len();
        let all = self.point.design.with(&self.sensitivities);
        let mut place = vec![None; COLUMNS + all.dense.len()];
        for (i, &column) in self.free.iter().enumerate() {
            place[column] = Some(i);
        }
        let mut cross = DMatrix::<f64>::zeros(self.free.len(), count);
        let mut own = DMatrix::<f64>::zeros(count, count);
        let mut right = DVector::<f64>::zeros(count);
        for (row, residual) in self.point.residual.iter().enumerate() {
            for (j, column) in columns.iter().enumerate() {
                let value = column[row];
                right[j] += value * residual;
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
        if let Some((misfit, shared)) = self.point.misfit.as_ref().zip(self.shared.as_ref()) {
            let with: Vec<DVector<f64>> = columns.iter().map(|column| misfit.shared(column)).collect();
            let with = DMatrix::from_columns(&with);
            let taken_up = misfit.usual().solve(&with);
            own -= with.tr_mul(&taken_up);
            right -= taken_up.tr_mul(&shared.target);
            cross -= shared.columns.select_columns(&self.free).tr_mul(&taken_up);
        }
        let left = own.clone() - cross.transpose() * self.factor.solve(&cross);
        // What the fitted columns make already is no column of its own.
        let mut kept: Vec<usize> = (0..count).filter(|&j| left[(j, j)] > 1e-6 * own[(j, j)]).collect();
        loop {
            let size = kept.len();
            if size == 0 {
                return Some(0.0);
            }
            let matrix = DMatrix::from_fn(size, size, |i, j| {
                let value = left[(kept[i], kept[j])];
                if i == j { value * (1.0 + 1e-6) } else { value }
            });
            let wanted = DVector::from_fn(size, |i, _| right[kept[i]]);
            let solution = Cholesky::new(matrix)?.solve(&wanted);
            let worst = (0..size)
                .filter(|&i| bounded[kept[i]] && solution[i] < 0.0)
                .min_by(|&i, &j| (solution[i] * wanted[i]).total_cmp(&(solution[j] * wanted[j])));
            match worst {
                Some(i) => {
                    kept.remove(i);
                }
                None => return Some(solution.dot(&wanted)),
            }
        }
    }
}
