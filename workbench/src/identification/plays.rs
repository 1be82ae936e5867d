//! The bank of plays, normalised: q + Σ pᵢ = 1.
//!
//! That removes the other exact scaling of the raw parameters ({q, ρ} with w).
//!
//! | density | coordinate | meaning | range |
//! |---|---|---|---|
//! | either | ln α | spacing of the thresholds | the largest 0.01 to 4 heights of the envelope |
//! | exponential | β | decay of the weights from play to play, β = τ α; they grow where it is negative | -1 to 8 |
//! | exponential | logit s | share of the direct term, s = q | 0.001 to 0.999 |
//! | free | ηᵢ | ln (pᵢ/q) of each play | -14 to 10 |

use super::Weights;
use super::coordinates::Coordinate;

/// The coordinates of a number of plays, at least 1: the spacing, then those of the weights.
pub fn coordinates(weights: Weights, count: usize) -> Vec<Coordinate> {
    let plays = count as f64;
    let logit = |s: f64| (s / (1.0 - s)).ln();
    let spacing = Coordinate::logarithm((0.01 / plays, 4.0 / plays), (0.15 / plays, 1.2 / plays));
    let mut coordinates = vec![spacing];
    match weights {
        Weights::Exponential => coordinates.extend([
            Coordinate::new((-1.0, 8.0), (-1.0 / plays, 8.0 / plays)),
            Coordinate::new((logit(0.001), logit(0.999)), (-3.0, 1.5)),
        ]),
        Weights::Free => coordinates.extend(vec![Coordinate::new((-14.0, 10.0), (-3.0, 1.0)); count]),
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
                let (beta, s) = (at[1], 1.0 / (1.0 + (-at[2]).exp()));
                let raw: Vec<f64> = (1..=count).map(|i| (-beta * i as f64).exp()).collect();
                let sum: f64 = raw.iter().sum();
                let mean =
                    raw.iter().enumerate().map(|(i, weight)| (i + 1) as f64 * weight / sum).sum::<f64>();
                let weights: Vec<f64> = raw.iter().map(|weight| (1.0 - s) * weight / sum).collect();
                let by = |(i, p): (usize, &f64)| vec![p * (mean - (i + 1) as f64), -s * p];
                let of_q = vec![0.0, s * (1.0 - s)];
                let by = std::iter::once(of_q).chain(weights.iter().enumerate().map(by)).collect();
                Self { q: s, alpha, thresholds, weights, by }
            }
            Weights::Free => {
                let raw: Vec<f64> = at[1..].iter().map(|eta| eta.exp()).collect();
                let q = 1.0 / (1.0 + raw.iter().sum::<f64>());
                let weights: Vec<f64> = raw.iter().map(|weight| weight * q).collect();
                let by = |(place, p): (usize, f64)| {
                    weights
                        .iter()
                        .enumerate()
                        .map(|(j, other)| if place == j + 1 { p * (1.0 - other) } else { -p * other })
                        .collect()
                };
                let by = std::iter::once(q).chain(weights.iter().copied()).enumerate().map(by).collect();
                Self { q, alpha, thresholds, weights, by }
            }
        }
    }

    /// The coordinates of free weights at these.
    pub fn free_coordinates(&self) -> Vec<f64> {
        let eta = self.weights.iter().map(|p| (p / self.q).ln());
        std::iter::once(self.alpha.ln()).chain(eta).collect()
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
        let rest = self.rest(v);
        let outputs: Vec<f64> = std::iter::once(v).chain(rest.iter().copied()).collect();
        let u = self.q * v + self.weights.iter().zip(&rest).map(|(p, z)| p * z).sum::<f64>();
        let driven = rest.iter().zip(self.weights.iter().zip(&self.thresholds)).filter(|(z, _)| **z != 0.0);
        let by_ln_alpha = -v.signum() * driven.map(|(_, (p, r))| p * r).sum::<f64>();
        let by_weight = |k: usize| self.by.iter().zip(&outputs).map(|(by, z)| by[k] * z).sum();
        let by = std::iter::once(by_ln_alpha).chain((0..self.by[0].len()).map(by_weight)).collect();
        (u, by)
    }
}
