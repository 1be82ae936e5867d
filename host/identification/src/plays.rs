//! The bank of plays, normalised: q + Σ pᵢ = 1.
//!
//! That removes the other exact scaling of the raw parameters ({q, ρ} with w).
//!
//! | density | coordinate | meaning | range |
//! |---|---|---|---|
//! | either | ln α | spacing of the thresholds | the largest 0.01 to 4 heights of the envelope |
//! | exponential | β | decay of the weights from play to play, β = τ α; they grow where it is negative | -1 to 8 |
//! | exponential | ln s | weight of the direct term, s = q; beyond 1 all p are negative, as for friction | 0.001 to 1000 |
//! | free | ln Sᵢ | partial sums q, q + p₁, … but the last, which is 1 | 0.0001 to 10000 |
//!
//! Every partial sum is positive, whatever the coordinates: the plays have an inverse by
//! construction.

use super::Weights;
use super::coordinates::Coordinate;

/// The coordinates of a number of plays, at least 1: the spacing, then those of the weights.
pub fn coordinates(weights: Weights, count: usize) -> Vec<Coordinate> {
    let plays = count as f64;
    let spacing = Coordinate::logarithm((0.01 / plays, 4.0 / plays), (0.15 / plays, 1.2 / plays));
    let mut coordinates = vec![spacing];
    match weights {
        Weights::Exponential => coordinates.extend([
            Coordinate::new((-1.0, 8.0), (-1.0 / plays, 8.0 / plays)),
            Coordinate::logarithm((1e-3, 1e3), (0.05, 3.0)),
        ]),
        Weights::Free => coordinates.extend(vec![Coordinate::logarithm((1e-4, 1e4), (0.1, 1.0)); count]),
    }
    coordinates
}

/// The plays at a point of the coordinates.
#[derive(Clone, Debug)]
pub struct Plays {
    /// Weight of the direct term.
    pub q: f64,
    /// Spacing of the thresholds.
    pub alpha: f64,
    /// Thresholds r.
    pub thresholds: Vec<f64>,
    /// Weights p.
    pub weights: Vec<f64>,
    /// Derivatives by the coordinates of the weights: of q, then of each p.
    pub by: Vec<Vec<f64>>,
}

impl Plays {
    /// The plays at a point, `count` of them, at least 1.
    pub fn new(weights: Weights, at: &[f64], count: usize) -> Self {
        let alpha = at[0].exp();
        let thresholds = (1..=count).map(|i| alpha * i as f64).collect();
        match weights {
            Weights::Exponential => {
                let (beta, s) = (at[1], at[2].exp());
                let raw: Vec<f64> = (1..=count).map(|i| (-beta * i as f64).exp()).collect();
                let sum: f64 = raw.iter().sum();
                let shares: Vec<f64> = raw.iter().map(|weight| weight / sum).collect();
                let mean = shares.iter().enumerate().map(|(i, share)| (i + 1) as f64 * share).sum::<f64>();
                let by =
                    |(i, share): (usize, &f64)| vec![(1.0 - s) * share * (mean - (i + 1) as f64), -s * share];
                let by = std::iter::once(vec![0.0, s]).chain(shares.iter().enumerate().map(by)).collect();
                let weights = shares.iter().map(|share| (1.0 - s) * share).collect();
                Self { q: s, alpha, thresholds, weights, by }
            }
            Weights::Free => {
                let sums: Vec<f64> = at[1..].iter().map(|ln| ln.exp()).chain([1.0]).collect();
                let weights = sums.windows(2).map(|pair| pair[1] - pair[0]).collect();
                // Of q by the first sum; of each weight by its own and by the one before.
                let by = |i: usize| {
                    let mut by = vec![0.0; count];
                    if i < count {
                        by[i] = sums[i];
                    }
                    if i > 0 {
                        by[i - 1] = -sums[i - 1];
                    }
                    by
                };
                Self { q: sums[0], alpha, thresholds, weights, by: (0..=count).map(by).collect() }
            }
        }
    }

    /// The coordinates of free weights at these.
    pub fn free_coordinates(&self) -> Vec<f64> {
        let mut sum = self.q;
        let sums = self.weights.iter().map(|p| {
            let before = sum;
            sum += p;
            before.ln()
        });
        std::iter::once(self.alpha.ln()).chain(sums).collect()
    }

    /// ρ of equation (10), and τ times the spacing, of weights that are exponential.
    pub fn rho_and_beta(&self) -> (f64, f64) {
        let beta = match self.weights.as_slice() {
            [first, second, ..] => (first / second).ln(),
            _ => 0.0,
        };
        (self.weights.first().copied().unwrap_or_default() * beta.exp(), beta)
    }

    /// The outputs of the plays that rested at 0 and were then driven to `v`.
    pub fn rest(&self, v: f64) -> Vec<f64> {
        self.thresholds.iter().map(|r| v.signum() * (v.abs() - r).max(0.0)).collect()
    }

    /// u after a first loading from 0 to `v`, and its derivatives by the coordinates.
    pub fn loading(&self, v: f64) -> (f64, Vec<f64>) {
        let driven = |(r, z): (&f64, f64)| (z, if z == 0.0 { 0.0 } else { -v.signum() * r });
        self.sum(v, self.thresholds.iter().zip(self.rest(v)).map(driven))
    }

    /// The same after a loading to `low`, a rise to `high`, and the return to `low`.
    pub fn returning(&self, low: f64, high: f64) -> (f64, Vec<f64>) {
        let driven = |(r, z): (&f64, f64)| {
            let (risen, by) = if high - r > z { (high - r, -r) } else { (z, -low.signum() * r) };
            if low + r < risen { (low + r, *r) } else { (risen, if risen == 0.0 { 0.0 } else { by }) }
        };
        self.sum(low, self.thresholds.iter().zip(self.rest(low)).map(driven))
    }

    /// u at `v` and its derivatives, from the outputs of the plays and their derivatives by ln α.
    fn sum(&self, v: f64, plays: impl Iterator<Item = (f64, f64)> + Clone) -> (f64, Vec<f64>) {
        let weighted = plays.clone().zip(&self.weights);
        let (u, by_ln_alpha) =
            weighted.fold((self.q * v, 0.0), |(u, by), ((z, z_by), p)| (u + p * z, by + p * z_by));
        let outputs: Vec<f64> = std::iter::once(v).chain(plays.map(|(z, _)| z)).collect();
        let by_weight = |k: usize| self.by.iter().zip(&outputs).map(|(by, z)| by[k] * z).sum();
        let by = std::iter::once(by_ln_alpha).chain((0..self.by[0].len()).map(by_weight)).collect();
        (u, by)
    }
}
