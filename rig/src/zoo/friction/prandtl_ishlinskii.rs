//! Prandtl-Ishlinskii: plays between the pressure and the force law, no force of friction.

use super::resist::Resist;
use crate::draw::Draw;
use crate::dynamics::Limits;

/// Thresholds (bar), weights that add up to 1 with the direct one, and memories (bar).
pub(super) struct PrandtlIshlinskii {
    direct: f64,
    plays: Vec<(f64, f64)>,
    memory: Vec<f64>,
}

impl PrandtlIshlinskii {
    /// `friction` is the share of the full force that other frictions have.
    pub(super) fn drawn(draw: &mut Draw, friction: f64) -> Self {
        let (count, widest_bar) = (5 + draw.index(6), draw.uniform(0.8, 2.0));
        let fall = draw.uniform(0.5, 2.0);
        let thresholds = (1..=count).map(|index| widest_bar * index as f64 / count as f64);
        let raw: Vec<_> = thresholds.map(|r| (r, (-fall * r).exp())).collect();
        // Half the loop's width is what the plays lose: as much pressure as the friction would take
        // force.
        let lost: f64 = raw.iter().map(|(r, w)| r * w).sum();
        let times = (6.0 * friction / lost).min(0.7 / raw.iter().map(|(_, w)| w).sum::<f64>());
        let plays: Vec<_> = raw.into_iter().map(|(r, w)| (r, w * times)).collect();
        let direct = 1.0 - plays.iter().map(|(_, w)| w).sum::<f64>();
        Self { direct, memory: vec![0.0; plays.len()], plays }
    }
}

impl Resist for PrandtlIshlinskii {
    fn level(&self, _pressure_bar: f64) -> f64 {
        0.0
    }

    fn resistance_n(&self, _ratio: f64, _limits_n: &Limits) -> f64 {
        0.0
    }

    fn settle(&mut self, _ratio: f64, _limits_n: &Limits) {}

    fn felt_bar(&mut self, pressure_bar: f64, widened: f64) -> f64 {
        let mut felt_bar = self.direct * pressure_bar;
        for (memory, (threshold, weight)) in self.memory.iter_mut().zip(&self.plays) {
            *memory = memory.clamp(pressure_bar - widened * threshold, pressure_bar + widened * threshold);
            felt_bar += weight * *memory;
        }
        felt_bar
    }
}
