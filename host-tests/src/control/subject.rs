//! The plants of the benchmark.

use std::fmt;

use rig::effect::Effect;
use rig::effects::Effects;
use rig::plant::{Kind, Plant, Setup};
use rig::protocol::Protocol;
use rig::recording::{record, write_recording};
use rig::sensor::Columns;
use rig::zoo::exhibit::Exhibit;

/// Force of the rig's muscle at 6 bar and no contraction, by the data sheet. Unit: N.
const RIG_BLOCKED_N: f64 = 1500.0;
/// Rows a second of the rig's recordings. Unit: Hz.
const RATE_HZ: f64 = 200.0;

/// A plant that can be recorded and controlled.
#[derive(Clone, Debug)]
pub enum Subject {
    /// The rig's muscle with these effects, recorded by triangles of falling height, or, if `rich`,
    /// by ramps, holds and triangles of many speeds.
    Rig {
        /// What is hidden.
        effects: Vec<Effect>,
        /// How it is recorded.
        rich: bool,
        /// Of everything random.
        seed: u64,
    },
    /// One of the zoo.
    Zoo(Box<Exhibit>),
}

impl Subject {
    /// The plant, at rest.
    pub fn plant(&self, noise: bool) -> Plant {
        match self {
            Self::Rig { effects, seed, .. } => {
                let effects = Effects::drawn(effects, 1.0, *seed);
                Plant::new(&Setup { kind: Kind::Rig, effects, noise, ..Setup::sound(*seed) })
            }
            Self::Zoo(exhibit) => exhibit.plant(noise),
        }
    }

    /// A recording of it, as a file.
    ///
    /// # Panics
    /// Memory cannot be written.
    pub fn recording(&self) -> Vec<u8> {
        let mut csv = Vec::new();
        match self {
            Self::Rig { rich, seed, .. } => {
                let protocol = if *rich { Protocol::rich(*seed) } else { Protocol::decreasing_triangles() };
                let mut plant = self.plant(true);
                let rows = record(&protocol, &mut plant, RATE_HZ);
                write_recording(&mut csv, &[], rows, Columns::All).expect("memory");
            }
            Self::Zoo(exhibit) => exhibit.recording().write(&mut csv).expect("memory"),
        }
        csv
    }

    /// Force at 6 bar and no contraction. Unit: N.
    pub fn blocked_n(&self) -> f64 {
        match self {
            Self::Rig { .. } => RIG_BLOCKED_N,
            Self::Zoo(exhibit) => exhibit.blocked_n(),
        }
    }
}

impl fmt::Display for Subject {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Rig { effects, rich, .. } => {
                let names: Vec<&str> = effects.iter().map(|effect| effect.name()).collect();
                let how = if *rich { "rich" } else { "slow" };
                write!(f, "rig {how} {}", names.join("+"))
            }
            Self::Zoo(exhibit) => {
                let names: Vec<&str> = exhibit.hidden.iter().map(|effect| effect.name()).collect();
                let family = (exhibit.family.law.name(), exhibit.family.friction.name());
                write!(f, "zoo {} {} {} {}", exhibit.seed, family.0, family.1, names.join("+"))
            }
        }
    }
}
