//! Where in the muscle an effect acts.

use crate::draw::Draw;

/// Where viscosity acts.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Viscous {
    /// A damper beside the muscle.
    Force,
    /// A damper and a spring between the muscle and what is measured.
    Length,
}

/// Where creep acts.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Retarded {
    /// Elements in series with the muscle.
    Length,
    /// The pressure reaches the braid late.
    Pressure,
    /// A spring beside the muscle that relaxes.
    Force,
}

/// Where temperature and warm-up act.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Stiffness {
    /// The passive spring.
    Spring,
    /// The pull of the braid.
    Pull,
}

/// One place for each effect that has several.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Sites {
    /// Of viscosity.
    pub viscous: Viscous,
    /// Of creep.
    pub creep: Retarded,
    /// Of temperature.
    pub temperature: Stiffness,
    /// Of warm-up.
    pub warm_up: Stiffness,
}

impl Sites {
    pub(crate) fn drawn(draw: &mut Draw) -> Self {
        let mut stiffness = || [Stiffness::Spring, Stiffness::Pull][draw.index(2)];
        let (temperature, warm_up) = (stiffness(), stiffness());
        Self {
            viscous: [Viscous::Force, Viscous::Length][draw.index(2)],
            creep: [Retarded::Length, Retarded::Pressure, Retarded::Force][draw.index(3)],
            temperature,
            warm_up,
        }
    }
}
