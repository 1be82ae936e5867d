//! What the muscle hangs in: its load, the room's temperature, and what is wrong with them.
//!
//! The temperature always wanders and is always there to be recorded; whether the muscle feels it
//! is the muscle's matter. The load is the dead one unless it is hidden that it changes.

use crate::draw::{Draw, Stream};
use crate::effect::Effect;
use crate::effects::Effects;
use crate::parameters::LOAD_LIMIT_N;
use crate::scale::Scale;
use crate::wander::{Staircase, Wave};

/// Temperature at which a muscle that feels it is a sound one, °C.
pub const REFERENCE_TEMPERATURE_C: f64 = 20.0;

/// How far the room's temperature wanders, root mean square, K.
const TEMPERATURE_WANDER_K: f64 = 2.0;

/// Largest step of an unrecorded load at strength 1, N.
const UNRECORDED_SWING_N: f64 = 25.0;

/// How far the friction wanders at strength 1, root mean square, as a share of itself.
const FRICTION_WANDER: f64 = 0.5;

/// The state of the surroundings at one instant.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Surroundings {
    /// Load on the muscle, N.
    pub load_n: f64,
    /// The part of it that is recorded, N.
    pub recorded_load_n: f64,
    /// Temperature, °C.
    pub temperature_c: f64,
    /// Factor on the muscle's friction.
    pub friction: f64,
}

/// The course of the surroundings over time.
#[derive(Debug, Clone)]
pub(crate) struct Course {
    dead_load_n: f64,
    temperature: Wave,
    load: Option<(f64, Staircase, Wave)>,
    unrecorded: Option<(f64, Staircase)>,
    friction: Option<(f64, Wave)>,
    limit_n: f64,
}

impl Course {
    pub(crate) fn new(dead_load_n: f64, effects: &Effects, scale: &Scale, seed: u64) -> Self {
        let outsider = |effect| Some(effects.outsider(effect)).filter(|strength| *strength > 0.0);
        Self {
            dead_load_n,
            temperature: Wave::new(&mut Draw::new(seed, Stream::Temperature), 30.0, 150.0),
            load: effects.load.as_ref().map(|load| {
                let mut draw = Effect::Load.course(seed);
                let wave = Wave::new(&mut draw, 10.0, 40.0);
                (load.swing_n, Staircase::new(draw, 3.0, 12.0), wave)
            }),
            unrecorded: outsider(Effect::LoadUnrecorded).map(|strength| {
                let draw = Effect::LoadUnrecorded.course(seed);
                (scale.force * UNRECORDED_SWING_N * strength, Staircase::new(draw, 2.0, 8.0))
            }),
            friction: outsider(Effect::FrictionWander).map(|strength| {
                let mut draw = Effect::FrictionWander.course(seed);
                (FRICTION_WANDER * strength, Wave::new(&mut draw, 5.0, 30.0))
            }),
            limit_n: scale.force * LOAD_LIMIT_N,
        }
    }

    /// The surroundings at `time_s`, which never goes back.
    pub(crate) fn at(&mut self, time_s: f64) -> Surroundings {
        let mut recorded_load_n = self.dead_load_n;
        if let Some((swing_n, steps, wave)) = &mut self.load {
            let share = steps.at(time_s) + 0.2 * (1.0 + wave.at(time_s));
            recorded_load_n = (recorded_load_n + *swing_n * share).clamp(0.0, self.limit_n);
        }
        let unrecorded_n =
            self.unrecorded.as_mut().map_or(0.0, |(swing_n, steps)| *swing_n * steps.at(time_s));
        Surroundings {
            load_n: (recorded_load_n + unrecorded_n).min(self.limit_n),
            recorded_load_n,
            temperature_c: REFERENCE_TEMPERATURE_C + TEMPERATURE_WANDER_K * self.temperature.at(time_s),
            friction: self
                .friction
                .as_ref()
                .map_or(1.0, |(share, wave)| (1.0 + share * wave.at(time_s)).max(0.0)),
        }
    }
}
