//! The effects that can be hidden, by name: the causes that a diagnosis knows, and outsiders that
//! it does not.

use std::fmt;
use std::str::FromStr;

use crate::draw::{Draw, Stream};

macro_rules! effects {
    ($($variant:ident $name:literal $doc:literal),+ $(,)?) => {
        /// Something that is wrong with a plant.
        #[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
        pub enum Effect {
            $(#[doc = $doc] $variant),+
        }

        impl Effect {
            /// Every effect, the causes first.
            pub const ALL: [Self; [$($name),+].len()] = [$(Self::$variant),+];

            /// Its name on the command line and in files.
            pub fn name(self) -> &'static str {
                match self {
                    $(Self::$variant => $name),+
                }
            }

            /// What it is, in a sentence.
            pub fn words(self) -> &'static str {
                match self {
                    $(Self::$variant => $doc),+
                }
            }
        }
    };
}

effects! {
    ValveLag "valve_lag" "The pressure follows the command far more slowly than a sound regulator's.",
    ValveDeadband "valve_deadband" "The valve ignores changes of the command below a band.",
    SupplySaturation "supply_saturation" "The supply ends below the valve's range.",
    TransportDelay "transport_delay" "Dead time of the line between the valve's sensor and the muscle.",
    ViscousLag "viscous_lag" "A force against the speed of contraction.",
    RateDependentWidth "rate_dependent_width" "Friction grows with the speed of sliding.",
    Inertia "inertia" "A mass hangs at the muscle.",
    Creep "creep" "Slow relaxation over decades of time.",
    Load "load" "The load changes, and is recorded.",
    Temperature "temperature" "The recorded temperature moves the muscle.",
    Drift "drift" "The zero of the length sensor moves steadily.",
    WarmUp "warm_up" "The muscle is stiffer until it has moved.",
    PeriodicDisturbance "periodic_disturbance" "A tone on the length.",
    ZeroStep "zero_step" "Outsider: the zero of the length sensor jumps once.",
    Outliers "outliers" "Outsider: single samples of the length are far off.",
    LoadUnrecorded "load_unrecorded" "Outsider: the load changes, and no column shows it.",
    FrictionWander "friction_wander" "Outsider: friction wanders with time.",
    SensorNonlinearity "sensor_nonlinearity" "Outsider: a bend of the length sensor's curve comes and goes.",
    StickSlip "stick_slip" "Outsider: the sensor's rod sticks and jumps.",
    Leak "leak" "Outsider: a leak beside the muscle opens and closes.",
    CrossTalk "cross_talk" "Outsider: bursts of a foreign signal on the length.",
}

/// How many of [`Effect::ALL`] are causes.
const CAUSES: usize = 13;

impl Effect {
    /// The causes a diagnosis can name.
    pub fn causes() -> &'static [Self] {
        Self::ALL.split_at(CAUSES).0
    }

    /// What a diagnosis cannot name.
    pub fn outsiders() -> &'static [Self] {
        Self::ALL.split_at(CAUSES).1
    }

    /// Whether it acts within fractions of a second behind the pressure sensor. Two of these are
    /// the hardest to tell apart.
    pub fn is_fast(self) -> bool {
        matches!(self, Self::TransportDelay | Self::ViscousLag | Self::Inertia | Self::RateDependentWidth)
    }

    /// Where its parameters are drawn from.
    pub(crate) fn parameters(self, seed: u64) -> Draw {
        Draw::new(seed, Stream::Parameters(self as u64))
    }

    /// Where its course over time is drawn from.
    pub(crate) fn course(self, seed: u64) -> Draw {
        Draw::new(seed, Stream::Course(self as u64))
    }
}

/// What to hide, as asked for.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Hide {
    /// These, or nothing.
    Set(Vec<Effect>),
    /// One cause or none, drawn by the seed.
    Random,
    /// Two causes, drawn by the seed.
    RandomPair,
}

impl Hide {
    /// The effects under `seed`.
    pub fn effects(&self, seed: u64) -> Vec<Effect> {
        let mut draw = Draw::new(seed, Stream::Choice);
        match self {
            Self::Set(effects) => effects.clone(),
            Self::Random => Effect::causes().get(draw.index(CAUSES + 1)).copied().into_iter().collect(),
            Self::RandomPair => {
                let mut causes = Effect::causes().to_vec();
                draw.shuffle(&mut causes);
                causes.truncate(2);
                causes.sort();
                causes
            }
        }
    }
}

impl fmt::Display for Hide {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Set(effects) if effects.is_empty() => f.write_str("none"),
            Self::Set(effects) => {
                let names: Vec<_> = effects.iter().map(|effect| effect.name()).collect();
                f.write_str(&names.join("+"))
            }
            Self::Random => f.write_str("random"),
            Self::RandomPair => f.write_str("random-pair"),
        }
    }
}

impl FromStr for Hide {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        match text {
            "none" => return Ok(Self::Set(Vec::new())),
            "random" => return Ok(Self::Random),
            "random-pair" => return Ok(Self::RandomPair),
            _ => {}
        }
        let mut effects = Vec::new();
        for name in text.split('+') {
            let effect = Effect::ALL.into_iter().find(|effect| effect.name() == name).ok_or_else(|| {
                let names: Vec<_> = Effect::ALL.iter().map(|effect| effect.name()).collect();
                format!("no effect {name:?}; there are none, random, random-pair, {}", names.join(", "))
            })?;
            if effects.contains(&effect) {
                return Err(format!("{name} is named twice"));
            }
            effects.push(effect);
        }
        effects.sort();
        Ok(Self::Set(effects))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_name_reads_back_and_pairs_are_joined_by_a_plus() {
        for effect in Effect::ALL {
            assert_eq!(effect.name().parse(), Ok(Hide::Set(vec![effect])));
        }
        assert_eq!("inertia+creep".parse(), Ok(Hide::Set(vec![Effect::Inertia, Effect::Creep])));
        assert_eq!("none".parse(), Ok(Hide::Set(vec![])));
        for wrong in ["", "lag", "creep+", "creep+creep", "none+creep"] {
            assert!(wrong.parse::<Hide>().is_err(), "{wrong}");
        }
    }

    #[test]
    fn random_choices_are_repeatable_and_reach_every_cause() {
        let singles: Vec<_> = (0..300).map(|seed| Hide::Random.effects(seed)).collect();
        assert!(singles.contains(&vec![]));
        assert!(Effect::causes().iter().all(|cause| singles.contains(&vec![*cause])));
        for seed in 0..300 {
            let pair = Hide::RandomPair.effects(seed);
            assert_eq!(pair, Hide::RandomPair.effects(seed));
            assert!(pair.len() == 2 && pair[0] < pair[1] && pair[1] <= Effect::PeriodicDisturbance);
        }
    }
}
