//! What the operators see: the input after the lags on its way, less what acts on the muscle as a force.

use super::basis::Seen;
use super::effect::{Effect, Form, Parameter, Rate};
use super::output::{driven, low_pass};
use super::signals::{Signals, TENTS};

/// The input after the lags, delays and creep on its way.
pub fn travelled_input(signals: &Signals, effects: &[Effect]) -> Vec<f64> {
    let mut input = signals.input.clone();
    for effect in effects {
        let first = effect.parameters.first().map_or(0.0, |parameter| parameter.value);
        match effect.form {
            Form::Lag => input = low_pass(&input, &signals.time_s, first.exp()),
            Form::Delay => input = delayed(&input, &signals.time_s, first),
            Form::CreepOfInput => {
                let before = input.clone();
                for (weight, tau_s) in effect.parameters.iter().zip(&signals.creep_s) {
                    if weight.value > 0.0 {
                        let slow = low_pass(&before, &signals.time_s, *tau_s);
                        for ((u, slow), now) in input.iter_mut().zip(slow).zip(&before) {
                            *u += weight.value * (slow - now);
                        }
                    }
                }
            }
            _ => {}
        }
    }
    input
}

/// The input on its way to the operators.
#[derive(Clone, Debug)]
pub struct Stages {
    /// After lags, delays and creep.
    travelled: Vec<f64>,
    /// Less what acts as a force.
    forced: Vec<f64>,
    /// Less what the widths add: what the operators see.
    pub seen: Seen,
}

impl Stages {
    /// The input under these effects.
    pub fn new(signals: &Signals, effects: &[Effect]) -> Self {
        Self::from_travelled(signals, effects, travelled_input(signals, effects))
    }

    fn from_travelled(signals: &Signals, effects: &[Effect], travelled: Vec<f64>) -> Self {
        let mut forced = travelled.clone();
        for effect in effects {
            push(&mut forced, signals, effect);
        }
        let seen = widened(signals, effects, forced.clone());
        Self { travelled, forced, seen }
    }

    /// What the operators see if the effect `changed` is as it stands in `effects`, and the others are as they were.
    pub fn with(&self, signals: &Signals, effects: &[Effect], changed: usize) -> Seen {
        match effects[changed].form {
            Form::Lag | Form::Delay | Form::CreepOfInput => Self::new(signals, effects).seen,
            Form::Driven(_) | Form::Inertia => {
                Self::from_travelled(signals, effects, self.travelled.clone()).seen
            }
            Form::Width | Form::Friction(_) | Form::Thresholds(_) => {
                widened(signals, effects, self.forced.clone())
            }
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
fn widened(signals: &Signals, effects: &[Effect], mut input: Vec<f64>) -> Seen {
    let wider = match effects.iter().find(|effect| wider(signals, effect, 0, None).is_some()) {
        Some(effect) => (0..input.len()).filter_map(|at| wider(signals, effect, at, None)).collect(),
        None => Vec::new(),
    };
    for effect in effects.iter().filter(|effect| matches!(effect.form, Form::Width | Form::Friction(_))) {
        if effect.parameters[2..].iter().any(|strength| strength.value != 0.0) {
            let of_row = |at| {
                let wider = wider.get(at).copied().unwrap_or(1.0);
                Friction::of(signals, effect, at, wider, None)
            };
            let friction: Option<Vec<Friction>> = (0..input.len()).map(of_row).collect();
            friction.iter().for_each(|friction| resist(&mut input, friction));
        }
    }
    Seen { input, wider }
}

/// What an effect multiplies the thresholds by. `speed` stands for the measured rate of the contraction. Unit: output
/// unit/s.
pub fn wider(signals: &Signals, effect: &Effect, at: usize, speed: Option<f64>) -> Option<f64> {
    let Form::Thresholds(rate) = effect.form else { return None };
    Some(1.0 + effect.parameters[1].value * faster(signals, rate, effect.parameters[0].value, at, speed))
}

/// A rate, as a multiple of its typical value, to a power.
fn faster(signals: &Signals, rate: Rate, power: f64, at: usize, speed: Option<f64>) -> f64 {
    let speed = match (rate, speed) {
        (Rate::Contraction, Some(speed)) => speed,
        _ => signals.speed_of(rate)[at],
    };
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
    /// That of an effect, if it is one, where the thresholds are `wider`. `speed` stands for the measured rate of the
    /// contraction. Unit: output unit/s.
    pub fn of(signals: &Signals, effect: &Effect, at: usize, wider: f64, speed: Option<f64>) -> Option<Self> {
        let times = match effect.form {
            Form::Width => wider,
            Form::Friction(rate) => faster(signals, rate, effect.parameters[0].value, at, speed),
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
fn resist(input: &mut [f64], friction: &[Friction]) {
    let mut stop = 0.0;
    let mut last = input.first().copied().unwrap_or(0.0);
    for (u, friction) in input.iter_mut().zip(friction) {
        stop = friction.stop(*u, stop, last);
        last = *u - friction.slope * stop;
        *u = last;
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
