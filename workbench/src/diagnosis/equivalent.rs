//! What the operators see: the input after the lags on its way, less what acts on the muscle as a force.

use super::basis::Seen;
use super::effect::{Effect, Form, Parameter, Rate};
use super::output::{driven, low_pass};
use super::signals::{Signals, TENTS};

/// What arrives at the muscle.
#[derive(Clone, Debug)]
pub struct Arrived {
    /// The input after the lags, delays and creep on its way.
    pub input: Vec<f64>,
    /// How fast that moves. Unit: input unit/s.
    pub speed: Vec<f64>,
}

impl Arrived {
    /// The input under these effects.
    pub fn new(signals: &Signals, effects: &[Effect]) -> Self {
        let mut input = signals.input.clone();
        let mut speed = signals.speed_of(Rate::Input).to_vec();
        let needs_speed = effects.iter().any(|effect| effect.form == Form::Thresholds(Rate::Input));
        for effect in effects {
            let first = effect.parameters.first().map_or(0.0, |parameter| parameter.value);
            let late = |values: &[f64]| match effect.form {
                Form::Lag => Some(low_pass(values, &signals.time_s, first.exp())),
                Form::Delay => Some(delayed(values, &signals.time_s, first)),
                _ => None,
            };
            if effect.form == Form::CreepOfInput {
                creep(&mut input, signals, &effect.parameters);
            } else if let Some(values) = late(&input) {
                input = values;
                speed = late(&speed).filter(|_| needs_speed).unwrap_or(speed);
            }
        }
        Self { input, speed }
    }
}

/// Slow parts of the input.
fn creep(input: &mut [f64], signals: &Signals, weights: &[Parameter]) {
    let before = input.to_vec();
    for (weight, tau_s) in weights.iter().zip(&signals.creep_s).filter(|(weight, _)| weight.value > 0.0) {
        let slow = low_pass(&before, &signals.time_s, *tau_s);
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
    /// Less what the widths add: what the operators see.
    pub seen: Seen,
}

impl Stages {
    /// The input under these effects.
    pub fn new(signals: &Signals, effects: &[Effect]) -> Self {
        Self::from_arrived(signals, effects, Arrived::new(signals, effects))
    }

    fn from_arrived(signals: &Signals, effects: &[Effect], arrived: Arrived) -> Self {
        let mut forced = arrived.input.clone();
        for effect in effects {
            push(&mut forced, signals, effect);
        }
        let seen = widened(signals, effects, &arrived.speed, forced.clone());
        Self { arrived, forced, seen }
    }

    /// What the operators see if the effect `changed` is as it stands in `effects`, and the others are as they were.
    pub fn with(&self, signals: &Signals, effects: &[Effect], changed: usize) -> Seen {
        match effects[changed].form {
            Form::Lag | Form::Delay | Form::CreepOfInput => Self::new(signals, effects).seen,
            Form::Driven(_) | Form::Inertia => {
                Self::from_arrived(signals, effects, self.arrived.clone()).seen
            }
            Form::Width | Form::Friction(_) | Form::Thresholds(_) => {
                widened(signals, effects, &self.arrived.speed, self.forced.clone())
            }
            Form::Envelope => Seen { bend: bend(effects), ..self.seen.clone() },
            _ => self.seen.clone(),
        }
    }
}

/// Takes an effect that acts as a force off the input.
fn push(input: &mut [f64], signals: &Signals, effect: &Effect) {
    let parameters = &effect.parameters;
    match effect.form {
        Form::Driven(driver) => {
            let shapes = parameters.len() - TENTS;
            let lambda = parameters[0].value.exp();
            subtract(input, signals, &parameters[shapes..], |at| driven(signals, driver, lambda, at));
        }
        Form::Inertia => {
            subtract(input, signals, &parameters[..TENTS], |at| signals.acceleration[at]);
            subtract(input, signals, &parameters[TENTS..], |at| signals.rate[at]);
        }
        _ => {}
    }
}

/// The widths come last: they need what the operators see.
fn widened(signals: &Signals, effects: &[Effect], arrived: &[f64], mut input: Vec<f64>) -> Seen {
    let contraction = signals.speed_of(Rate::Contraction);
    let of_effect = |effect: &Effect| {
        let Form::Thresholds(rate) = effect.form else { return None };
        let speed = if rate == Rate::Input { arrived } else { contraction };
        Some(speed.iter().map(|&speed| wider(signals, effect, rate, speed)).collect())
    };
    let wider: Vec<f64> = effects.iter().find_map(of_effect).unwrap_or_default();
    for effect in effects.iter().filter(|effect| matches!(effect.form, Form::Width | Form::Friction(_))) {
        if effect.parameters[2..].iter().any(|strength| strength.value != 0.0) {
            let of_row = |at: usize| {
                let wider = wider.get(at).copied().unwrap_or(1.0);
                Friction::of(signals, effect, at, wider, contraction[at])
            };
            resist(&mut input, of_row);
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
fn faster(signals: &Signals, rate: Rate, power: f64, speed: f64) -> f64 {
    (speed.abs() / signals.typical_speed(rate)).powf(power)
}

/// Takes `tents times strengths times driver` off.
fn subtract(input: &mut [f64], signals: &Signals, strengths: &[Parameter], driver: impl Fn(usize) -> f64) {
    if strengths.iter().all(|strength| strength.value == 0.0) {
        return;
    }
    for (at, u) in input.iter_mut().enumerate() {
        *u -= strength(signals, strengths, at) * driver(at);
    }
}

/// The strength of an effect at the contraction of a row.
pub fn strength(signals: &Signals, strengths: &[Parameter], at: usize) -> f64 {
    signals.tents[at].iter().zip(strengths).map(|(tent, strength)| tent * strength.value).sum()
}

/// What a width is at a row.
#[derive(Clone, Copy, Debug)]
pub struct Friction {
    /// Of the equivalent input, over the stop.
    pub slope: f64,
    /// The stop's range to either side. Input unit.
    pub range: f64,
}

impl Friction {
    /// That of an effect, if it is one, where the thresholds are `wider` and the contraction is so fast. Unit: output
    /// unit/s.
    pub fn of(signals: &Signals, effect: &Effect, at: usize, wider: f64, speed: f64) -> Option<Self> {
        let times = match effect.form {
            Form::Width => wider,
            Form::Friction(rate) => faster(signals, rate, effect.parameters[0].value, speed),
            _ => return None,
        };
        let range = effect.parameters[1].value.exp() * times;
        Some(Self { slope: strength(signals, &effect.parameters[2..], at), range })
    }

    /// The stop after a step of the input to `wanted`, less what the friction adds, from the stop and the input before.
    pub fn stop(&self, wanted: f64, stop: f64, last: f64) -> f64 {
        // Inside the range stop = before + u - last and u + slope stop = wanted; else it is at its end.
        ((stop + wanted - last) / (1.0 + self.slope)).clamp(-self.range, self.range)
    }
}

/// Takes off what a width adds, sample by sample.
fn resist(input: &mut [f64], friction: impl Fn(usize) -> Option<Friction>) {
    let mut stop = 0.0;
    let mut last = input.first().copied().unwrap_or(0.0);
    for (at, u) in input.iter_mut().enumerate() {
        if let Some(friction) = friction(at) {
            stop = friction.stop(*u, stop, last);
            last = *u - friction.slope * stop;
            *u = last;
        }
    }
}

/// The values later by `delay_s`, straight between rows.
pub fn delayed(values: &[f64], time_s: &[f64], delay_s: f64) -> Vec<f64> {
    let mut right = 0;
    time_s
        .iter()
        .map(|time| {
            let wanted = time - delay_s;
            while right < time_s.len() && time_s[right] < wanted {
                right += 1;
            }
            match (right.checked_sub(1), values.get(right)) {
                (Some(left), Some(&after)) => {
                    let share = (wanted - time_s[left]) / (time_s[right] - time_s[left]);
                    values[left] + (after - values[left]) * share
                }
                (None, Some(&first)) => first,
                (_, None) => values.last().copied().unwrap_or(0.0),
            }
        })
        .collect()
}
