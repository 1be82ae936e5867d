//! A family of plants: a force law with a friction.
//!
//! The split is made once, here, and never after looking at a result: every law and every friction
//! occurs in development, and validation and sealed families are new combinations of them.
//! Development families may be looked at game by game; validation families are played to see
//! whether what was learnt is general; of sealed ones only totals are printed, and they are for the
//! final judge.

use super::friction::Friction;
use super::law::Law;

/// Which part a family has.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum Part {
    /// Looked at while the finder is built.
    Development,
    /// Played to see whether it is general.
    Validation,
    /// Only totals are ever looked at.
    Sealed,
}

impl Part {
    /// All of them.
    pub const ALL: [Self; 3] = [Self::Development, Self::Validation, Self::Sealed];

    /// Its name on the command line and in files.
    pub fn name(self) -> &'static str {
        match self {
            Self::Development => "development",
            Self::Validation => "validation",
            Self::Sealed => "sealed",
        }
    }
}

/// A law with a friction.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub struct Family {
    /// Its force law.
    pub law: Law,
    /// Its friction.
    pub friction: Friction,
}

impl Family {
    /// All of them.
    pub fn all() -> impl Iterator<Item = Self> {
        Law::ALL.into_iter().flat_map(|law| Friction::ALL.map(|friction| Self { law, friction }))
    }

    /// Which part it has.
    pub fn part(self) -> Part {
        use {Friction as F, Law as L};
        match (self.law, self.friction) {
            (L::Braid, F::MaxwellSlip)
            | (L::Exponential, F::LuGre)
            | (L::Polynomial, F::PrandtlIshlinskii)
            | (L::Stiffening, F::Coulomb)
            | (L::Polynomial, F::BoucWen) => Part::Sealed,
            (L::Braid, F::BoucWen)
            | (L::Exponential, F::Coulomb)
            | (L::Polynomial, F::MaxwellSlip)
            | (L::Stiffening, F::LuGre)
            | (L::Stiffening, F::PrandtlIshlinskii) => Part::Validation,
            _ => Part::Development,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_law_and_friction_occurs_in_development_and_each_part_has_its_share() {
        let of = |part| Family::all().filter(move |family| family.part() == part);
        assert_eq!(Part::ALL.map(|part| of(part).count()), [10, 5, 5]);
        assert!(Law::ALL.iter().all(|law| of(Part::Development).any(|family| family.law == *law)));
        assert!(Friction::ALL.iter().all(|f| of(Part::Development).any(|family| family.friction == *f)));
    }
}
