//! The parameters of the hidden effects: drawn by the seed around nominal values, scaled by the
//! strength.
//!
//! They are written as a model's user names them; where an effect acts, the plant turns them into
//! forces, thresholds or volts. Strength 1 adds several times the misfit of a good operator model
//! (0.3 to 0.6 mm), strength 0.33 is just visible. Strength 0 hides nothing at all.

use serde::Serialize;

use crate::effect::Effect;
use crate::parameters::{VALVE_RANGE_BAR, VALVE_TIME_CONSTANT_S};
use crate::scale::Scale;

/// What is wrong with a plant. The default is nothing.
#[derive(Debug, Clone, Default, PartialEq, Serialize)]
pub struct Effects {
    /// A slow valve.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub valve_lag: Option<ValveLag>,
    /// A valve that ignores small changes.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub valve_deadband: Option<ValveDeadband>,
    /// A supply below the range.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub supply_saturation: Option<SupplySaturation>,
    /// Dead time behind the pressure sensor.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub transport_delay: Option<TransportDelay>,
    /// Viscous friction.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub viscous_lag: Option<ViscousLag>,
    /// Friction that grows with speed.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub rate_dependent_width: Option<RateDependentWidth>,
    /// A mass.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub inertia: Option<Inertia>,
    /// Retarded contraction.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub creep: Option<Creep>,
    /// A load that changes.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub load: Option<Load>,
    /// A muscle that feels the temperature.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub temperature: Option<Temperature>,
    /// A zero that moves.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub drift: Option<Drift>,
    /// A muscle that settles with travel.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub warm_up: Option<WarmUp>,
    /// A tone.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub periodic_disturbance: Option<PeriodicDisturbance>,
    /// The outsiders and their strength.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub outsiders: Vec<Outsider>,
}

/// First-order lag of the pressure behind the command, the sound regulator's own included.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct ValveLag {
    /// Time constant, s.
    pub time_constant_s: f64,
}

/// Smallest change that moves the valve.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct ValveDeadband {
    /// Width, bar.
    pub band_bar: f64,
}

/// The highest pressure there is.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct SupplySaturation {
    /// Pressure of the supply, bar.
    pub supply_bar: f64,
}

/// Dead time from the pressure sensor to the muscle.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct TransportDelay {
    /// Dead time, s.
    pub delay_s: f64,
}

/// First-order lag of the contraction.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct ViscousLag {
    /// Time constant at mid stroke while the friction slips, s.
    pub time_constant_s: f64,
}

/// Friction `F0 (1 + width_gain rate^rate_exponent)`; the rate is 1 at 1 bar/s, or near it at 20
/// mm/s.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct RateDependentWidth {
    /// Growth at rate 1, dimensionless.
    pub width_gain: f64,
    /// Exponent of the rate, dimensionless.
    pub rate_exponent: f64,
}

/// Second-order response.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Inertia {
    /// Undamped natural frequency at mid stroke while the friction slips, Hz.
    pub natural_frequency_hz: f64,
    /// Damping ratio there, dimensionless, beside the friction.
    pub damping_ratio: f64,
}

/// Retarded elements, one a decade.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Creep {
    /// Share of the contraction that comes late, for each element.
    pub fraction_per_decade: f64,
    /// Time constants of the elements, s.
    pub time_constants_s: [f64; 3],
}

/// Recorded load beside the dead one.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Load {
    /// Largest step above the dead load, N.
    pub swing_n: f64,
}

/// What a kelvin does.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Temperature {
    /// Shift of the length by the frame and the rod, mm/K.
    pub expansion_mm_per_k: f64,
    /// Relative loss of the skin's stiffness, 1/K. The operator plant's curve grows by it.
    pub softening_per_k: f64,
}

/// Movement of the sensor's zero.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Drift {
    /// Its speed, mm/s.
    pub mm_per_s: f64,
}

/// Stiffness that goes with travel.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct WarmUp {
    /// Additional share of the skin's stiffness at first. The operator plant's curve lacks this
    /// share.
    pub fraction: f64,
    /// Travel after which a part 1/e of it is left, mm.
    pub travel_mm: f64,
}

/// A tone on the length.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct PeriodicDisturbance {
    /// Frequency, Hz.
    pub frequency_hz: f64,
    /// Amplitude, mm.
    pub amplitude_mm: f64,
    /// Phase at 0 s, rad.
    pub phase_rad: f64,
}

/// An effect that no diagnosis knows.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Outsider {
    /// Which.
    #[serde(serialize_with = "by_name")]
    pub effect: Effect,
    /// How strong: 1 is plainly visible.
    pub strength: f64,
}

fn by_name<S: serde::Serializer>(effect: &Effect, serializer: S) -> Result<S::Ok, S::Error> {
    serializer.serialize_str(effect.name())
}

impl Effects {
    /// The parameters of `effects` under `seed` at `strength` (0 and more).
    pub fn drawn(effects: &[Effect], strength: f64, seed: u64) -> Self {
        let mut drawn = Self::default();
        if strength > 0.0 {
            for effect in effects {
                drawn.add(*effect, strength, seed);
            }
        }
        drawn
    }

    /// The same for a plant and a recording of another size.
    #[must_use]
    pub fn scaled(mut self, scale: &Scale) -> Self {
        if let Some(load) = &mut self.load {
            load.swing_n *= scale.force;
        }
        if let Some(temperature) = &mut self.temperature {
            temperature.expansion_mm_per_k *= scale.length;
        }
        if let Some(drift) = &mut self.drift {
            drift.mm_per_s *= scale.length / scale.duration;
        }
        if let Some(warm_up) = &mut self.warm_up {
            warm_up.travel_mm *= scale.length;
        }
        if let Some(tone) = &mut self.periodic_disturbance {
            tone.amplitude_mm *= scale.length;
        }
        self
    }

    /// Whether nothing is wrong.
    pub fn is_none(&self) -> bool {
        *self == Self::default()
    }

    /// The strength of an outsider, 0 when it is not there.
    pub(crate) fn outsider(&self, effect: Effect) -> f64 {
        self.outsiders.iter().find(|outsider| outsider.effect == effect).map_or(0.0, |found| found.strength)
    }

    fn add(&mut self, effect: Effect, strength: f64, seed: u64) {
        let mut draw = effect.parameters(seed);
        match effect {
            Effect::ValveLag => {
                let time_constant_s = VALVE_TIME_CONSTANT_S + strength * draw.around(0.25);
                self.valve_lag = Some(ValveLag { time_constant_s });
            }
            Effect::ValveDeadband => {
                self.valve_deadband = Some(ValveDeadband { band_bar: strength * draw.around(0.25) });
            }
            Effect::SupplySaturation => {
                let supply_bar = VALVE_RANGE_BAR - (strength * draw.around(1.2)).min(VALVE_RANGE_BAR);
                self.supply_saturation = Some(SupplySaturation { supply_bar });
            }
            Effect::TransportDelay => {
                self.transport_delay = Some(TransportDelay { delay_s: strength * draw.around(0.04) });
            }
            Effect::ViscousLag => {
                self.viscous_lag = Some(ViscousLag { time_constant_s: strength * draw.around(0.05) });
            }
            Effect::RateDependentWidth => {
                self.rate_dependent_width = Some(RateDependentWidth {
                    width_gain: strength * draw.around(0.4),
                    rate_exponent: draw.around(0.5),
                });
            }
            Effect::Inertia => {
                // At a constant damping ratio both the lag and the time to swing go with the
                // strength.
                self.inertia = Some(Inertia {
                    natural_frequency_hz: draw.around(4.0) / strength,
                    damping_ratio: draw.around(0.25),
                });
            }
            Effect::Creep => {
                let shortest_s = draw.around(0.25);
                self.creep = Some(Creep {
                    fraction_per_decade: strength * draw.around(0.05),
                    time_constants_s: [1.0, 10.0, 100.0].map(|decades| shortest_s * decades),
                });
            }
            Effect::Load => self.load = Some(Load { swing_n: strength * draw.around(25.0) }),
            Effect::Temperature => {
                self.temperature = Some(Temperature {
                    expansion_mm_per_k: strength * draw.around(0.7) * draw.sign(),
                    softening_per_k: strength * draw.around(0.01),
                });
            }
            Effect::Drift => {
                self.drift = Some(Drift { mm_per_s: strength * draw.around(0.045) * draw.sign() });
            }
            Effect::WarmUp => {
                self.warm_up =
                    Some(WarmUp { fraction: strength * draw.around(0.1), travel_mm: draw.around(500.0) });
            }
            Effect::PeriodicDisturbance => {
                self.periodic_disturbance = Some(PeriodicDisturbance {
                    frequency_hz: draw.log_uniform(0.5, 8.0),
                    amplitude_mm: strength * draw.around(2.0),
                    phase_rad: draw.uniform(0.0, std::f64::consts::TAU),
                });
            }
            _ => self.outsiders.push(Outsider { effect, strength }),
        }
    }
}
