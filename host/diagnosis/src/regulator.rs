//! What the regulator does to its command, where the command alone was recorded.
//!
//! Every pressure comes through a regulator, and a lag as short as any regulator has ([`ORDINARY_LAG_S`]) is nothing that is wrong. So where
//! the input is the command, that lag belongs to the baseline as its envelope does: it is fitted beside every set of causes, and a cause is
//! named for what it explains beside it. It is of the second order, or that of air through an orifice, as regulators are.
//!
//! # Limits
//! A delay, a viscous force or a lag of the muscle that is as short as that is not told from it, and not named.

use super::command::Command;
use super::effect::{Effect, Form, Parameter};
use super::valve::{BEFORE, BEGUN, DAMPING, ORDINARY_LAG_S, Orifice, Valve};

/// The shortest lag that is looked for, in steps of the recording: of a shorter one less than 1 % of a jump (exp(-5)) is left at the next
/// sample. Unit: 1.
pub const LEAST_LAG: f64 = 0.2;

/// Regulators of each form that are so late, between these. Unit: s.
pub fn so_late(command: Command, late_s: f64, (low_s, high_s): (f64, f64)) -> Vec<Effect> {
    let lag = Parameter::logarithm(late_s, low_s, high_s);
    let damping = Parameter::logarithm(1.0, DAMPING.0, DAMPING.1);
    let of_orifice = |outside: f64| {
        let least = outside + command.highest;
        let before = Parameter::new(BEGUN * least, least, BEFORE * least, 1e-3 * least);
        Effect::new(Form::Orifice, [lag, before, Parameter::new(outside, outside, outside, 1.0)])
    };
    let of_second_order = Effect::new(Form::SecondOrder, [lag, damping]);
    [of_second_order].into_iter().chain(command.outside.map(of_orifice)).collect()
}

/// Those that any regulator may be; none where rows `step_s` apart show no such lag.
pub fn ordinary(command: Command, step_s: f64) -> Vec<Effect> {
    let (low_s, begin_s) = (LEAST_LAG * step_s, 0.5 * ORDINARY_LAG_S);
    if low_s < begin_s { so_late(command, begin_s, (low_s, ORDINARY_LAG_S)) } else { Vec::new() }
}

/// The regulator of these effects, if there is one: an ordinary one, or that of a cause.
pub fn of(effects: &[Effect]) -> Option<Valve> {
    effects.iter().find_map(valve)
}

/// What an effect makes of the input if it is a regulator.
pub fn valve(effect: &Effect) -> Option<Valve> {
    let value = |place: usize| effect.parameters.get(place).map(|parameter| parameter.value);
    let slow = Valve::slow(value(0)?.exp());
    match effect.form {
        Form::SecondOrder => Some(Valve { damping_ratio: Some(value(1)?.exp()), ..slow }),
        Form::Orifice => {
            Some(Valve { orifice: Some(Orifice { supply: value(1)?, outside: value(2)? }), ..slow })
        }
        _ => None,
    }
}
