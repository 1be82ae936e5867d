//! Least squares with some unknowns kept non-negative, from the normal equations.
//!
//! Lawson and Hanson's active-set method in the form of Bro and De Jong (1997), which needs the
//! Gram matrix ΦᵀΦ and Φᵀy only: here that is at most a few dozen columns, while the rows are a
//! recording's.

use nalgebra::{DMatrix, DVector};

/// The solution of min |Φ c - y|² with cⱼ ≥ 0 for every j with `bounded[j]`, and which unknowns are
/// free (not held at 0).
pub struct Solution {
    /// The unknowns.
    pub values: DVector<f64>,
    /// Whether each is free.
    pub free: Vec<bool>,
}

/// Solves it. `gram` is ΦᵀΦ, positive definite; `moment` is Φᵀy.
pub fn solve(gram: &DMatrix<f64>, moment: &DVector<f64>, bounded: &[bool]) -> Solution {
    let count = moment.len();
    let tolerance = 1e-12 * moment.amax();
    // Warm start: everything free, which is the answer wherever no bound binds.
    let mut free = vec![true; count];
    let mut values = DVector::zeros(count);
    // Each round frees an unknown or ends; Lawson and Hanson's bound on rounds that real problems
    // need.
    for _ in 0..3 * count + 3 {
        settle(gram, moment, bounded, &mut free, &mut values);
        let gradient = moment - gram * &values;
        let best = (0..count).filter(|&j| !free[j]).max_by(|&i, &j| gradient[i].total_cmp(&gradient[j]));
        match best {
            Some(j) if gradient[j] > tolerance => free[j] = true,
            _ => break,
        }
    }
    Solution { values, free }
}

/// Moves towards the unconstrained solution of the free unknowns, binding those that turn negative
/// on the way, until it is feasible.
fn settle(
    gram: &DMatrix<f64>,
    moment: &DVector<f64>,
    bounded: &[bool],
    free: &mut [bool],
    values: &mut DVector<f64>,
) {
    while let Some(target) = solve_free(gram, moment, free) {
        let negative = |j: &usize| free[*j] && bounded[*j] && target[*j] <= 0.0;
        let blocked: Vec<usize> = (0..target.len()).filter(negative).collect();
        if blocked.is_empty() {
            *values = target;
            return;
        }
        // The longest step that keeps every bound. An unknown that stands at 0 allows none.
        let allowed = |j: usize| {
            if values[j] > 0.0 { values[j] / (values[j] - target[j]) } else { 0.0 }
        };
        let step = blocked.iter().map(|&j| allowed(j)).fold(1.0, f64::min);
        let binding: Vec<usize> = blocked.into_iter().filter(|&j| allowed(j) <= step).collect();
        *values += step * (target - &*values);
        for j in binding {
            values[j] = 0.0;
            free[j] = false;
        }
    }
}

/// The least-squares solution of the free unknowns, the others 0; None without a free unknown.
fn solve_free(gram: &DMatrix<f64>, moment: &DVector<f64>, free: &[bool]) -> Option<DVector<f64>> {
    let places: Vec<usize> = (0..free.len()).filter(|&j| free[j]).collect();
    let reduced = gram.select_rows(&places).select_columns(&places);
    let solution = reduced.cholesky()?.solve(&moment.select_rows(&places));
    let mut values = DVector::zeros(free.len());
    for (place, value) in places.iter().zip(solution.iter()) {
        values[*place] = *value;
    }
    Some(values)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn problem(target: &[f64]) -> (DMatrix<f64>, DVector<f64>) {
        let rows = DMatrix::from_fn(12, target.len(), |i, j| {
            (0.3 + 1.7 * (i * (j + 1)) as f64 + 2.9 * j as f64).sin()
        });
        let gram = rows.transpose() * &rows;
        let moment = &gram * DVector::from_column_slice(target);
        (gram, moment)
    }

    #[test]
    fn without_a_binding_bound_it_is_plain_least_squares() {
        let target = [-2.0, 1.0, 0.5];
        let (gram, moment) = problem(&target);
        let solution = solve(&gram, &moment, &[false, true, true]);
        assert!((solution.values - DVector::from_column_slice(&target)).amax() < 1e-9);
        assert_eq!(solution.free, [true; 3]);
    }

    #[test]
    fn with_binding_bounds_it_fulfils_the_karush_kuhn_tucker_conditions() {
        let (gram, moment) = problem(&[-2.0, -1.0, 0.5, -0.1, 2.0]);
        let bounded = [false, true, true, true, true];
        let solution = solve(&gram, &moment, &bounded);
        let gradient = &moment - &gram * &solution.values;
        for j in 0..bounded.len() {
            if solution.free[j] {
                assert!(gradient[j].abs() < 1e-9, "{j}: gradient {}", gradient[j]);
            } else {
                assert!(solution.values[j] == 0.0 && gradient[j] <= 1e-9, "{j}: gradient {}", gradient[j]);
            }
            assert!(!bounded[j] || solution.values[j] >= 0.0);
        }
        assert!(solution.free.contains(&false), "a bound must bind here");
    }
}
