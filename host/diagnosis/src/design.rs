//! The rows of a fit's columns, and their normal equations.
//!
//! The baseline's columns are sparse, a dozen of them in a row; those of the effects and the sensitivities are dense. Rows
//! whose sparse columns are the same ones are summed up together, a few at a time and side by side, and are put in their places at the
//! end.

use std::ops::{Add, Sub};

use nalgebra::{Cholesky, DMatrix, DVector, Dyn};
use pulp::Arch;

use super::basis::{Basis, COLUMNS, ENTRIES, Entries, GROUPS, Seen, columns, neighbours};
use super::effect::Effect;
use super::misfit::{Misfit, Shared, add};
use super::output;
use super::signals::Signals;

/// Ridge, as a share of a column's own square. What columns differ by in less than a third of a percent is below what the baseline errs
/// by, and would be made of that: with a ridge of 1e-7 a tenth of a nanometre in a recording of real rows changed what was named.
const RIDGE: f64 = 1e-5;
/// Products that are summed up side by side.
const LANES: usize = 4;
/// Rows that are added at a time: a sum is fetched and stored once for all of them.
const TOGETHER: usize = 4;

/// The factors of a second difference.
const BEND: [f64; 3] = [1.0, -2.0, 1.0];

/// The values of some neighbouring columns, row by row.
type Block = [[f64; LANES]; TOGETHER];

/// Columns at one point of the parameters.
pub(super) struct Design {
    /// Those of the baseline, row by row.
    pub(super) rows: Vec<Entries>,
    /// Those of the effects.
    pub(super) dense: Vec<Vec<f64>>,
    /// The first of the dense columns of each effect.
    pub(super) firsts: Vec<usize>,
    /// Which dense columns must not have negative weights.
    pub(super) one_sign: Vec<bool>,
    /// See [`Basis::smoothness`].
    pub(super) smoothness: f64,
}

/// Those of a design and more.
pub(super) struct Columns<'a> {
    pub(super) rows: &'a [Entries],
    pub(super) dense: Vec<&'a [f64]>,
}

/// Normal equations; of the matrix the upper triangle.
#[derive(Clone)]
pub(super) struct Normal {
    pub(super) matrix: DMatrix<f64>,
    right: DVector<f64>,
    /// What the same rows have in common with the misfit, if there is one.
    pub(super) shared: Option<Shared>,
}

impl Design {
    pub(super) fn new(signals: &Signals, basis: &Basis, effects: &[Effect], seen: &Seen) -> Self {
        let rows = basis.entries(seen, &signals.rows);
        let (mut dense, mut firsts, mut one_sign) = (Vec::new(), Vec::new(), Vec::new());
        for effect in effects {
            let (columns, positive) = output::columns(effect, signals);
            firsts.push(dense.len());
            one_sign.extend(columns.iter().map(|_| positive));
            dense.extend(columns);
        }
        Self { rows, dense, firsts, one_sign, smoothness: basis.smoothness() }
    }

    /// How many.
    pub(super) fn columns(&self) -> usize {
        COLUMNS + self.dense.len()
    }

    /// These and further ones.
    pub(super) fn with<'a>(&'a self, further: &'a [Vec<f64>]) -> Columns<'a> {
        Columns { rows: &self.rows, dense: self.dense.iter().chain(further).map(Vec::as_slice).collect() }
    }
}

impl Columns<'_> {
    /// How many.
    pub(super) fn count(&self) -> usize {
        COLUMNS + self.dense.len()
    }

    /// The sum of a row with these weights.
    pub(super) fn predict(&self, row: usize, weights: &[f64]) -> f64 {
        self.rows[row].sum(weights)
            + self.dense.iter().zip(&weights[COLUMNS..]).map(|(column, w)| column[row] * w).sum::<f64>()
    }

    /// The places and the values of a row's columns that are not zero.
    pub(super) fn of_row(&self, row: usize) -> impl Iterator<Item = (usize, f64)> {
        let entries = &self.rows[row];
        let dense = self.dense.iter().enumerate().map(move |(i, column)| (COLUMNS + i, column[row]));
        columns(entries.group).into_iter().zip(entries.values).chain(dense)
    }

    /// The normal equations of the rows, each added to those that `part` names, with what they have in common with a misfit.
    pub(super) fn normal<const P: usize>(
        &self,
        misfit: Option<&Misfit>,
        target: impl Fn(usize) -> f64 + Copy,
        part: impl Fn(usize) -> [bool; P] + Copy,
    ) -> [Normal; P] {
        // The target is the last column.
        let count = ENTRIES + self.dense.len() + 1;
        let width = count.next_multiple_of(LANES);
        let sums: [Vec<f64>; P] = std::array::from_fn(|_| vec![0.0; GROUPS * count * width]);
        // In the widest registers that the processor has: the order of the sums and their one rounding a product, and so every bit, stay.
        // Without instructions for that rounding, which processors have had for ten years, it takes far longer.
        // It consumes what it adds to: a closure that could be called twice is not compiled into the place that has those registers.
        let sums = Arch::new().dispatch(
            #[inline(always)]
            || {
                let mut sums = sums;
                self.add_up(&mut sums, count, width, target, part);
                sums
            },
        );
        let mut normals = sums.map(|sums| self.in_place(&sums, count, width));
        if let Some(misfit) = misfit {
            let shared = self.shared(misfit, target, part);
            normals.iter_mut().zip(shared).for_each(|(normal, shared)| normal.shared = Some(shared));
        }
        normals
    }

    /// Those of all rows.
    pub(super) fn of_all(&self, misfit: Option<&Misfit>, target: impl Fn(usize) -> f64 + Copy) -> Normal {
        let [normal] = self.normal(misfit, target, |_| [true]);
        normal
    }

    /// What columns and target have in common with a misfit's columns, each row added to the parts that `part` names.
    fn shared<const P: usize>(
        &self,
        misfit: &Misfit,
        target: impl Fn(usize) -> f64,
        part: impl Fn(usize) -> [bool; P],
    ) -> [Shared; P] {
        let (points, all) = (misfit.points(), self.count());
        let sums: [Vec<f64>; P] = std::array::from_fn(|_| vec![0.0; points * (all + 1)]);
        // As the normal equations are added up.
        let sums = Arch::new().dispatch(
            #[inline(always)]
            || {
                let mut sums = sums;
                self.add_shared(&mut sums, misfit, target, part);
                sums
            },
        );
        sums.map(|mut sums| {
            let target = DVector::from_vec(sums.split_off(points * all));
            Shared { columns: DMatrix::from_vec(points, all, sums), target }
        })
    }

    #[inline(always)]
    fn add_shared<const P: usize>(
        &self,
        sums: &mut [Vec<f64>; P],
        misfit: &Misfit,
        target: impl Fn(usize) -> f64,
        part: impl Fn(usize) -> [bool; P],
    ) {
        let (points, all) = (misfit.points(), self.count());
        let mut here: Vec<(usize, f64)> = Vec::new();
        for row in 0..self.rows.len() {
            let features = misfit.row(row);
            here.clear();
            here.extend(self.of_row(row).chain([(all, target(row))]));
            for (sums, named) in sums.iter_mut().zip(part(row)) {
                if !named {
                    continue;
                }
                for &(column, value) in &here {
                    add(&mut sums[column * points..][..points], features, value);
                }
            }
        }
    }

    /// Adds the products of each row's columns up in their group.
    #[inline(always)]
    fn add_up<const P: usize>(
        &self,
        sums: &mut [Vec<f64>; P],
        count: usize,
        width: usize,
        target: impl Fn(usize) -> f64,
        part: impl Fn(usize) -> [bool; P],
    ) {
        let mut groups: [Vec<usize>; GROUPS] = std::array::from_fn(|_| Vec::new());
        for (row, entries) in self.rows.iter().enumerate() {
            groups[entries.group].push(row);
        }
        let mut values: Vec<Block> = vec![[[0.0; LANES]; TOGETHER]; width / LANES];
        for (group, rows) in groups.iter().enumerate() {
            for alike in rows.chunk_by(|&one, &other| part(one) == part(other)) {
                for rows in alike.chunks(TOGETHER) {
                    values.fill([[0.0; LANES]; TOGETHER]);
                    for (place, &row) in rows.iter().enumerate() {
                        let of_row = self.rows[row].values.into_iter();
                        let of_row = of_row.chain(self.dense.iter().map(|column| column[row]));
                        for (column, value) in of_row.chain([target(row)]).enumerate() {
                            values[column / LANES][place][column % LANES] = value;
                        }
                    }
                    let all = rows.first().map_or([false; P], |&row| part(row));
                    for (sums, _) in sums.iter_mut().zip(all).filter(|(_, named)| *named) {
                        add_products(&mut sums[group * count * width..][..count * width], width, &values);
                    }
                }
            }
        }
    }

    /// The sums of the groups, each in its place.
    fn in_place(&self, sums: &[f64], count: usize, width: usize) -> Normal {
        let all = self.count();
        let mut normal =
            Normal { matrix: DMatrix::zeros(all, all), right: DVector::zeros(all), shared: None };
        for (group, sums) in sums.chunks_exact(count * width).enumerate() {
            let places: Vec<usize> = columns(group).into_iter().chain(COLUMNS..all).collect();
            for (j, &place) in places.iter().enumerate() {
                // The columns of a row are in rising order.
                for (&other, sum) in places[..=j].iter().zip(&sums[j * width..]) {
                    normal.matrix[(other, place)] += sum;
                }
                normal.right[place] += sums[(count - 1) * width + j];
            }
        }
        normal
    }
}

/// Adds the products of some rows' values, of the lower triangle at least, to sums that are so wide.
#[inline(always)]
fn add_products(sums: &mut [f64], width: usize, values: &[Block]) {
    for (j, sums) in sums.chunks_exact_mut(width).enumerate() {
        let factors: [f64; TOGETHER] = std::array::from_fn(|row| values[j / LANES][row][j % LANES]);
        let side_by_side = sums.as_chunks_mut::<LANES>().0.iter_mut().take(j / LANES + 1);
        for (sums, others) in side_by_side.zip(values) {
            let mut sum = *sums;
            for row in 0..TOGETHER {
                for lane in 0..LANES {
                    sum[lane] = factors[row].mul_add(others[row][lane], sum[lane]);
                }
            }
            *sums = sum;
        }
    }
}

impl Add for &Normal {
    type Output = Normal;
    fn add(self, other: Self) -> Normal {
        self.with(other, 1.0)
    }
}

impl Sub for &Normal {
    type Output = Normal;
    fn sub(self, other: Self) -> Normal {
        self.with(other, -1.0)
    }
}

impl Normal {
    /// The sum with so many times other equations.
    fn with(&self, other: &Self, times: f64) -> Self {
        let shared = self.shared.as_ref().zip(other.shared.as_ref()).map(|(own, other)| Shared {
            columns: &own.columns + times * &other.columns,
            target: &own.target + times * &other.target,
        });
        let (matrix, right) = (&self.matrix + times * &other.matrix, &self.right + times * &other.right);
        Self { matrix, right, shared }
    }

    /// The equations beside the misfit, whose factor for their rows this is: what it takes up of columns and target has gone.
    pub(super) fn beside(mut self, factor: Option<&Cholesky<f64, Dyn>>) -> Self {
        let Some((Shared { columns, target }, factor)) = self.shared.as_ref().zip(factor) else {
            return self;
        };
        let lower = factor.l_dirty();
        let (mut columns, mut target) = (columns.clone(), target.clone());
        lower.solve_lower_triangular_mut(&mut columns);
        lower.solve_lower_triangular_mut(&mut target);
        self.right -= columns.tr_mul(&target);
        self.matrix -= columns.tr_mul(&columns);
        self
    }

    /// With the prior of smoothness on the weights of the baseline, where the target is what is left beside these weights.
    pub(super) fn with_prior(mut self, smoothness: f64, weights: &[f64]) -> Self {
        let squares = self.matrix.diagonal();
        for places in neighbours() {
            let strength = smoothness * places.iter().map(|&place| squares[place]).sum::<f64>() / 3.0;
            let bend: f64 = places.iter().zip(BEND).map(|(&place, factor)| weights[place] * factor).sum();
            for (i, &place) in places.iter().enumerate() {
                self.right[place] -= strength * BEND[i] * bend;
                for (&other, factor) in places[..=i].iter().zip(BEND) {
                    self.matrix[(other, place)] += strength * BEND[i] * factor;
                }
            }
        }
        self
    }

    /// The solution in the columns that are `free`, the others 0; and the factor of those columns.
    pub(super) fn solve(&self, free: &[usize]) -> Option<(Vec<f64>, Cholesky<f64, Dyn>)> {
        let count = free.len();
        let mut matrix = DMatrix::zeros(count, count);
        for (j, &column) in free.iter().enumerate() {
            for (i, &row) in free.iter().enumerate().take(j + 1) {
                matrix[(j, i)] = self.matrix[(row.min(column), row.max(column))];
            }
            matrix[(j, j)] = matrix[(j, j)] * (1.0 + RIDGE) + 1e-12;
        }
        let right = DVector::from_iterator(count, free.iter().map(|&column| self.right[column]));
        let factor = Cholesky::new(matrix)?;
        let solution = factor.solve(&right);
        let mut all = vec![0.0; self.right.len()];
        for (&column, &value) in free.iter().zip(solution.iter()) {
            all[column] = value;
        }
        Some((all, factor))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::synthetic::Noise;

    #[test]
    fn sums_of_some_rows_at_a_time_are_those_of_each_row_in_each_of_its_parts() {
        // Numbers that go around, in groups that change every few rows and parts that do so at other rows.
        let number = |row: usize, column: usize| ((7 * row + 5 * column + row * column) % 13) as f64 - 6.0;
        let entries = |row: usize| Entries {
            group: (row / 7) % GROUPS,
            values: std::array::from_fn(|column| number(row, column)),
        };
        let rows: Vec<Entries> = (0..400).map(entries).collect();
        let dense: Vec<Vec<f64>> =
            (0..3).map(|i| (0..400).map(|row| number(row, COLUMNS + i)).collect()).collect();
        let design = Design { rows, dense, firsts: Vec::new(), one_sign: Vec::new(), smoothness: 0.0 };
        let all = design.with(&[]);
        let target = |row: usize| number(row, 99);
        let part = |row: usize| [row % 50 < 23, row.is_multiple_of(3)];
        let normals = all.normal(None, target, part);
        for (which, normal) in normals.iter().enumerate() {
            let count = design.columns();
            let (mut matrix, mut right) = (DMatrix::zeros(count, count), DVector::zeros(count));
            for row in (0..400).filter(|&row| part(row)[which]) {
                for (j, value) in all.of_row(row) {
                    right[j] += value * target(row);
                    for (i, other) in all.of_row(row).filter(|(i, _)| *i <= j) {
                        matrix[(i, j)] += value * other;
                    }
                }
            }
            // Sums of whole numbers are exact.
            assert_eq!((&normal.matrix, &normal.right), (&matrix, &right));
        }
    }

    /// A design of the baseline alone under a prior, in rows that go through all groups.
    fn smoothed(smoothness: f64) -> Design {
        let mut noise = Noise::new(1);
        let rows = (0..4000).map(|row: usize| Entries {
            group: (row / 7) % GROUPS,
            values: std::array::from_fn(|_| noise.white(1.0)),
        });
        Design {
            rows: rows.collect(),
            dense: Vec::new(),
            firsts: Vec::new(),
            one_sign: Vec::new(),
            smoothness,
        }
    }

    #[test]
    fn the_prior_holds_bends_down_and_leaves_nothing_to_move_at_its_own_solution() {
        let targets: Vec<f64> = (0..4000).scan(Noise::new(2), |noise, _| Some(noise.white(1.0))).collect();
        let target = |row: usize| targets[row];
        let free: Vec<usize> = (0..COLUMNS).collect();
        let bends_under = |smoothness: f64| {
            let design = smoothed(smoothness);
            let all = design.with(&[]);
            let [normal] = all.normal(None, target, |_| [true]);
            let normal = normal.with_prior(smoothness, &[0.0; COLUMNS]);
            let (weights, _) = normal.solve(&free).expect("it can be solved");
            let left = |row: usize| target(row) - all.predict(row, &weights);
            let [there] = all.normal(None, left, |_| [true]);
            let (change, _) = there.with_prior(smoothness, &weights).solve(&free).expect("it can be solved");
            // The ridge, which has no weights to count from, moves them by a little.
            let size = |all: &[f64]| all.iter().map(|value| value.abs()).fold(0.0, f64::max);
            assert!(size(&change) < 1e-3 * size(&weights), "{} {}", size(&change), size(&weights));
            let bend = |places: [usize; 3]| {
                places.iter().zip(BEND).map(|(&at, factor)| weights[at] * factor).sum::<f64>()
            };
            neighbours().map(|places| bend(places).powi(2)).sum::<f64>()
        };
        let [free_bends, held] = [0.0, 10.0].map(bends_under);
        assert!(held < 0.05 * free_bends, "{held} {free_bends}");
    }

    #[test]
    fn a_small_misfit_makes_no_large_weights_of_what_hardly_differs() {
        // Two columns that differ by a ten-thousandth, and a misfit of a thousandth that is like the difference.
        let number = |row: usize, times: usize| ((times * row) % 13) as f64 - 6.0;
        let rows = (0..400).map(|_| Entries { group: 0, values: [0.0; ENTRIES] }).collect();
        let (column, difference) = (|row| number(row, 5), |row| number(row * row, 7));
        let dense = vec![
            (0..400).map(column).collect(),
            (0..400).map(|row| column(row) + 1e-4 * difference(row)).collect(),
        ];
        let design = Design { rows, dense, firsts: Vec::new(), one_sign: Vec::new(), smoothness: 0.0 };
        let [normal] = design.with(&[]).normal(None, |row| column(row) + 1e-3 * difference(row), |_| [true]);
        let (weights, _) = normal.solve(&[COLUMNS, COLUMNS + 1]).expect("it can be solved");
        let [one, other] = [weights[COLUMNS], weights[COLUMNS + 1]];
        assert!((one + other - 1.0).abs() < 1e-3 && (one - other).abs() < 0.1, "{one} {other}");
    }
}
