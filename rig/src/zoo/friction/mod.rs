//! Frictions: what makes the hysteresis.

mod bouc_wen;
mod bristles;
mod lugre;
mod prandtl_ishlinskii;
mod resist;

pub use resist::Resist;

use crate::draw::Draw;

/// Which friction.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum Friction {
    /// Few bristles of a constant Coulomb limit.
    Coulomb,
    /// Many elements whose limits grow with pressure.
    MaxwellSlip,
    /// A smooth restoring force of exponent 2.
    BoucWen,
    /// One bristle that nears its limit exponentially.
    LuGre,
    /// Plays on the pressure.
    PrandtlIshlinskii,
}

impl Friction {
    /// All of them.
    pub const ALL: [Self; 5] =
        [Self::Coulomb, Self::MaxwellSlip, Self::BoucWen, Self::LuGre, Self::PrandtlIshlinskii];

    /// Its name in files.
    pub fn name(self) -> &'static str {
        match self {
            Self::Coulomb => "coulomb",
            Self::MaxwellSlip => "maxwell_slip",
            Self::BoucWen => "bouc_wen",
            Self::LuGre => "lugre",
            Self::PrandtlIshlinskii => "prandtl_ishlinskii",
        }
    }

    /// One of its kind, relaxed at `ratio`; its force is `share` of the full one, `full_n`.
    pub(crate) fn drawn(self, draw: &mut Draw, ratio: f64, share: f64, full_n: f64) -> Box<dyn Resist> {
        let friction_n = share * full_n;
        match self {
            Self::Coulomb => Box::new(bristles::Bristles::coulomb(draw, ratio, friction_n)),
            Self::MaxwellSlip => Box::new(bristles::Bristles::maxwell_slip(draw, ratio, friction_n)),
            Self::BoucWen => Box::new(bouc_wen::BoucWen::drawn(draw, ratio)),
            Self::LuGre => Box::new(lugre::LuGre::drawn(draw, ratio)),
            Self::PrandtlIshlinskii => Box::new(prandtl_ishlinskii::PrandtlIshlinskii::drawn(draw, share)),
        }
    }
}
