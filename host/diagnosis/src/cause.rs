//! The causes that can be named.

use std::fmt;

/// What can be wrong in a simulation, each a nested extension of the model in its physical place.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub enum Cause {
    /// Pressure follows the command as a first-order lag.
    ValveLag,
    /// The valve ignores command changes smaller than a band.
    ValveDeadband,
    /// Pressure never rises above the supply.
    SupplySaturation,
    /// Dead time between input and contraction.
    TransportDelay,
    /// Viscous force: the contraction follows the static curve with a lag.
    ViscousLag,
    /// The loop widens with speed, without a lag at rest.
    RateDependentWidth,
    /// Mass: overshoot and ringing.
    Inertia,
    /// Slow relaxation over decades of time after each change.
    Creep,
    /// The recorded load moves the curve.
    Load,
    /// The recorded temperature moves the curve.
    Temperature,
    /// The zero moves steadily with time.
    Drift,
    /// The first cycles differ and settle with travel.
    WarmUp,
    /// A tone that has nothing to do with the input.
    PeriodicDisturbance,
    /// What is left is rate-independent: the operator model is too poor.
    HysteresisShape,
}

impl Cause {
    /// All of them.
    pub const ALL: [Self; 14] = [
        Self::ValveLag,
        Self::ValveDeadband,
        Self::SupplySaturation,
        Self::TransportDelay,
        Self::ViscousLag,
        Self::RateDependentWidth,
        Self::Inertia,
        Self::Creep,
        Self::Load,
        Self::Temperature,
        Self::Drift,
        Self::WarmUp,
        Self::PeriodicDisturbance,
        Self::HysteresisShape,
    ];

    /// The name in commands and files.
    pub fn name(self) -> &'static str {
        match self {
            Self::ValveLag => "valve_lag",
            Self::ValveDeadband => "valve_deadband",
            Self::SupplySaturation => "supply_saturation",
            Self::TransportDelay => "transport_delay",
            Self::ViscousLag => "viscous_lag",
            Self::RateDependentWidth => "rate_dependent_width",
            Self::Inertia => "inertia",
            Self::Creep => "creep",
            Self::Load => "load",
            Self::Temperature => "temperature",
            Self::Drift => "drift",
            Self::WarmUp => "warm_up",
            Self::PeriodicDisturbance => "periodic_disturbance",
            Self::HysteresisShape => "hysteresis_shape",
        }
    }

    /// What it is, for people: a sentence without its full stop.
    pub fn meaning(self) -> &'static str {
        match self {
            Self::ValveLag => "The pressure follows the command late, as a first-order lag",
            Self::ValveDeadband => "The valve ignores changes of the command that are smaller than a band",
            Self::SupplySaturation => "The pressure never rises above the supply",
            Self::TransportDelay => "The contraction answers the input after a dead time",
            Self::ViscousLag => {
                "A force against the speed makes the contraction follow its static curve late"
            }
            Self::RateDependentWidth => "The loop widens with speed, and there is no lag at rest",
            Self::Inertia => "A mass overshoots and rings",
            Self::Creep => "After each change the contraction goes on slowly, over decades of time",
            Self::Load => "The load, which was recorded, moves the curve",
            Self::Temperature => "The temperature, which was recorded, moves the curve",
            Self::Drift => "The zero moves steadily with time",
            Self::WarmUp => "The first cycles differ, and settle with the way that the muscle has gone",
            Self::PeriodicDisturbance => "There is a tone that has nothing to do with the input",
            Self::HysteresisShape => {
                "What is left does not depend on time or speed: the operator model is too poor"
            }
        }
    }

    /// What a cause has to be better by than one that explains much the same with less.
    pub fn complexity(self) -> f64 {
        match self {
            Self::RateDependentWidth => 0.04,
            Self::Creep | Self::WarmUp => 0.02,
            _ => 0.0,
        }
    }

    /// What it has to be better by than one that it contains: an inertia has a viscous lag in it.
    pub fn containment(self) -> f64 {
        if self == Self::Inertia { 0.05 } else { 0.0 }
    }

    /// Whether it acts within fractions of a second.
    pub fn is_fast(self) -> bool {
        self == Self::TransportDelay || self.resists_motion()
    }

    /// Whether a misfit of the hysteresis' shape looks like it: it changes the loop's width.
    pub fn is_near_shape(self) -> bool {
        self == Self::RateDependentWidth
    }

    /// Whether it resists motion by a law over the rate: three forms of much the same.
    pub fn resists_motion(self) -> bool {
        matches!(self, Self::ViscousLag | Self::Inertia | Self::RateDependentWidth)
    }

    /// The causes that it is most easily taken for.
    pub fn rivals(self) -> &'static [Self] {
        match self {
            Self::Inertia => &[Self::ViscousLag, Self::TransportDelay],
            Self::ViscousLag => &[Self::Inertia, Self::RateDependentWidth, Self::TransportDelay],
            Self::RateDependentWidth => &[Self::ViscousLag, Self::Creep],
            Self::TransportDelay => &[Self::ViscousLag, Self::Inertia, Self::ValveLag],
            Self::ValveLag => &[Self::TransportDelay, Self::ViscousLag],
            Self::Creep => &[Self::RateDependentWidth, Self::WarmUp, Self::Drift],
            Self::WarmUp => &[Self::Creep, Self::Drift],
            Self::Drift => &[Self::WarmUp, Self::Creep],
            _ => &[],
        }
    }

    /// The cause of this name.
    pub fn of_name(name: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|cause| cause.name() == name)
    }
}

impl fmt::Display for Cause {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.name())
    }
}
