//! What the baseline gets wrong in the same way at every visit to a state.
//!
//! # Design
//! No hysteresis of a fixed form is that of a muscle. What it lacks depends on the state, which is the input and its memory, and on
//! neither time nor rate. So it is a smooth function of the state, with the prior of a Gaussian process (the discrepancy of Kennedy and
//! O'Hagan, Bayesian calibration of computer models, 2001), through some states that are spread over those that are visited (inducing
//! points). It is fitted with the weights of the baseline and of the effects, all at once: their normal equations are those of
//! generalized least squares, whose covariance is that of the noise and of this function. What differs between visits to the same
//! state is then what speaks for a cause; what does not speaks for none.
//!
//! The states are those of the input as late as the effects make it, since in a jump it goes through all of them in less than a delay:
//! so there is a function for each of a few delays, made when it is first asked for.
//!
//! # Limits
//! A delay is as late as the nearest of those. Where no state is visited twice the function has next to nothing to say, and what the
//! form lacks may look like a cause.

use std::sync::{Arc, OnceLock};

use nalgebra::{Cholesky, DMatrix, DVector, Dyn};
use pulp::Arch;
use rand::{Rng, RngExt};
use rand_distr::StandardNormal;

use super::basis::{Basis, RADII, Seen};
use super::row::{FOLDS, Row};

/// States that the function goes through, at most: more cost more time, and the width below leaves no room for many more.
const POINTS: usize = 150;
/// Which stops are the memory (3, 10 and 29 % of the input's span), and what each weighs in the distance of two states, over its radius.
/// These and the two that follow are a prior that was chosen before any recording was looked at: a larger stop moves the output by more,
/// and the input most. How much of the function is believed is what each recording says, by [`STRENGTHS`].
const MEMORY: [(usize, f64); 3] = [(2, 0.5), (4, 0.8), (6, 1.0)];
/// What the input weighs, as a share of its span.
const INPUT: f64 = 2.0;
/// The distance over which the function goes on much the same: about a sixth of the input's span.
const WIDTH: f64 = 0.35;
/// No point is added that is nearer to another one than this share of the width: the function is the same there.
const NEAREST: f64 = 0.3;
/// Variances of the noise over those of the function, a row, that are tried: the one is taken that predicts held-out blocks best.
/// Neighbouring rows err alike, so that a row says far less than a row of noise would.
pub const STRENGTHS: [f64; 3] = [1e-2, 1e-3, 1e-4];
/// The place of the one that fits go by on their way.
const USUAL: usize = 1;
/// Added to the variance at the points, which is 1, so that their covariance can be factorised: a hundredth of the standard deviation.
const JITTER: f64 = 1e-4;
/// States are rounded to one part in so many, far more than rounding errors of the input and far less than a width: which of two equally
/// distant states becomes a point does not depend on the input's unit then.
const TOLD_APART: f64 = 1e6;
/// The shortest delay that has a function of its own: half of what kept rows are apart. Unit: s.
const SHORTEST_S: f64 = 0.01;
/// Each delay is so many times the one before: no delay is off by more than a tenth.
const LONGER: f64 = 1.2;
/// How many there are: up to 0.7 s.
const DELAYS: usize = 24;

/// A state: input and memory.
type State = [f64; MEMORY.len() + 1];

/// The function for a list of rows: its values at the points, whitened, are the weights of its columns.
#[derive(Debug)]
pub struct Misfit {
    /// Columns, row by row.
    features: Vec<f64>,
    points: usize,
    /// The factor of all rows under the usual strength.
    usual: Cholesky<f64, Dyn>,
    /// For each strength those of the rows that teach each fold.
    taught: [[Cholesky<f64, Dyn>; FOLDS]; STRENGTHS.len()],
}

/// The functions of some rows, each for a delay.
#[derive(Debug)]
pub struct Misfits {
    basis: Basis,
    rows: Vec<Row>,
    late: [OnceLock<Option<Arc<Misfit>>>; 1 + DELAYS],
}

impl Misfits {
    /// For these rows.
    pub fn new(basis: &Basis, rows: &[Row]) -> Self {
        Self { basis: basis.clone(), rows: rows.to_vec(), late: std::array::from_fn(|_| OnceLock::new()) }
    }

    /// The same for other rows.
    pub fn of_rows(&self, rows: &[Row]) -> Self {
        Self::new(&self.basis, rows)
    }

    /// That for a delay about as long (s); `delayed` gives the input with one. None where no factor can be found.
    pub fn late(&self, delay_s: f64, delayed: impl FnOnce(f64) -> Vec<f64>) -> Option<Arc<Misfit>> {
        let place = (delay_s / SHORTEST_S).max(f64::MIN_POSITIVE).ln() / LONGER.ln() + 1.0;
        let place = place.round().clamp(0.0, DELAYS as f64);
        let delay_s = if place > 0.0 { SHORTEST_S * LONGER.powf(place - 1.0) } else { 0.0 };
        let misfit =
            || Misfit::new(&self.basis, &Seen { input: delayed(delay_s), ..Seen::default() }, &self.rows);
        self.late[place as usize].get_or_init(misfit).clone()
    }

    /// That for what the operators see under effects, their envelope not bent.
    pub fn seen(&self, seen: Seen) -> Option<Arc<Misfit>> {
        Misfit::new(&self.basis, &Seen { bend: 0.0, ..seen }, &self.rows)
    }
}

/// What columns and a target have in common with those of the function, over some rows.
#[derive(Clone)]
pub struct Shared {
    /// A column for each of theirs.
    pub columns: DMatrix<f64>,
    /// Of the target.
    pub target: DVector<f64>,
}

impl Misfit {
    /// For the states of what the operators see at these rows; None where no factor can be found.
    pub fn new(basis: &Basis, seen: &Seen, rows: &[Row]) -> Option<Arc<Self>> {
        let wider = |row: &Row| seen.wider.get(row.at).copied().unwrap_or(1.0);
        let states: Vec<State> =
            basis.states(seen, rows).iter().zip(rows).map(|(walk, row)| state(walk, wider(row))).collect();
        let through = spread(&states);
        let points = through.len();
        let own = DMatrix::from_fn(points, points, |i, j| {
            covariance(&through[i], &through[j]) + if i == j { JITTER } else { 0.0 }
        });
        let whitening = Cholesky::new(own)?.l();
        let across = DMatrix::from_fn(points, states.len(), |i, row| covariance(&through[i], &states[row]));
        let features = whitening.solve_lower_triangular(&across)?.as_slice().to_vec();
        let gram = |counts: &dyn Fn(&Row) -> bool| {
            let chosen: Vec<f64> = rows
                .iter()
                .zip(features.chunks_exact(points))
                .filter(|(row, _)| counts(row))
                .flat_map(|(_, features)| features.iter().copied())
                .collect();
            let chosen = DMatrix::from_vec(points, chosen.len() / points, chosen);
            &chosen * chosen.transpose()
        };
        let whole = gram(&|_| true);
        let of_folds: [DMatrix<f64>; FOLDS] = std::array::from_fn(|fold| {
            &whole - gram(&|row: &Row| row.fold() == fold || row.near == Some(fold))
        });
        let factor = |gram: &DMatrix<f64>, strength: f64| {
            let mut sum = gram.clone();
            (0..points).for_each(|i| sum[(i, i)] += strength * rows.len() as f64);
            Cholesky::new(sum)
        };
        let mut taught = Vec::new();
        for strength in STRENGTHS {
            let folds: Option<Vec<_>> = of_folds.iter().map(|gram| factor(gram, strength)).collect();
            taught.push(folds?.try_into().ok()?);
        }
        let (usual, taught) = (factor(&whole, STRENGTHS[USUAL])?, taught.try_into().ok()?);
        Some(Arc::new(Self { features, points, usual, taught }))
    }

    /// The sum of squares of a residual, a value a row, less what the function takes up of it. Unit: square of the residual's.
    pub fn squares(&self, residual: &[f64]) -> f64 {
        let shared = self.shared(residual);
        residual.iter().map(|e| e * e).sum::<f64>() - shared.dot(&self.usual.solve(&shared))
    }

    /// The function's columns at a row.
    pub fn row(&self, row: usize) -> &[f64] {
        &self.features[row * self.points..][..self.points]
    }

    /// How many columns.
    pub fn points(&self) -> usize {
        self.points
    }

    /// The factor of all rows under the usual strength.
    pub fn usual(&self) -> &Cholesky<f64, Dyn> {
        &self.usual
    }

    /// That of the rows that teach a fold.
    pub fn taught(&self, strength: usize, fold: usize) -> &Cholesky<f64, Dyn> {
        &self.taught[strength][fold]
    }

    /// Weights of a function drawn from the prior, beside errors of this variance in so many rows.
    pub fn drawn(&self, variance: f64, rows: usize, random: &mut impl Rng) -> DVector<f64> {
        let size = (variance / (STRENGTHS[USUAL] * rows as f64)).sqrt();
        DVector::from_fn(self.points, |_, _| size * random.sample::<f64, _>(StandardNormal))
    }

    /// The function with these weights at a row.
    pub fn value(&self, row: usize, weights: &DVector<f64>) -> f64 {
        self.row(row).iter().zip(weights.iter()).map(|(feature, weight)| feature * weight).sum()
    }

    #[inline(always)]
    fn add_up(&self, sum: &mut [f64], column: &[f64]) {
        for (features, &value) in self.features.chunks_exact(self.points).zip(column) {
            add(sum, features, value);
        }
    }

    /// What a column, a value a row, has in common with those of the function.
    pub fn shared(&self, column: &[f64]) -> DVector<f64> {
        let sum = DVector::zeros(self.points);
        // In the widest registers that the processor has, as the normal equations are.
        Arch::new().dispatch(
            #[inline(always)]
            || {
                let mut sum = sum;
                self.add_up(sum.as_mut_slice(), column);
                sum
            },
        )
    }
}

/// Adds a multiple of some values to sums.
#[inline(always)]
pub fn add(sums: &mut [f64], values: &[f64], factor: f64) {
    for (sum, value) in sums.iter_mut().zip(values) {
        *sum = factor.mul_add(*value, *sum);
    }
}

/// The state at a place of a walk whose thresholds are so much wider: a stop that slides is the same at any speed.
fn state(walk: &[f64; RADII + 1], wider: f64) -> State {
    let mut state = [INPUT * walk[0]; MEMORY.len() + 1];
    for (place, (stop, weight)) in state[1..].iter_mut().zip(MEMORY) {
        *place = weight * walk[1 + stop] / wider;
    }
    state.map(|place| (place * TOLD_APART).round() / TOLD_APART)
}

fn square_distance(one: &State, other: &State) -> f64 {
    one.iter().zip(other).map(|(a, b)| (a - b).powi(2)).sum()
}

fn covariance(one: &State, other: &State) -> f64 {
    (-0.5 * square_distance(one, other) / (WIDTH * WIDTH)).exp()
}

/// Some of the states, each as far from those before as there is one.
fn spread(states: &[State]) -> Vec<State> {
    let mut chosen: Vec<State> = states.first().copied().into_iter().collect();
    let mut away: Vec<f64> = states.iter().map(|state| square_distance(state, &states[0])).collect();
    while chosen.len() < POINTS {
        let Some((place, &far)) = away.iter().enumerate().max_by(|one, other| one.1.total_cmp(other.1))
        else {
            break;
        };
        if far < (NEAREST * WIDTH).powi(2) {
            break;
        }
        let next = states[place];
        chosen.push(next);
        away.iter_mut().zip(states).for_each(|(away, state)| *away = away.min(square_distance(state, &next)));
    }
    chosen
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Eight triangles over the range, and their rows in blocks of half a triangle.
    fn recorded() -> (Vec<f64>, Vec<Row>) {
        let input = (0..3200).map(|row| 1.0 - (f64::from(row % 400) / 200.0 - 1.0).abs()).collect();
        let rows = (0..3200).map(|at| Row { at, block: at / 200, near: None }).collect();
        (input, rows)
    }

    #[test]
    fn what_is_repeated_at_every_visit_to_a_state_is_taken_up_and_what_goes_with_time_is_not() {
        let (input, rows) = recorded();
        let seen = Seen { input: input.clone(), ..Seen::default() };
        let misfit = Misfit::new(&Basis::new(0.0, 1.0, true), &seen, &rows).expect("factors");
        let left = |residual: Vec<f64>| {
            misfit.squares(&residual) / residual.iter().map(|error| error * error).sum::<f64>()
        };
        let repeated = left(input.iter().map(|u| (6.0 * u).sin()).collect());
        let drifting = left((0..3200).map(|row| f64::from(row) / 3200.0 - 0.5).collect());
        assert!(repeated < 0.05, "{repeated}");
        assert!(drifting > 0.8, "{drifting}");
    }

    #[test]
    fn delays_that_are_about_as_long_have_the_same_states() {
        let (input, rows) = recorded();
        let misfits = Misfits::new(&Basis::new(0.0, 1.0, true), &rows);
        let late = |delay_s| misfits.late(delay_s, |_| input.clone()).expect("factors");
        assert!(Arc::ptr_eq(&late(0.0), &late(0.004)));
        assert!(Arc::ptr_eq(&late(0.100), &late(0.104)));
        assert!(!Arc::ptr_eq(&late(0.05), &late(0.1)));
    }

    #[test]
    fn a_stop_that_slides_is_in_the_same_state_at_any_speed() {
        let sliding = |wider: f64| state(&[wider; RADII + 1], wider)[1..].to_vec();
        assert_eq!(sliding(1.0), sliding(1.7));
    }
}
