//! What turns pressure into contraction inside a plant: a trait, and the body that is a balance of
//! forces.
//!
//! [`Balance`] puts every effect where it acts in the forces on the muscle; what an effect does to
//! the valve, the line or the sensor is the plant's matter. Its time constants and frequencies hold
//! at mid stroke of the frictionless muscle, with the stiffness it has there while all friction
//! slips.

use crate::braid::Braid;
use crate::creep::Creep;
use crate::dynamics::Dynamics;
use crate::effects::{Effects, Temperature, WarmUp};
use crate::muscle::{Condition, Muscle};
use crate::parameters::{NOMINAL_LENGTH_MM, SKIN_STIFFNESS_N, VALVE_RANGE_BAR};
use crate::sensitivity::{Sensitivities, Sensitivity};
use crate::surroundings::{REFERENCE_TEMPERATURE_C, Surroundings};

/// The part of a plant between pressure and contraction.
pub trait Body: Send {
    /// Lets `dt_s` (above 0 s) pass with `pressure_bar` inside; the contraction then, mm.
    fn step(&mut self, pressure_bar: f64, surroundings: &Surroundings, dt_s: f64) -> f64;

    /// What load and temperature do to it.
    fn sensitivities(&self) -> Sensitivities;
}

/// The muscle as a balance of forces, with effects.
#[derive(Debug, Clone)]
pub struct Balance {
    muscle: Muscle,
    dead_load_n: f64,
    temperature: Option<Temperature>,
    warm_up: Option<WarmUp>,
    creep: Option<Creep>,
    travel_mm: f64,
}

impl Balance {
    /// A muscle at rest under its dead load, with what of `effects` is the muscle's.
    pub fn at_rest(dead_load_n: f64, effects: &Effects) -> Self {
        let muscle = Muscle::with_dynamics(dead_load_n, dynamics(dead_load_n, effects));
        Self {
            dead_load_n,
            temperature: effects.temperature.clone(),
            warm_up: effects.warm_up.clone(),
            creep: effects.creep.as_ref().map(|creep| Creep::new(creep, muscle.contraction_mm())),
            muscle,
            travel_mm: 0.0,
        }
    }
}

impl Body for Balance {
    fn step(&mut self, pressure_bar: f64, surroundings: &Surroundings, dt_s: f64) -> f64 {
        let warmer_k = surroundings.temperature_c - REFERENCE_TEMPERATURE_C;
        let (softening_per_k, expansion_mm_per_k) = self
            .temperature
            .as_ref()
            .map_or((0.0, 0.0), |hidden| (hidden.softening_per_k, hidden.expansion_mm_per_k));
        let stiffening = self
            .warm_up
            .as_ref()
            .map_or(0.0, |warm_up| warm_up.fraction * (-self.travel_mm / warm_up.travel_mm).exp());
        let condition = Condition {
            pressure_bar,
            load_n: surroundings.load_n,
            skin: (1.0 + stiffening) * (1.0 - softening_per_k * warmer_k),
            friction: surroundings.friction,
        };
        let before_mm = self.muscle.contraction_mm();
        self.muscle.advance(&condition, dt_s);
        let contraction_mm = self.muscle.contraction_mm();
        self.travel_mm += (contraction_mm - before_mm).abs();
        let there_mm = self.creep.as_mut().map_or(contraction_mm, |creep| creep.step(contraction_mm, dt_s));
        there_mm + expansion_mm_per_k * warmer_k
    }

    fn sensitivities(&self) -> Sensitivities {
        let along = |shift_mm: &dyn Fn(f64, f64) -> f64| {
            let points = (4..=24).map(|quarters_bar| {
                let pressure_bar = 0.25 * f64::from(quarters_bar);
                let ratio = frictionless_ratio(pressure_bar, self.dead_load_n, 1.0);
                (ratio * NOMINAL_LENGTH_MM, shift_mm(ratio, sliding_stiffness_n(pressure_bar, ratio)))
            });
            Sensitivity::fitted(points)
        };
        Sensitivities {
            per_n: along(&|_, stiffness_n| -NOMINAL_LENGTH_MM / stiffness_n),
            per_k: self.temperature.as_ref().map(|hidden| {
                along(&|ratio, stiffness_n| {
                    let force_n_per_k = hidden.softening_per_k * SKIN_STIFFNESS_N * ratio;
                    hidden.expansion_mm_per_k + NOMINAL_LENGTH_MM * force_n_per_k / stiffness_n
                })
            }),
            lacking: self.warm_up.as_ref().map(|hidden| {
                let ratio = |pressure_bar, skin| frictionless_ratio(pressure_bar, self.dead_load_n, skin);
                let stroke = ratio(VALVE_RANGE_BAR, 1.0) - ratio(0.0, 1.0);
                let lacks =
                    |pressure_bar| ratio(pressure_bar, 1.0) - ratio(pressure_bar, 1.0 + hidden.fraction);
                (0..=24)
                    .map(|quarters_bar| lacks(0.25 * f64::from(quarters_bar)) / stroke)
                    .fold(0.0, f64::max)
            }),
        }
    }
}

/// The forces of motion of `effects`.
fn dynamics(load_n: f64, effects: &Effects) -> Dynamics {
    let stiffness_n = mid_stroke_stiffness_n(load_n);
    let mut dynamics = Dynamics::default();
    if let Some(viscous) = &effects.viscous_lag {
        dynamics.viscosity_n_s += stiffness_n * viscous.time_constant_s;
    }
    if let Some(inertia) = &effects.inertia {
        let natural_per_s = std::f64::consts::TAU * inertia.natural_frequency_hz;
        dynamics.mass_n_s2 = stiffness_n / (natural_per_s * natural_per_s);
        dynamics.viscosity_n_s += 2.0 * inertia.damping_ratio * stiffness_n / natural_per_s;
    }
    if let Some(width) = &effects.rate_dependent_width {
        dynamics.width_gain = width.width_gain;
        dynamics.rate_exponent = width.rate_exponent;
    }
    dynamics
}

/// Stiffness at mid stroke between 0 bar and the range's end, without friction, N per unit of
/// contraction ratio.
fn mid_stroke_stiffness_n(load_n: f64) -> f64 {
    let ends = [0.0, VALVE_RANGE_BAR].map(|pressure_bar| frictionless_ratio(pressure_bar, load_n, 1.0));
    let middle = 0.5 * (ends[0] + ends[1]);
    let pressure_bar =
        bisected(0.0, VALVE_RANGE_BAR, |pressure_bar| frictionless_ratio(pressure_bar, load_n, 1.0) < middle);
    sliding_stiffness_n(pressure_bar, middle)
}

/// Stiffness while all friction slips, N per unit of contraction ratio.
fn sliding_stiffness_n(pressure_bar: f64, ratio: f64) -> f64 {
    SKIN_STIFFNESS_N - Braid::new().pull_n(pressure_bar, ratio).1
}

/// The contraction ratio at which pull, skin and load balance. `skin`: factor on the skin's
/// stiffness.
fn frictionless_ratio(pressure_bar: f64, load_n: f64, skin: f64) -> f64 {
    let (braid, stiffness_n) = (Braid::new(), skin * SKIN_STIFFNESS_N);
    bisected(-load_n / stiffness_n, braid.neutral_ratio(), |ratio| {
        braid.pull_n(pressure_bar, ratio).0 > stiffness_n * ratio + load_n
    })
}

/// Where `is_below` turns from true to false.
fn bisected(mut low: f64, mut high: f64, is_below: impl Fn(f64) -> bool) -> f64 {
    for _ in 0..60 {
        let middle = 0.5 * (low + high);
        if is_below(middle) {
            low = middle;
        } else {
            high = middle;
        }
    }
    0.5 * (low + high)
}
