//! Creep: part of a quantity comes late, through Kelvin-Voigt elements in series.
//!
//! Each element is a spring beside a dashpot and follows the quantity with its own time constant;
//! together they take up a fixed share of it, the rest is there at once.

use crate::effects;

/// The elements and how far each has followed.
#[derive(Debug, Clone)]
pub(crate) struct Creep {
    share: f64,
    /// Time constant, s, and state in the unit of the quantity.
    elements: [(f64, f64); 3],
}

impl Creep {
    /// Elements that have followed `value` for ever.
    pub(crate) fn new(parameters: &effects::Creep, value: f64) -> Self {
        Self {
            share: parameters.fraction_per_decade,
            elements: parameters.time_constants_s.map(|time_constant_s| (time_constant_s, value)),
        }
    }

    /// Holds `value` for `dt_s`; what is there of it then.
    pub(crate) fn step(&mut self, value: f64, dt_s: f64) -> f64 {
        let mut there = value;
        for (time_constant_s, state) in &mut self.elements {
            *state += (value - *state) * -(-dt_s / *time_constant_s).exp_m1();
            there -= self.share * (value - *state);
        }
        there
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn after_a_step_the_same_share_comes_in_every_decade() {
        let parameters = effects::Creep { fraction_per_decade: 0.05, time_constants_s: [0.2, 2.0, 20.0] };
        let at = |time_s: f64| {
            let mut creep = Creep::new(&parameters, 0.0);
            creep.step(1.0, time_s)
        };
        assert!((at(1e-9) - 0.85).abs() < 1e-6);
        for decade in [(0.2, 2.0), (2.0, 20.0)] {
            let share = at(decade.1) - at(decade.0);
            assert!((share - 0.05).abs() < 0.01, "{share} between {decade:?} s");
        }
        assert!((at(1e4) - 1.0).abs() < 1e-9);
    }
}
