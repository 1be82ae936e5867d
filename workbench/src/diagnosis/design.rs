//! The rows of a fit's columns, and their normal equations.
//!
//! The baseline's columns are sparse, a dozen of them in a row; those of the effects and the sensitivities are dense.

use nalgebra::{DMatrix, DVector};

use super::basis::{Basis, COLUMNS, ENTRIES, Entries, Seen};
use super::effect::Effect;
use super::output;
use super::signals::Signals;

/// Ridge, as a share of a column's own square.
const RIDGE: f64 = 1e-7;

/// Rows of columns at one point of the parameters.
pub(super) struct Design {
    /// Those of the baseline.
    pub(super) rows: Vec<Entries>,
    /// Those of the effects.
    pub(super) dense: Vec<Vec<f64>>,
    /// The first of the dense columns of each effect.
    pub(super) firsts: Vec<usize>,
    /// Which dense columns must not have negative weights.
    pub(super) one_sign: Vec<bool>,
}

/// Normal equations.
#[derive(Clone)]
pub(super) struct Normal {
    pub(super) matrix: DMatrix<f64>,
    right: DVector<f64>,
}

impl Design {
    pub(super) fn new(signals: &Signals, basis: &Basis, effects: &[Effect], seen: &Seen) -> Self {
        let mut rows = Vec::with_capacity(signals.rows.len());
        basis.run(seen, &signals.rows, |_, entries| rows.push(entries));
        let (mut dense, mut firsts, mut one_sign) = (Vec::new(), Vec::new(), Vec::new());
        for effect in effects {
            let (columns, positive) = output::columns(effect, signals);
            firsts.push(dense.len());
            one_sign.extend(columns.iter().map(|_| positive));
            dense.extend(columns);
        }
        Self { rows, dense, firsts, one_sign }
    }

    /// How many.
    pub(super) fn columns(&self) -> usize {
        COLUMNS + self.dense.len()
    }

    /// These rows with further columns.
    pub(super) fn with_columns(&self, columns: &[Vec<f64>]) -> Self {
        Self {
            rows: self.rows.clone(),
            dense: self.dense.iter().chain(columns).cloned().collect(),
            firsts: Vec::new(),
            one_sign: Vec::new(),
        }
    }

    /// The sum of a row with these weights.
    pub(super) fn predict(&self, row: usize, weights: &[f64]) -> f64 {
        self.rows[row].sum(weights)
            + self.dense.iter().zip(&weights[COLUMNS..]).map(|(column, w)| column[row] * w).sum::<f64>()
    }

    /// The normal equations of the rows, each added to those that `part` names.
    pub(super) fn normal<const P: usize>(
        &self,
        target: impl Fn(usize) -> f64,
        part: impl Fn(usize) -> [bool; P],
    ) -> [Normal; P] {
        let count = self.columns();
        let dense = self.dense.len();
        let empty = Normal { matrix: DMatrix::zeros(count, count), right: DVector::zeros(count) };
        let mut parts: [Normal; P] = std::array::from_fn(|_| empty.clone());
        let mut places = vec![0; ENTRIES + dense];
        let mut values = vec![0.0; ENTRIES + dense];
        for (i, place) in places[ENTRIES..].iter_mut().enumerate() {
            *place = COLUMNS + i;
        }
        for (row, entries) in self.rows.iter().enumerate() {
            for i in 0..ENTRIES {
                places[i] = entries.columns[i] as usize;
                values[i] = entries.values[i];
            }
            for (value, column) in values[ENTRIES..].iter_mut().zip(&self.dense) {
                *value = column[row];
            }
            let wanted = target(row);
            for (normal, _) in parts.iter_mut().zip(part(row)).filter(|(_, named)| *named) {
                // The columns of a row are in rising order: the upper triangle, column by column.
                for (j, (&place, &value)) in places.iter().zip(&values).enumerate() {
                    normal.right[place] += value * wanted;
                    let mut column = normal.matrix.column_mut(place);
                    for (&other, &factor) in places[..=j].iter().zip(&values[..=j]) {
                        column[other] += value * factor;
                    }
                }
            }
        }
        parts
    }
}

impl Normal {
    pub(super) fn less(&self, other: &Self) -> Self {
        Self { matrix: &self.matrix - &other.matrix, right: &self.right - &other.right }
    }

    /// The solution in the columns that are `free`, the others 0; and the factor of those columns.
    pub(super) fn solve(&self, free: &[usize]) -> Option<(Vec<f64>, nalgebra::Cholesky<f64, nalgebra::Dyn>)> {
        let count = free.len();
        let mut matrix = DMatrix::zeros(count, count);
        for (j, &column) in free.iter().enumerate() {
            for (i, &row) in free.iter().enumerate().take(j + 1) {
                matrix[(j, i)] = self.matrix[(row.min(column), row.max(column))];
            }
            matrix[(j, j)] = matrix[(j, j)] * (1.0 + RIDGE) + 1e-12;
        }
        let right = DVector::from_iterator(count, free.iter().map(|&column| self.right[column]));
        let factor = nalgebra::Cholesky::new(matrix)?;
        let solution = factor.solve(&right);
        let mut all = vec![0.0; self.right.len()];
        for (&column, &value) in free.iter().zip(solution.iter()) {
            all[column] = value;
        }
        Some((all, factor))
    }
}
