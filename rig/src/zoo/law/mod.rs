//! Static force laws: pull over pressure and contraction.

mod braid;
mod exponential;
mod polynomial;
mod pull;
mod stiffening;

pub use pull::{FULL_BAR, Pull};

use crate::draw::Draw;

/// Which law.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum Law {
    /// Geometry of a braid.
    Braid,
    /// Exponential formula.
    Exponential,
    /// Polynomials.
    Polynomial,
    /// Contractile force and a spring that stiffens.
    Stiffening,
}

impl Law {
    /// All of them.
    pub const ALL: [Self; 4] = [Self::Braid, Self::Exponential, Self::Polynomial, Self::Stiffening];

    /// Its name in files.
    pub fn name(self) -> &'static str {
        match self {
            Self::Braid => "braid",
            Self::Exponential => "exponential",
            Self::Polynomial => "polynomial",
            Self::Stiffening => "stiffening",
        }
    }

    /// One of its kind.
    pub(crate) fn drawn(self, draw: &mut Draw) -> Box<dyn Pull> {
        match self {
            Self::Braid => Box::new(braid::Braid::drawn(draw)),
            Self::Exponential => Box::new(exponential::Exponential::drawn(draw)),
            Self::Polynomial => Box::new(polynomial::Polynomial::drawn(draw)),
            Self::Stiffening => Box::new(stiffening::Stiffening::drawn(draw)),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::draw::Stream;

    #[test]
    fn pull_grows_with_pressure_and_falls_with_contraction_in_every_law() {
        for (law, seed) in Law::ALL.into_iter().flat_map(|law| (0..20).map(move |seed| (law, seed))) {
            let pull = law.drawn(&mut Draw::new(seed, Stream::Protocol));
            assert!((pull.pull(FULL_BAR, 0.0) - 1.0).abs() < 1e-9, "{law:?} {seed}");
            assert!(pull.pull(0.0, 0.0).abs() < 1e-9);
            for step in 0..30 {
                let ratio = -0.05 + 0.01 * f64::from(step);
                for bar in [0.0, 1.0, 3.0, 5.0] {
                    assert!(pull.pull(bar, ratio + 0.01) <= pull.pull(bar, ratio) + 1e-12, "{law:?} {ratio}");
                    let grows = ratio > 0.15 || pull.pull(bar + 1.0, ratio) > pull.pull(bar, ratio);
                    assert!(grows, "{law:?} at {ratio}, {bar} bar");
                }
            }
        }
    }
}
