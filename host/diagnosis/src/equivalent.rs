//! What the operators see: the input after the lags on its way, less what acts on the muscle as a force.

use std::borrow::Cow;

use super::basis::Seen;
use super::delay::{delayed, delayed_at};
use super::effect::{Effect, Form, Parameter, Rate};
use super::low_pass::low_pass;
use super::output::driven;
use super::regulator;
use super::signals::{Recorded, Signals, TENTS};

/// What arrives at the muscle.
#[derive(Clone, Debug)]
pub struct Arrived {
    /// The input after the lags, delays and creep on its way.
    pub input: Vec<f64>,
    /// How fast that moves. Unit: input unit/s.
    pub speed: Vec<f64>,
}

impl Arrived {
    /// The input under these effects. All rows take part, kept or not: a delay may be shorter than these are apart.
    pub fn new(signals: &Signals, effects: &[Effect]) -> Self {
        let Recorded { time_s, input, input_speed, .. } = &*signals.recorded;
        let (input, input_speed) = below(Effect::ceiling(effects), input, input_speed);
        let needs_speed = effects.iter().any(|effect| effect.form == Form::Thresholds(Rate::Input));
        let is_slow =
            |effect: &Effect| matches!(effect.form, Form::SecondOrder | Form::Orifice | Form::CreepOfInput);
        if !effects.iter().any(is_slow) {
            // Delays add up.
            let delays = effects.iter().filter(|effect| effect.form == Form::Delay);
            let delay_s = delays.flat_map(|effect| &effect.parameters).map(|delay| delay.value).sum();
            let late = |values: &[f64]| match delay_s {
                0.0 => signals.kept(values),
                _ => delayed_at(values, time_s, &signals.time_s, delay_s),
            };
            let speed = if needs_speed { late(&input_speed) } else { signals.speed_of(Rate::Input).to_vec() };
            return Self { input: late(&input), speed };
        }
        let (mut input, mut speed) = (input.into_owned(), input_speed.into_owned());
        for effect in effects {
            let first = effect.parameters.first().map_or(0.0, |parameter| parameter.value);
            let late = |values: &[f64]| match effect.form {
                Form::Delay => Some(delayed(values, time_s, first)),
                _ => None,
            };
            if effect.form == Form::CreepOfInput {
                creep(&mut input, time_s, &signals.creep_s, &effect.parameters);
            } else if let Some(regulator) = regulator::valve(effect) {
                let start = input.first().copied().unwrap_or(0.0);
                input = regulator.simulate(start, time_s, &input);
                // About as fast as that: a width needs no more.
                speed = if needs_speed { low_pass(&speed, time_s, first.exp()) } else { speed };
            } else if let Some(values) = late(&input) {
                input = values;
                speed = late(&speed).filter(|_| needs_speed).unwrap_or(speed);
            }
        }
        Self { input: signals.kept(&input), speed: signals.kept(&speed) }
    }
}

/// The input and its speed where it is never above a ceiling.
fn below<'a>(ceiling: f64, input: &'a [f64], speed: &'a [f64]) -> (Cow<'a, [f64]>, Cow<'a, [f64]>) {
    if ceiling == f64::INFINITY {
        return (Cow::Borrowed(input), Cow::Borrowed(speed));
    }
    let moves = input.iter().zip(speed).map(|(input, speed)| if *input < ceiling { *speed } else { 0.0 });
    (input.iter().map(|input| input.min(ceiling)).collect(), moves.collect())
}

/// Slow parts of the input.
fn creep(input: &mut [f64], time_s: &[f64], creep_s: &[f64], weights: &[Parameter]) {
    let before = input.to_vec();
    for (weight, tau_s) in weights.iter().zip(creep_s).filter(|(weight, _)| weight.value > 0.0) {
        let slow = low_pass(&before, time_s, *tau_s);
        for ((u, slow), now) in input.iter_mut().zip(slow).zip(&before) {
            *u += weight.value * (slow - now);
        }
    }
}

/// The input on its way to the operators.
#[derive(Clone, Debug)]
pub struct Stages {
    arrived: Arrived,
    /// Less what acts as a force.
    forced: Vec<f64>,
    /// The power that a width rises with, and what it makes of the speed of every row; empty without such a width.
    power: f64,
    faster: Vec<f64>,
    /// Less what the widths add: what the operators see.
    pub seen: Seen,
}

impl Stages {
    /// The input under these effects, one of which at most is a width that depends on a rate.
    pub fn new(signals: &Signals, effects: &[Effect]) -> Self {
        let arrived = Arrived::new(signals, effects);
        let forced = forced(signals, effects, &arrived.input);
        let (power, faster) = powers(signals, effects, &arrived.speed);
        let seen = widened(signals, effects, &faster, forced.clone());
        Self { arrived, forced, power, faster, seen }
    }

    /// What the operators see if the effect `changed` is as it stands in `effects`, and the others are as they were; None
    /// if that is no other than before.
    pub fn with(&self, signals: &Signals, effects: &[Effect], changed: usize) -> Option<Seen> {
        let effect = &effects[changed];
        match effect.form {
            Form::SecondOrder | Form::Orifice | Form::Delay | Form::Ceiling | Form::CreepOfInput => {
                Some(Self::new(signals, effects).seen)
            }
            Form::Driven(_) | Form::Inertia => {
                let forced = forced(signals, effects, &self.arrived.input);
                Some(widened(signals, effects, &self.faster, forced))
            }
            Form::Friction(_) | Form::Thresholds(_) if effect.parameters[0].value != self.power => {
                let (_, faster) = powers(signals, effects, &self.arrived.speed);
                Some(widened(signals, effects, &faster, self.forced.clone()))
            }
            Form::Width | Form::Friction(_) | Form::Thresholds(_) => {
                Some(widened(signals, effects, &self.faster, self.forced.clone()))
            }
            Form::Envelope => Some(Seen { bend: bend(effects), ..self.seen.clone() }),
            _ => None,
        }
    }
}

/// The input less what acts as a force.
fn forced(signals: &Signals, effects: &[Effect], arrived: &[f64]) -> Vec<f64> {
    let mut input = arrived.to_vec();
    effects.iter().for_each(|effect| push(&mut input, signals, effect));
    input
}

/// The power of the width that depends on a rate, and the speed of every row to it.
fn powers(signals: &Signals, effects: &[Effect], arrived: &[f64]) -> (f64, Vec<f64>) {
    let of_effect = |effect: &Effect| {
        let (Form::Thresholds(rate) | Form::Friction(rate)) = effect.form else { return None };
        let speeds = if rate == Rate::Input { arrived } else { signals.speed_of(rate) };
        let power = effect.parameters[0].value;
        Some((power, speeds.iter().map(|&speed| faster(signals, rate, power, speed)).collect()))
    };
    effects.iter().find_map(of_effect).unwrap_or_default()
}

/// Takes an effect that acts as a force off the input.
fn push(input: &mut [f64], signals: &Signals, effect: &Effect) {
    let parameters = &effect.parameters;
    match effect.form {
        Form::Driven(driver) => {
            let shapes = parameters.len() - TENTS;
            let lambda = parameters[0].value.exp();
            subtract(input, &signals.tents, &parameters[shapes..], |at| driven(signals, driver, lambda, at));
        }
        Form::Inertia => {
            let tents = &signals.moving_tents;
            subtract(input, tents, &parameters[..TENTS], |at| signals.acceleration[at]);
            subtract(input, tents, &parameters[TENTS..], |at| signals.rate[at]);
        }
        _ => {}
    }
}

/// The widths come last: they need what the operators see.
fn widened(signals: &Signals, effects: &[Effect], faster: &[f64], mut input: Vec<f64>) -> Seen {
    let thresholds = effects.iter().find(|effect| matches!(effect.form, Form::Thresholds(_)));
    let wider: Vec<f64> = thresholds.map_or_else(Vec::new, |thresholds| {
        let gain = thresholds.parameters[1].value;
        faster.iter().map(|faster| 1.0 + gain * faster).collect()
    });
    for effect in effects {
        match (effect.form, Friction::of(effect)) {
            (Form::Width, Some(friction)) => friction.resist(&mut input, signals, &wider),
            (_, Some(friction)) => friction.resist(&mut input, signals, faster),
            _ => {}
        }
    }
    Seen { input, wider, bend: bend(effects) }
}

/// The bend of the envelope.
pub fn bend(effects: &[Effect]) -> f64 {
    let envelope = effects.iter().find(|effect| effect.form == Form::Envelope);
    envelope.map_or(0.0, |effect| effect.parameters[0].value)
}

/// What thresholds that follow this rate are multiplied by at a speed.
pub fn wider(signals: &Signals, thresholds: &Effect, rate: Rate, speed: f64) -> f64 {
    let [power, gain] = [0, 1].map(|i: usize| thresholds.parameters[i].value);
    1.0 + gain * faster(signals, rate, power, speed)
}

/// A speed, as a multiple of its typical value, to a power.
pub fn faster(signals: &Signals, rate: Rate, power: f64, speed: f64) -> f64 {
    (speed.abs() / signals.typical_speed(rate)).powf(power)
}

/// Takes `tents times strengths times driver` off.
fn subtract(
    input: &mut [f64],
    tents: &[[f64; TENTS]],
    strengths: &[Parameter],
    driver: impl Fn(usize) -> f64,
) {
    if strengths.iter().all(|strength| strength.value == 0.0) {
        return;
    }
    let strengths: [f64; TENTS] = std::array::from_fn(|tent| strengths[tent].value);
    for (at, (u, tents)) in input.iter_mut().zip(tents).enumerate() {
        *u -= through(tents, &strengths) * driver(at);
    }
}

/// The strength of an effect where the tents have these weights.
pub fn through(tents: &[f64; TENTS], strengths: &[f64; TENTS]) -> f64 {
    tents.iter().zip(strengths).map(|(tent, strength)| tent * strength).sum()
}

/// A width: a stop of the operators' input that resists it.
#[derive(Clone, Copy, Debug)]
pub struct Friction {
    /// Of the equivalent input, over the stop; one a tent.
    strengths: [f64; TENTS],
    /// The stop's range to either side. Input unit.
    pub range: f64,
}

impl Friction {
    /// That of an effect, if it is one that has any strength.
    pub fn of(effect: &Effect) -> Option<Self> {
        if !matches!(effect.form, Form::Width | Form::Friction(_)) {
            return None;
        }
        let strengths = std::array::from_fn(|tent| effect.parameters[2 + tent].value);
        (strengths != [0.0; TENTS]).then(|| Self { strengths, range: effect.parameters[1].value.exp() })
    }

    /// The equivalent input over the stop at a row.
    pub fn slope(&self, signals: &Signals, at: usize) -> f64 {
        through(&signals.tents[at], &self.strengths)
    }

    /// Takes off what it adds, row by row, the range times `times`; empty for 1.
    fn resist(&self, input: &mut [f64], signals: &Signals, times: &[f64]) {
        // What the row before had: the stop, the input over it, the input before this friction was taken off.
        let (mut stop, mut stiffness, mut wanted) = (0.0, 1.0, input.first().copied().unwrap_or(0.0));
        for (at, u) in input.iter_mut().enumerate() {
            let range = self.range * times.get(at).copied().unwrap_or(1.0);
            let slope = self.slope(signals, at);
            // Inside the range stop = before + u - last and u + slope stop = wanted; else it is at its end.
            let less = 1.0 / (1.0 + slope);
            let moved = stop * (stiffness * less) + (*u - wanted) * less;
            let below = if moved > range { range } else { moved };
            stop = if below < -range { -range } else { below };
            (stiffness, wanted) = (1.0 + slope, *u);
            *u -= slope * stop;
        }
    }
}
