//! Elasto-plastic bristles in parallel, for dry friction that does not know the pressure and for
//! Maxwell slip whose limits grow with it.

use super::resist::Resist;
use crate::bristle::Bristle;
use crate::draw::Draw;
use crate::dynamics::Limits;

/// Bristles with their shares of the friction.
pub(super) struct Bristles {
    elements: Vec<(f64, Bristle)>,
    /// Growth of the friction over 6 bar, as a share of the one at 6 bar.
    growth: f64,
}

impl Bristles {
    /// Few equal ones of a constant limit, at rest at `ratio`; `friction_n` is the nominal
    /// friction.
    pub(super) fn coulomb(draw: &mut Draw, ratio: f64, friction_n: f64) -> Self {
        let count = 2 + draw.index(3);
        Self::with(count, 0.0, (0.002, 0.05), ratio, friction_n, |_| 1.0)
    }

    /// Eight to twelve whose limits grow with pressure.
    pub(super) fn maxwell_slip(draw: &mut Draw, ratio: f64, friction_n: f64) -> Self {
        let (count, growth, tilt) = (8 + draw.index(5), draw.uniform(0.5, 0.8), draw.uniform(-0.5, 0.5));
        Self::with(count, growth, (0.001, 0.12), ratio, friction_n, |place| 1.0 + tilt * (2.0 * place - 1.0))
    }

    fn with(
        count: usize,
        growth: f64,
        (first, last): (f64, f64),
        ratio: f64,
        friction_n: f64,
        weight: impl Fn(f64) -> f64,
    ) -> Self {
        let place = |index: usize| index as f64 / (count - 1) as f64;
        let sum: f64 = (0..count).map(|index| weight(place(index))).sum();
        let element = |index: usize| {
            let share = weight(place(index)) / sum;
            let breakaway = first * (last / first).powf(place(index));
            (share, Bristle::relaxed(share * friction_n / breakaway, ratio))
        };
        Self { elements: (0..count).map(element).collect(), growth }
    }
}

impl Resist for Bristles {
    fn level(&self, pressure_bar: f64) -> f64 {
        1.0 - self.growth * (1.0 - pressure_bar / 6.0)
    }

    fn resistance_n(&self, ratio: f64, limits_n: &Limits) -> f64 {
        let of = |(share, bristle): &(f64, Bristle)| bristle.resistance_n(ratio, &limits_n.scaled(*share)).0;
        self.elements.iter().map(of).sum()
    }

    fn settle(&mut self, ratio: f64, limits_n: &Limits) {
        for (share, bristle) in &mut self.elements {
            bristle.settle(ratio, &limits_n.scaled(*share));
        }
    }
}
