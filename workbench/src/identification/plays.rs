//! The bank of plays, normalised: q + Σ pᵢ = 1.
//!
//! That removes the other exact scaling of the raw parameters ({q, ρ} with w).
//!
//! | coordinate | meaning | range |
//! |---|---|---|
//! | ln α | spacing of the thresholds | the largest 0.01 to 4 heights of the envelope |
//! | ln β | decay of the weights from play to play, β = τ α | 0.001 to 8 |
//! | logit s | share of the direct term, s = q | 0.001 to 0.999 |

use super::coordinates::Coordinate;

/// Number of coordinates.
pub const COUNT: usize = 3;

/// The coordinates of a number of plays, at least 1.
pub fn coordinates(plays: usize) -> [Coordinate; COUNT] {
    let plays = plays as f64;
    let logit = |s: f64| (s / (1.0 - s)).ln();
    [
        Coordinate::logarithm((0.01 / plays, 4.0 / plays), (0.15 / plays, 1.2 / plays)),
        Coordinate::logarithm((1e-3, 8.0), (0.5 / plays, 8.0 / plays)),
        Coordinate::new((logit(0.001), logit(0.999)), (-3.0, 1.5)),
    ]
}

/// The plays at a point of the coordinates.
#[derive(Clone, Debug)]
pub struct Plays {
    /// Share of the direct term.
    pub s: f64,
    /// Decay of the weights from play to play.
    beta: f64,
    /// Spacing of the thresholds.
    pub alpha: f64,
    /// Thresholds r.
    pub thresholds: Vec<f64>,
    /// Weights p.
    pub weights: Vec<f64>,
    /// Derivatives of the weights by ln β.
    pub weights_by_ln_beta: Vec<f64>,
}

impl Plays {
    /// The plays at a point, `count` of them, at least 1.
    pub fn new(at: &[f64], count: usize) -> Self {
        let (alpha, beta, s) = (at[0].exp(), at[1].exp(), 1.0 / (1.0 + (-at[2]).exp()));
        let raw: Vec<f64> = (1..=count).map(|i| (-beta * i as f64).exp()).collect();
        let sum: f64 = raw.iter().sum();
        let weights: Vec<f64> = raw.iter().map(|weight| (1.0 - s) * weight / sum).collect();
        let mean = raw.iter().enumerate().map(|(i, weight)| (i + 1) as f64 * weight / sum).sum::<f64>();
        let by_ln_beta =
            weights.iter().enumerate().map(|(i, weight)| beta * weight * (mean - (i + 1) as f64)).collect();
        Self {
            s,
            beta,
            alpha,
            thresholds: (1..=count).map(|i| alpha * i as f64).collect(),
            weights,
            weights_by_ln_beta: by_ln_beta,
        }
    }

    /// The outputs of the plays that rested at 0 and were then driven to `v`.
    pub fn rest(&self, v: f64) -> Vec<f64> {
        self.thresholds.iter().map(|r| v.signum() * (v.abs() - r).max(0.0)).collect()
    }

    /// u after a first loading from 0 to `v`, and its derivatives by the coordinates.
    pub fn loading(&self, v: f64) -> (f64, [f64; COUNT]) {
        let (mut u, mut by_s) = (self.s * v, v);
        let (mut by_ln_alpha, mut by_ln_beta) = (0.0, 0.0);
        for (i, z) in self.rest(v).into_iter().enumerate() {
            u += self.weights[i] * z;
            by_s -= self.weights[i] / (1.0 - self.s) * z;
            by_ln_beta += self.weights_by_ln_beta[i] * z;
            if z != 0.0 {
                by_ln_alpha -= v.signum() * self.weights[i] * self.thresholds[i];
            }
        }
        (u, [by_ln_alpha, by_ln_beta, by_s * self.s * (1.0 - self.s)])
    }

    /// ρ and τ of equation (10).
    pub fn rho_and_tau(&self) -> (f64, f64) {
        let first = self.weights.first().copied().unwrap_or_default();
        (first * self.beta.exp(), self.beta / self.alpha)
    }
}
