//! What a newton or a kelvin does to the contraction: an offset, and a gain on the contraction
//! itself; and what a first stroke lacks.

/// Shift of the contraction y for one unit of a quantity: `offset_mm + gain y`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Sensitivity {
    /// Shift at no contraction, mm per unit.
    pub offset_mm: f64,
    /// Relative growth of the contraction, 1 per unit.
    pub gain: f64,
}

impl Sensitivity {
    /// The line nearest to points of contraction (mm) and shift (mm per unit), by least squares.
    pub(crate) fn fitted(points: impl Iterator<Item = (f64, f64)>) -> Self {
        let points: Vec<_> = points.collect();
        let count = points.len() as f64;
        let mean = |of: &dyn Fn(&(f64, f64)) -> f64| points.iter().map(of).sum::<f64>() / count;
        let (y, shift) = (mean(&|point| point.0), mean(&|point| point.1));
        let gain = mean(&|point| (point.0 - y) * (point.1 - shift)) / mean(&|point| (point.0 - y).powi(2));
        Self { offset_mm: shift - gain * y, gain }
    }
}

/// What load, temperature and rest do to a body.
#[derive(Debug, Clone, PartialEq)]
pub struct Sensitivities {
    /// For one newton.
    pub per_n: Sensitivity,
    /// For one kelvin, where the body feels it.
    pub per_k: Option<Sensitivity>,
    /// The most that a stroke lacks before any travel, as a share of the whole stroke, where it
    /// does.
    pub lacking: Option<f64>,
}
