//! The coordinates that the optimiser moves in, and their way to the model's raw parameters.
//!
//! The raw parameters of Table 1 and 2 have two exact scalings ({q, ρ} with w, and {c0, c3, α} with τ and
//! w), so that their Jacobian has a rank two below their number. Fixing γ to run from 0 to 1 over the
//! recording's inputs and q + Σ pᵢ to 1 removes both, and five nonlinear coordinates are left:
//!
//! | coordinate | meaning | range |
//! |---|---|---|
//! | ln a | steepness of the envelope over the input span, a = c1 span | a in 0.02 to 15 |
//! | b | shift of the envelope, γ ∝ tanh(a t + b), t = 0 … 1 over the span | -4 to 4 |
//! | ln α | spacing of the plays | the largest threshold 0.01 to 4 |
//! | ln β | decay of the weights from play to play, β = τ α | 0.001 to 8 |
//! | logit s | share of the direct term, s = q | 0.001 to 0.999 |
//!
//! The weights of the dead zones and the offset enter linearly and are found by projection. Each coordinate
//! is a smooth function of an unbounded variable (half a tanh of it across the range), since the
//! Levenberg-Marquardt kernel knows no bounds.

use model_core::envelope::TanhParameters;

/// Number of nonlinear coordinates.
pub const COUNT: usize = 5;

/// Lower and upper end of each coordinate, in the order of the module's table.
#[derive(Clone, Copy, Debug)]
pub struct Bounds([(f64, f64); COUNT]);

impl Bounds {
    /// The bounds for a number of plays.
    pub fn new(plays: usize) -> Self {
        let plays = plays.max(1) as f64;
        let logit = |s: f64| (s / (1.0 - s)).ln();
        Self([
            (0.02_f64.ln(), 15_f64.ln()),
            (-4.0, 4.0),
            ((0.01 / plays).ln(), (4.0 / plays).ln()),
            (1e-3_f64.ln(), 8_f64.ln()),
            (logit(0.001), logit(0.999)),
        ])
    }

    /// The coordinates at the unbounded variables, and their derivatives.
    pub fn coordinates(&self, variables: &[f64; COUNT]) -> ([f64; COUNT], [f64; COUNT]) {
        let mut coordinates = [0.0; COUNT];
        let mut derivatives = [0.0; COUNT];
        for i in 0..COUNT {
            let (low, high) = self.0[i];
            let tanh = variables[i].tanh();
            coordinates[i] = (low + high) / 2.0 + (high - low) / 2.0 * tanh;
            derivatives[i] = (high - low) / 2.0 * (1.0 - tanh * tanh);
        }
        (coordinates, derivatives)
    }

    /// The unbounded variables of coordinates strictly inside the bounds.
    pub fn variables(&self, coordinates: &[f64; COUNT]) -> [f64; COUNT] {
        std::array::from_fn(|i| {
            let (low, high) = self.0[i];
            ((coordinates[i] - (low + high) / 2.0) / ((high - low) / 2.0)).clamp(-0.999, 0.999).atanh()
        })
    }

    /// The names of the coordinates that stand at a bound, within a thousandth of its range.
    pub fn at_bound(&self, coordinates: &[f64; COUNT]) -> [bool; COUNT] {
        std::array::from_fn(|i| {
            let (low, high) = self.0[i];
            let margin = 1e-3 * (high - low);
            coordinates[i] < low + margin || coordinates[i] > high - margin
        })
    }
}

/// The inner model (envelope and plays) at a point of the coordinates.
#[derive(Clone, Debug)]
pub struct Inner {
    /// Steepness over the span.
    pub a: f64,
    /// Shift.
    pub b: f64,
    /// Share of the direct term.
    pub s: f64,
    /// Decay of the weights from play to play.
    pub beta: f64,
    /// Spacing of the thresholds.
    pub alpha: f64,
    /// Thresholds r.
    pub thresholds: Vec<f64>,
    /// Weights p.
    pub weights: Vec<f64>,
    /// Derivatives of the weights by ln β.
    pub weights_by_ln_beta: Vec<f64>,
    /// tanh at both ends of the span.
    ends: (f64, f64),
}

impl Inner {
    /// The inner model with the given coordinates.
    pub fn new(coordinates: &[f64; COUNT], plays: usize) -> Self {
        let [ln_a, b, ln_alpha, ln_beta, logit_s] = *coordinates;
        let (a, alpha, beta, s) = (ln_a.exp(), ln_alpha.exp(), ln_beta.exp(), 1.0 / (1.0 + (-logit_s).exp()));
        // Without plays there is nothing to share with.
        let s = if plays == 0 { 1.0 } else { s };
        let raw: Vec<f64> = (1..=plays).map(|i| (-beta * i as f64).exp()).collect();
        let sum: f64 = raw.iter().sum();
        let weights: Vec<f64> = raw.iter().map(|weight| (1.0 - s) * weight / sum).collect();
        let mean = raw.iter().enumerate().map(|(i, weight)| (i + 1) as f64 * weight / sum).sum::<f64>();
        let weights_by_ln_beta =
            weights.iter().enumerate().map(|(i, weight)| beta * weight * (mean - (i + 1) as f64)).collect();
        Self {
            a,
            b,
            s,
            beta,
            alpha,
            thresholds: (1..=plays).map(|i| alpha * i as f64).collect(),
            weights,
            weights_by_ln_beta,
            ends: (b.tanh(), (a + b).tanh()),
        }
    }

    /// γ at the normalised input t (0 … 1 over the span).
    pub fn envelope(&self, t: f64) -> f64 {
        let (g0, g1) = self.ends;
        ((self.a * t + self.b).tanh() - g0) / (g1 - g0)
    }

    /// γ and its derivatives by ln a and b.
    pub fn envelope_derivatives(&self, t: f64) -> [f64; 3] {
        let (g0, g1) = self.ends;
        let g = (self.a * t + self.b).tanh();
        let height = g1 - g0;
        let value = (g - g0) / height;
        let (d, d0, d1) = (1.0 - g * g, 1.0 - g0 * g0, 1.0 - g1 * g1);
        let by_a = (t * d - value * d1) / height;
        let by_b = (d - d0 - value * (d1 - d0)) / height;
        [value, self.a * by_a, by_b]
    }

    /// The largest u of the recording's range: that of the first loading to the highest input.
    pub fn u_max(&self) -> f64 {
        self.s + self.reaches().zip(&self.weights).map(|(reach, p)| p * reach).sum::<f64>()
    }

    /// The derivatives of [`u_max`](Self::u_max) by the coordinates.
    pub fn u_max_derivatives(&self) -> [f64; COUNT] {
        let mut by = [0.0; COUNT];
        let mut by_s = 1.0;
        for (i, reach) in self.reaches().enumerate() {
            if reach > 0.0 {
                by[2] -= self.weights[i] * self.thresholds[i];
            }
            by[3] += self.weights_by_ln_beta[i] * reach;
            by_s -= self.weights[i] / (1.0 - self.s) * reach;
        }
        by[4] = by_s * self.s * (1.0 - self.s);
        by
    }

    /// How far each play is driven when v rises from 0 to 1.
    fn reaches(&self) -> impl Iterator<Item = f64> + '_ {
        self.thresholds.iter().map(|r| (1.0 - r).max(0.0))
    }

    /// The raw envelope for inputs from `input_min` over `span`.
    pub fn raw_envelope(&self, input_min: f64, span: f64) -> TanhParameters<f64> {
        let (g0, g1) = self.ends;
        TanhParameters {
            c0: 1.0 / (g1 - g0),
            c1: self.a / span,
            c2: self.b - self.a * input_min / span,
            c3: -g0 / (g1 - g0),
        }
    }

    /// ρ and τ of equation (10); without plays both 0.
    pub fn rho_and_tau(&self) -> (f64, f64) {
        match self.weights.first() {
            Some(first) => (first * self.beta.exp(), self.beta / self.alpha),
            None => (0.0, 0.0),
        }
    }
}
