//! The envelopes, normalised: γ runs from 0 to 1 while the input t runs from 0 to 1 over the
//! recording.
//!
//! That removes one of the two exact scalings of the raw parameters ({c0, c3, α} with τ and w).
//!
//! | shape | coordinates | γ |
//! |---|---|---|
//! | identity | none | t, from where the span begins, seen from input 0 |
//! | tanh | ln a, b | ∝ tanh(a t + b) |
//! | two tanh | ln a, b, ln δ, ln κ | rising as before; falling with κ (a + δ)(1 - t) + δ t more in the argument |
//! | knots | η₁ … | piecewise-linear, the steps between equally spaced knots ∝ exp η, η₀ = 0 |
//!
//! With κ below 1 the falling envelope of two tanh is increasing and nowhere below the rising one,
//! by construction.

use model_core::envelope::{EnvelopeParameters, PiecewiseLinearParameters, TanhParameters};

use super::coordinates::Coordinate;
use super::row::Span;

/// The shape of an envelope.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Shape {
    /// No envelope.
    Identity,
    /// The paper's.
    Tanh,
    /// One for rising and one for falling inputs.
    TwoTanh,
    /// Piecewise-linear through so many knots, at least 3.
    Knots(usize),
}

impl Shape {
    /// The coordinates of this shape.
    pub fn coordinates(self) -> Vec<Coordinate> {
        let tanh =
            [Coordinate::logarithm((0.02, 15.0), (0.4, 4.0)), Coordinate::new((-4.0, 4.0), (-2.0, 1.0))];
        let gap = [
            Coordinate::logarithm((1e-4, 2.0), (0.01, 0.5)),
            Coordinate::logarithm((1e-4, 0.95), (0.01, 0.5)),
        ];
        match self {
            Self::Identity => Vec::new(),
            Self::Tanh => tanh.to_vec(),
            Self::TwoTanh => [tanh, gap].concat(),
            Self::Knots(count) => vec![Coordinate::new((-5.0, 5.0), (-1.0, 1.0)); count - 2],
        }
    }
}

/// A normalised envelope at a point of its coordinates.
#[derive(Clone, Debug)]
pub enum Envelope {
    /// γ = start + t.
    Identity {
        /// The lowest input, in spans of the input.
        start: f64,
    },
    /// One or two tanh.
    Tanh(Tanh),
    /// Piecewise-linear.
    Knots {
        /// The steps from knot to knot; their sum is 1.
        steps: Vec<f64>,
    },
}

/// γ ∝ tanh of a straight line in t; the falling one's lies above the rising one's.
#[derive(Clone, Debug)]
pub struct Tanh {
    a: f64,
    b: f64,
    /// δ and κ, if the falling one is another.
    gap: Option<(f64, f64)>,
    /// The rising tanh at both ends.
    ends: (f64, f64),
}

impl Envelope {
    /// The envelope at a point; as many coordinates as the shape has.
    pub fn new(shape: Shape, at: &[f64], (low, span): Span) -> Self {
        match (shape, at) {
            (Shape::Tanh, &[ln_a, b]) => Self::Tanh(Tanh::new(ln_a.exp(), b, None)),
            (Shape::TwoTanh, &[ln_a, b, ln_delta, ln_kappa]) => {
                Self::Tanh(Tanh::new(ln_a.exp(), b, Some((ln_delta.exp(), ln_kappa.exp()))))
            }
            (Shape::Knots(_), at) => {
                let steps = std::iter::once(1.0).chain(at.iter().map(|eta| eta.exp()));
                let sum: f64 = steps.clone().sum();
                Self::Knots { steps: steps.map(|step| step / sum).collect() }
            }
            _ => Self::Identity { start: low / span },
        }
    }

    /// γ at t; `by` gets its derivatives by the coordinates, as many as there are.
    pub fn sample(&self, t: f64, rising: bool, by: &mut [f64]) -> f64 {
        match self {
            Self::Identity { start } => start + t,
            Self::Tanh(tanh) => tanh.sample(t, rising, by),
            Self::Knots { steps } => {
                let (knot, share) = place(t, steps.len());
                let value = steps[..knot].iter().sum::<f64>() + share * steps[knot];
                for (i, derivative) in by.iter_mut().enumerate() {
                    let passed = match (i + 1).cmp(&knot) {
                        std::cmp::Ordering::Less => 1.0,
                        std::cmp::Ordering::Equal => share,
                        std::cmp::Ordering::Greater => 0.0,
                    };
                    *derivative = steps[i + 1] * (passed - value);
                }
                value
            }
        }
    }

    /// γ at both ends of the span.
    pub fn ends(&self) -> (f64, f64) {
        match self {
            Self::Identity { start } => (*start, start + 1.0),
            _ => (0.0, 1.0),
        }
    }

    /// The raw envelopes of rising and of falling inputs.
    pub fn raw(&self, (low, span): Span) -> (EnvelopeParameters<f64>, EnvelopeParameters<f64>) {
        match self {
            Self::Identity { .. } => (EnvelopeParameters::Identity, EnvelopeParameters::Identity),
            Self::Tanh(tanh) => {
                let (g0, g1) = tanh.ends;
                let raw = |rising| {
                    let (start, end) = (tanh.line(0.0, rising), tanh.line(1.0, rising));
                    EnvelopeParameters::Tanh(TanhParameters {
                        c0: 1.0 / (g1 - g0),
                        c1: (end - start) / span,
                        c2: start - (end - start) * low / span,
                        c3: -g0 / (g1 - g0),
                    })
                };
                (raw(true), raw(false))
            }
            Self::Knots { steps } => {
                let input = |i: usize| low + span * i as f64 / steps.len() as f64;
                let value = |i: usize| steps[..i].iter().sum::<f64>();
                let knots = EnvelopeParameters::PiecewiseLinear(PiecewiseLinearParameters {
                    inputs: (0..=steps.len()).map(input).collect(),
                    values: (0..=steps.len()).map(value).collect(),
                });
                (knots.clone(), knots)
            }
        }
    }
}

/// The piece of `count` equal ones that t lies in, and the share of it that is passed.
fn place(t: f64, count: usize) -> (usize, f64) {
    let position = t * count as f64;
    let piece = (position.max(0.0) as usize).min(count - 1);
    (piece, position - piece as f64)
}

impl Tanh {
    fn new(a: f64, b: f64, gap: Option<(f64, f64)>) -> Self {
        Self { a, b, gap, ends: (b.tanh(), (a + b).tanh()) }
    }

    /// The argument of the tanh.
    fn line(&self, t: f64, rising: bool) -> f64 {
        let rise = self.a * t + self.b;
        match self.gap {
            Some((delta, kappa)) if !rising => rise + kappa * (self.a + delta) * (1.0 - t) + delta * t,
            _ => rise,
        }
    }

    fn sample(&self, t: f64, rising: bool, by: &mut [f64]) -> f64 {
        // tanh, absolutely as exact as the library's and in a third of the time: most of a search
        // is spent here.
        let tanh = 1.0 - 2.0 / (1.0 + (2.0 * self.line(t, rising)).exp());
        let (g0, g1) = self.ends;
        let scale = 1.0 / (g1 - g0);
        let (value, slope) = ((tanh - g0) * scale, 1.0 - tanh * tanh);
        let (d0, d1) = (1.0 - g0 * g0, 1.0 - g1 * g1);
        // The argument's derivatives by a and δ, and by κ.
        let (mut line_by_a, mut line_by_delta, mut line_by_kappa) = (t, 0.0, 0.0);
        if let (Some((delta, kappa)), false) = (self.gap, rising) {
            line_by_a = t + kappa * (1.0 - t);
            line_by_delta = line_by_a;
            line_by_kappa = (self.a + delta) * (1.0 - t);
        }
        let all = [
            self.a * (slope * line_by_a - value * d1) * scale,
            (slope - d0 - value * (d1 - d0)) * scale,
            self.gap.map_or(0.0, |(delta, _)| delta * slope * line_by_delta * scale),
            self.gap.map_or(0.0, |(_, kappa)| kappa * slope * line_by_kappa * scale),
        ];
        for (derivative, one) in by.iter_mut().zip(all) {
            *derivative = one;
        }
        value
    }
}
