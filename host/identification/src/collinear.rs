//! Which raw parameters a recording hardly separates.
//!
//! Where a change of one can be made good by changes of others, only what they do together is
//! known. Of two, a correlation near 1 or -1 tells; of more, a small eigenvalue of the correlation
//! matrix, whose eigenvector has large components at them. What normalisation makes a function of
//! others (c0 and c3 of c1 and c2, rho of q and tau, q of free weights of the plays, the ends of
//! the knots) says nothing about the recording, and is left out.

use nalgebra::DMatrix;

/// The largest size of a correlation of two parameters that a recording separates.
const SEPARATED: f64 = 0.99;
/// The least eigenvalue of directions that a recording separates. Some of 0.01 are natural to
/// models of this family, and hold small parts of nearly all parameters.
const LEAST_EIGENVALUE: f64 = 1e-3;
/// The least component of a named parameter in such a direction, as a part of the largest one.
const SHARE: f64 = 0.5;

/// The groups of `names`, from their correlation.
pub fn groups(names: &[&str], correlation: &DMatrix<f64>) -> Vec<Vec<String>> {
    let is_own = |&place: &usize| !is_derived(names, names[place]) && !correlation[(place, place)].is_nan();
    let own: Vec<usize> = (0..names.len()).filter(is_own).collect();
    if own.is_empty() {
        return Vec::new();
    }
    let correlation = correlation.select_rows(&own).select_columns(&own);
    let mut groups: Vec<Vec<usize>> = Vec::new();
    for i in 0..own.len() {
        for j in (0..i).filter(|&j| correlation[(i, j)].abs() > SEPARATED) {
            merge(&mut groups, vec![i, j]);
        }
    }
    let eigen = correlation.symmetric_eigen();
    for (&value, direction) in eigen.eigenvalues.iter().zip(eigen.eigenvectors.column_iter()) {
        if value < LEAST_EIGENVALUE {
            let has_share = |place: &usize| direction[*place].abs() >= SHARE * direction.amax();
            merge(&mut groups, (0..own.len()).filter(has_share).collect());
        }
    }
    groups.sort_unstable();
    let named = |group: Vec<usize>| group.into_iter().map(|place| names[own[place]].to_owned()).collect();
    groups.into_iter().map(named).collect()
}

/// Adds a group; those that share a member with it become one with it.
fn merge(groups: &mut Vec<Vec<usize>>, mut group: Vec<usize>) {
    groups.retain(|other| {
        let is_apart = other.iter().all(|member| !group.contains(member));
        if !is_apart {
            group.extend(other);
        }
        is_apart
    });
    group.sort_unstable();
    group.dedup();
    groups.push(group);
}

/// Whether normalisation makes a parameter a function of others.
fn is_derived(names: &[&str], name: &str) -> bool {
    // Of all weights of the plays, free ones leave q to be the rest.
    let is_rest = name == "q" && names.contains(&"p1");
    name.starts_with("c0") || name.starts_with("c3") || name == "rho" || is_rest
}

#[cfg(test)]
mod tests {
    use super::*;

    fn symmetric(correlations: &[[f64; 4]; 4]) -> DMatrix<f64> {
        DMatrix::from_fn(4, 4, |i, j| correlations[i.max(j)][i.min(j)])
    }

    #[test]
    fn a_pair_is_named_and_what_normalisation_ties_is_not() {
        let correlation =
            symmetric(&[[1.0; 4], [0.2, 1.0, 0.0, 0.0], [1.0, 0.2, 1.0, 0.0], [0.1, -0.995, 0.1, 1.0]]);
        assert_eq!(groups(&["c1", "q", "c0", "tau"], &correlation), [["q", "tau"]]);
    }

    #[test]
    fn three_that_share_a_direction_are_named_though_no_pair_does() {
        // The third is as good as the sum of the first two.
        let half = 0.5_f64.sqrt() * 0.9998;
        let correlation =
            symmetric(&[[1.0; 4], [0.0, 1.0, 0.0, 0.0], [half, half, 1.0, 0.0], [0.3, 0.0, 0.2, 1.0]]);
        assert_eq!(groups(&["w0", "w1", "w2", "q"], &correlation), [["w0", "w1", "w2"]]);
    }

    #[test]
    fn parameters_at_a_bound_are_passed_over() {
        let mut correlation = DMatrix::identity(3, 3);
        correlation.row_mut(1).fill(f64::NAN);
        correlation.column_mut(1).fill(f64::NAN);
        assert!(groups(&["q", "tau", "alpha"], &correlation).is_empty());
        assert!(groups(&["tau"], &DMatrix::from_element(1, 1, f64::NAN)).is_empty());
    }
}
