//! The rig as a controller sees it: command in, measured pressure and contraction out.
//!
//! Valve, pressure sensor, line, then a [`Body`] in its surroundings, then the gauge and the
//! sensors. The caller sets the pace: a command is held over any time step, the valve is exact for
//! it and a sound muscle has no time in it. Steps of 50 ms and of 1 ms agree within 5 µm. Where
//! effects are hidden the plant takes steps of at most [`SUBSTEP_S`] inside.
//!
//! What is recorded of the pressure is the valve's; dead time and leaks lie behind it.

use crate::body::{Balance, Body};
use crate::delay::DelayLine;
use crate::effect::Effect;
use crate::effects::Effects;
use crate::gauge::Gauge;
use crate::operator::Operator;
use crate::parameters::DEAD_LOAD_N;
use crate::scale::Scale;
use crate::sensor::{Measurement, Sensors};
use crate::set_point::DeadBand;
use crate::surroundings::{Course, REFERENCE_TEMPERATURE_C, Surroundings};
use crate::truth::Truth;
use crate::valve::{Regulator, Valve};
use crate::wander::Staircase;

/// Longest step inside a plant with effects, s.
pub const SUBSTEP_S: f64 = 1e-3;

/// Largest share of the pressure that a leak takes at strength 1.
const LEAK_SHARE: f64 = 0.15;

/// Which body a plant has.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Kind {
    /// The balance of forces.
    #[default]
    Rig,
    /// The paper's operator model, see [`crate::operator`].
    Mgpi,
}

/// What a plant is made of.
#[derive(Debug, Clone)]
pub struct Setup {
    /// Its body.
    pub kind: Kind,
    /// What is wrong with it.
    pub effects: Effects,
    /// Seed of everything random.
    pub seed: u64,
    /// Dead load, from 0 N to [`LOAD_LIMIT_N`](crate::parameters::LOAD_LIMIT_N).
    pub load_n: f64,
    /// Whether the sensors are noisy.
    pub noise: bool,
}

impl Setup {
    /// A sound force balance with noisy sensors under its own dead load.
    pub fn sound(seed: u64) -> Self {
        Self { kind: Kind::Rig, effects: Effects::default(), seed, load_n: DEAD_LOAD_N, noise: true }
    }
}

/// The parts that a plant is put together from.
pub struct Parts {
    /// What is wrong with it.
    pub effects: Effects,
    /// Seed of what is random in the effects.
    pub seed: u64,
    /// Dead load, N.
    pub dead_load_n: f64,
    /// The valve.
    pub valve: Box<dyn Regulator>,
    /// The muscle.
    pub body: Box<dyn Body>,
    /// The sensors.
    pub sensors: Sensors,
    /// How large it is.
    pub scale: Scale,
    /// Growth of the muscle's volume for each mm of contraction, as a share of the one at rest.
    pub volume_per_mm: f64,
    /// Whether it takes steps of at most [`SUBSTEP_S`] inside.
    pub is_timed: bool,
}

/// A muscle on its valve with its sensors.
pub struct Plant {
    effects: Effects,
    valve: Box<dyn Regulator>,
    volume_per_mm: f64,
    is_timed: bool,
    line: Option<DelayLine>,
    leak: Option<(f64, Staircase)>,
    course: Course,
    body: Box<dyn Body>,
    contraction_mm: f64,
    gauge: Gauge,
    sensors: Sensors,
    time_s: f64,
    /// Load that somebody puts on it, N.
    put_on_n: f64,
    /// How warm it is kept, K above where it is a sound one; None where the room does that.
    heated_k: Option<f64>,
}

impl Plant {
    /// A sound plant, vented and at rest under `load_n`.
    pub fn at_rest(load_n: f64, sensors: Sensors) -> Self {
        Self { sensors, ..Self::new(&Setup { load_n, ..Setup::sound(0) }) }
    }

    /// A plant at rest.
    pub fn new(setup: &Setup) -> Self {
        let Setup { kind, effects, seed, load_n, noise } = setup;
        let (body, dead_band): (Box<dyn Body>, _) = match kind {
            Kind::Rig => (Box::new(Balance::at_rest(*load_n, effects)), DeadBand::Hold),
            Kind::Mgpi => (Box::new(Operator::at_rest(*load_n, effects, *seed)), DeadBand::Backlash),
        };
        Self::assembled(Parts {
            effects: effects.clone(),
            seed: *seed,
            dead_load_n: *load_n,
            valve: Box::new(Valve::with(effects, dead_band)),
            body,
            sensors: if *noise { Sensors::noisy(*seed) } else { Sensors::ideal() },
            scale: Scale::default(),
            volume_per_mm: 0.0,
            is_timed: !effects.is_none(),
        })
    }

    /// A plant of these parts, at rest.
    pub fn assembled(parts: Parts) -> Self {
        let Parts { effects, seed, dead_load_n, valve, mut body, sensors, scale, volume_per_mm, is_timed } =
            parts;
        let mut course = Course::new(dead_load_n, &effects, &scale, seed);
        let leak_strength = effects.outsider(Effect::Leak);
        Self {
            valve,
            volume_per_mm,
            is_timed,
            line: effects.transport_delay.as_ref().map(|hidden| DelayLine::new(hidden.delay_s, 0.0)),
            leak: (leak_strength > 0.0)
                .then(|| (leak_strength * LEAK_SHARE, Staircase::new(Effect::Leak.course(seed), 3.0, 15.0))),
            contraction_mm: body.step(0.0, &course.at(0.0), SUBSTEP_S),
            course,
            body,
            gauge: Gauge::new(&effects, &scale, seed),
            sensors,
            time_s: 0.0,
            put_on_n: 0.0,
            heated_k: None,
            effects,
        }
    }

    /// What is wrong with it.
    pub fn truth(&self) -> Truth {
        Truth::new(&self.effects, &self.body.sensitivities())
    }

    /// Puts a load (N) on the muscle, beside what hangs there, from now on; no sensor sees it.
    pub fn put_on(&mut self, load_n: f64) {
        self.put_on_n = load_n;
    }

    /// Keeps the muscle from now on so much (K) above the temperature at which it is a sound one,
    /// whatever the room does; no sensor sees it.
    pub fn heat(&mut self, kelvin: f64) {
        self.heated_k = Some(kelvin);
    }

    /// Holds `command_bar` for `dt_s` (0 s and more), then measures.
    pub fn step(&mut self, command_bar: f64, dt_s: f64) -> Measurement {
        self.run(command_bar, dt_s);
        self.measure()
    }

    /// Holds `command_bar` for `dt_s` (0 s and more).
    pub fn run(&mut self, command_bar: f64, dt_s: f64) {
        let steps = if self.is_timed { (dt_s / SUBSTEP_S).ceil().max(1.0) } else { 1.0 };
        if dt_s > 0.0 {
            for _ in 0..steps as u64 {
                self.advance(command_bar, dt_s / steps);
            }
        }
    }

    /// The contraction as an exact sensor would read it now, mm.
    pub fn exact_mm(&mut self) -> f64 {
        self.gauge.read(self.contraction_mm, self.time_s)
    }

    /// Measures once.
    pub fn measure(&mut self) -> Measurement {
        let Surroundings { recorded_load_n: load_n, temperature_c, .. } = self.course.at(self.time_s);
        self.sensors.measure(Measurement {
            pressure_bar: self.valve.pressure_bar(),
            contraction_mm: self.gauge.read(self.contraction_mm, self.time_s),
            load_n,
            temperature_c,
        })
    }

    fn advance(&mut self, command_bar: f64, dt_s: f64) {
        self.time_s += dt_s;
        self.valve.step(command_bar, 1.0 + self.volume_per_mm * self.contraction_mm.max(0.0), dt_s);
        let mut pressure_bar = self.valve.pressure_bar();
        if let Some(line) = &mut self.line {
            pressure_bar = line.step(pressure_bar, dt_s);
        }
        if let Some((share, opening)) = &mut self.leak {
            pressure_bar *= (1.0 - *share * opening.at(self.time_s)).max(0.0);
        }
        let mut surroundings = self.course.at(self.time_s);
        surroundings.load_n += self.put_on_n;
        if let Some(kelvin) = self.heated_k {
            surroundings.temperature_c = REFERENCE_TEMPERATURE_C + kelvin;
        }
        self.contraction_mm = self.body.step(pressure_bar, &surroundings, dt_s);
    }
}
