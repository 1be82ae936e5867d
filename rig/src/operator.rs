//! A plant that is an operator model: the paper's tabled MGPI with parameters varied by the seed.
//!
//! Unlike the balance of forces it lies in the family of models that are identified from it, and
//! the same effects act in it in other forms, so that a finder that has learnt the one plant fails
//! on the other:
//!
//! | effect | form here |
//! |---|---|
//! | `rate_dependent_width`, `friction_wander` | thresholds `r (1 + k rate^a)` by the rate of the pressure; `r` times a factor |
//! | `viscous_lag`, `inertia` | first-order, second-order lag of the output |
//! | `creep` | on the pressure, before the hysteresis |
//! | `load`, `temperature`, `warm_up` | offset and gain of the output |
//!
//! The arithmetic is the plant's own; of the model crate it takes the paper's tables only.

use model_core::paper::{ENVELOPE, MUSCLE_LENGTH_MM, PLAYS, PRESSURE_MAX_BAR, SIZE, WEIGHTS};

use crate::body::Body;
use crate::creep::Creep;
use crate::draw::{Draw, Stream};
use crate::effects::{Effects, Inertia, RateDependentWidth, Temperature, ViscousLag, WarmUp};
use crate::sensitivity::{Sensitivities, Sensitivity};
use crate::surroundings::{REFERENCE_TEMPERATURE_C, Surroundings};

/// What a newton does: the shift near that of the balance of forces at no contraction and at a
/// large one.
const PER_NEWTON: Sensitivity = Sensitivity { offset_mm: -0.3, gain: 0.002 };

/// Time constant of the rate of the pressure, s: friction takes a moment to know its speed.
const RATE_TIME_CONSTANT_S: f64 = 0.01;

/// The model and its effects.
#[derive(Debug, Clone)]
pub struct Operator {
    tanh: [f64; 4],
    /// Threshold and weight of each play; the weight of the input itself.
    plays: [(f64, f64); SIZE],
    direct: f64,
    /// Threshold and slope beyond it, mm, of each segment of the dead-zone map.
    segments: [(f64, f64); SIZE],
    memory: [f64; SIZE],
    dead_load_n: f64,
    per_newton: Sensitivity,
    temperature: Option<Temperature>,
    warm_up: Option<WarmUp>,
    viscous: Option<ViscousLag>,
    inertia: Option<Inertia>,
    width: Option<RateDependentWidth>,
    creep: Option<Creep>,
    last_pressure_bar: f64,
    rate_bar_per_s: f64,
    travel_mm: f64,
    last_static_mm: f64,
    /// Contraction behind lag and mass, mm, and its speed, mm/s.
    lagging_mm: f64,
    moving_mm: (f64, f64),
}

impl Operator {
    /// The model at rest under its dead load, with what of `effects` is the muscle's.
    pub fn at_rest(dead_load_n: f64, effects: &Effects, seed: u64) -> Self {
        let mut draw = Draw::new(seed, Stream::Operator);
        let mut vary = |nominal: f64| nominal * draw.uniform(0.9, 1.1);
        let tanh = [ENVELOPE.c0, vary(ENVELOPE.c1), ENVELOPE.c2, ENVELOPE.c3];
        let [direct, rho, tau, alpha] = PLAYS.map(&mut vary);
        let plays: [(f64, f64); SIZE] = std::array::from_fn(|index| {
            let threshold = alpha * index as f64;
            (threshold, rho * (-tau * threshold).exp())
        });
        let mut model = Self {
            tanh,
            plays,
            direct,
            segments: [(0.0, 0.0); SIZE],
            memory: [0.0; SIZE],
            dead_load_n,
            per_newton: Sensitivity { offset_mm: vary(PER_NEWTON.offset_mm), gain: vary(PER_NEWTON.gain) },
            temperature: effects.temperature.clone(),
            warm_up: effects.warm_up.clone(),
            viscous: effects.viscous_lag.clone(),
            inertia: effects.inertia.clone(),
            width: effects.rate_dependent_width.clone(),
            creep: effects.creep.as_ref().map(|creep| Creep::new(creep, 0.0)),
            last_pressure_bar: 0.0,
            rate_bar_per_s: 0.0,
            travel_mm: 0.0,
            last_static_mm: 0.0,
            lagging_mm: 0.0,
            moving_mm: (0.0, 0.0),
        };
        let highest = model.clone().played(PRESSURE_MAX_BAR, 1.0);
        let mut slope = 0.0;
        for (index, (segment, weight)) in model.segments.iter_mut().zip(WEIGHTS).enumerate() {
            slope += weight;
            *segment = (highest * index as f64 / SIZE as f64, vary(slope) * MUSCLE_LENGTH_MM);
        }
        let rest_mm = model.static_mm(0.0, 1.0);
        model.last_static_mm = rest_mm;
        model.lagging_mm = rest_mm;
        model.moving_mm = (rest_mm, 0.0);
        model
    }

    /// Envelope and plays, their thresholds `widened` by a factor.
    fn played(&mut self, pressure_bar: f64, widened: f64) -> f64 {
        let [c0, c1, c2, c3] = self.tanh;
        let value = c0 * (c1 * pressure_bar + c2).tanh() + c3;
        let mut sum = self.direct * value;
        for (memory, (threshold, weight)) in self.memory.iter_mut().zip(&self.plays) {
            *memory = memory.clamp(value - widened * threshold, value + widened * threshold);
            sum += weight * *memory;
        }
        sum
    }

    /// The whole model without effects on its output, mm.
    fn static_mm(&mut self, pressure_bar: f64, widened: f64) -> f64 {
        let played = self.played(pressure_bar, widened);
        let mut sum_mm = self.segments[0].1 * (played - self.segments[0].0).min(0.0);
        for (index, (threshold, slope_mm)) in self.segments.iter().enumerate() {
            let end = self.segments.get(index + 1).map_or(f64::INFINITY, |next| next.0);
            sum_mm += slope_mm * (played.min(end) - threshold).max(0.0);
        }
        sum_mm
    }

    /// First-order and second-order lag of the output, mm.
    fn moved_mm(&mut self, goal_mm: f64, dt_s: f64) -> f64 {
        self.lagging_mm = match &self.viscous {
            Some(viscous) => {
                self.lagging_mm + (goal_mm - self.lagging_mm) * -(-dt_s / viscous.time_constant_s).exp_m1()
            }
            None => goal_mm,
        };
        let Some(inertia) = &self.inertia else { return self.lagging_mm };
        let natural_per_s = std::f64::consts::TAU * inertia.natural_frequency_hz;
        let (place_mm, speed_mm_per_s) = self.moving_mm;
        // Trapezoidal: exact in damping and frequency to second order at any step.
        let half_s = 0.5 * dt_s;
        let spring = natural_per_s * natural_per_s * half_s;
        let damping = 2.0 * inertia.damping_ratio * natural_per_s * half_s;
        let ahead_mm = self.lagging_mm - place_mm - half_s * speed_mm_per_s;
        let behind_mm = self.lagging_mm - place_mm;
        let speed = (speed_mm_per_s * (1.0 - damping) + spring * (ahead_mm + behind_mm))
            / (1.0 + damping + spring * half_s);
        self.moving_mm = (place_mm + half_s * (speed_mm_per_s + speed), speed);
        self.moving_mm.0
    }
}

impl Body for Operator {
    fn step(&mut self, pressure_bar: f64, surroundings: &Surroundings, dt_s: f64) -> f64 {
        let pressure_bar = self.creep.as_mut().map_or(pressure_bar, |creep| creep.step(pressure_bar, dt_s));
        let rate_bar_per_s = ((pressure_bar - self.last_pressure_bar) / dt_s).abs();
        self.last_pressure_bar = pressure_bar;
        self.rate_bar_per_s +=
            (rate_bar_per_s - self.rate_bar_per_s) * -(-dt_s / RATE_TIME_CONSTANT_S).exp_m1();
        let widened = self
            .width
            .as_ref()
            .map_or(1.0, |width| 1.0 + width.width_gain * self.rate_bar_per_s.powf(width.rate_exponent));
        let static_mm = self.static_mm(pressure_bar, widened * surroundings.friction);
        self.travel_mm += (static_mm - self.last_static_mm).abs();
        self.last_static_mm = static_mm;

        let lacking = self
            .warm_up
            .as_ref()
            .map_or(0.0, |warm_up| warm_up.fraction * (-self.travel_mm / warm_up.travel_mm).exp());
        let warmer_k = surroundings.temperature_c - REFERENCE_TEMPERATURE_C;
        let (shift_mm, growth) = self.temperature.as_ref().map_or((0.0, 0.0), |hidden| {
            (hidden.expansion_mm_per_k * warmer_k, hidden.softening_per_k * warmer_k)
        });
        let more_n = surroundings.load_n - self.dead_load_n;
        let goal_mm = static_mm * (1.0 + growth - lacking + self.per_newton.gain * more_n)
            + shift_mm
            + self.per_newton.offset_mm * more_n;
        self.moved_mm(goal_mm, dt_s)
    }

    fn sensitivities(&self) -> Sensitivities {
        let per_k = self
            .temperature
            .as_ref()
            .map(|hidden| Sensitivity { offset_mm: hidden.expansion_mm_per_k, gain: hidden.softening_per_k });
        let lacking = self.warm_up.as_ref().map(|hidden| hidden.fraction);
        Sensitivities { per_n: self.per_newton, per_k, lacking }
    }
}
