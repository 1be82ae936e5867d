//! What the regulator does to its command, where the command alone was recorded.
//!
//! Every pressure comes through a regulator, and a lag as short as any regulator has ([`ORDINARY_LAG_S`]) is nothing that is wrong. So where
//! the input is the command, that lag belongs to the baseline as its envelope does: it is fitted beside every set of causes, and a cause is
//! named for what it explains beside it. It is of the second order, or that of air through an orifice, as regulators are.
//!
//! # Limits
//! A delay, a viscous force or a lag of the muscle that is as short as that is not told from it, and not named.

use rayon::prelude::*;

use super::Columns;
use super::candidate::Candidate;
use super::causes::Cause;
use super::effect::{Effect, Form, Parameter};
use super::rivals::differ_less_than_misfit;
use super::search::Search;
use super::valve::{BEFORE, BEGUN, DAMPING, ORDINARY_LAG_S, Orifice, Valve, ValvePart, outside};
use recording::numbers::range;

/// The shortest lag that is looked for, in steps of the recording: a shorter one is over before the next sample.
pub const LEAST_LAG: f64 = 0.2;

/// The longest dead time of a regulator's own: half of what its lags and that may be together. A choice. Unit: s.
pub const LONGEST_DELAY_S: f64 = 0.5 * ORDINARY_LAG_S;

/// What is known of a command.
#[derive(Clone, Copy, Debug)]
pub struct Command {
    /// The highest. Input unit.
    highest: f64,
    /// The atmosphere's pressure; None where the command is no pressure. Input unit.
    outside: Option<f64>,
}

impl Command {
    /// That of a recording; None where its input is the pressure.
    pub fn of(columns: &Columns) -> Option<Self> {
        let highest = range(&columns.input).1;
        columns.input_is_command.then(|| Self { highest, outside: outside(columns.input_unit) })
    }

    /// Regulators of each form that are so late, between these. Unit: s.
    pub fn regulators(&self, late_s: f64, (low_s, high_s): (f64, f64)) -> Vec<Effect> {
        let lag = Parameter::logarithm(late_s, low_s, high_s);
        let damping = Parameter::logarithm(1.0, DAMPING.0, DAMPING.1);
        let of_orifice = |outside: f64| {
            let least = outside + self.highest;
            let before = Parameter::new(BEGUN * least, least, BEFORE * least, 1e-3 * least);
            Effect::new(Form::Orifice, [lag, before, Parameter::new(outside, outside, outside, 1.0)])
        };
        let of_second_order = Effect::new(Form::SecondOrder, [lag, damping]);
        [of_second_order].into_iter().chain(self.outside.map(of_orifice)).collect()
    }

    /// Those that any regulator may be; none where rows `step_s` apart show no such lag.
    pub fn ordinary(&self, step_s: f64) -> Vec<Effect> {
        let (low_s, begin_s) = (LEAST_LAG * step_s, 0.5 * ORDINARY_LAG_S);
        if low_s < begin_s { self.regulators(begin_s, (low_s, ORDINARY_LAG_S)) } else { Vec::new() }
    }
}

/// The regulator of these effects, if there is one: an ordinary one, or that of a cause.
pub fn of(effects: &[Effect]) -> Option<Valve> {
    effects.iter().find_map(valve)
}

/// The dead time of these effects. Unit: s.
pub fn delay_s(effects: &[Effect]) -> f64 {
    effects.iter().filter(|effect| effect.form == Form::Delay).map(Effect::late_s).sum()
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

/// Sets with the valve's lag in the place of a fast cause, or with a fast one in the place of that, which explain a recording of the command
/// as well within the misfit of the set. A regulator has a form of its own, which nobody has seen: what is late by it may be late in the muscle.
pub fn alike(search: &Search<'_>, set: &Candidate, sizes: &[Vec<Candidate>]) -> Vec<Vec<Cause>> {
    let is_lag = |cause: &Cause| matches!(cause.about().in_valve, Some((ValvePart::Lag, _)));
    let is_new = |cause: &Cause| !set.causes.contains(cause);
    let others = |own: Cause| {
        let takes_place = move |cause: &Cause| if is_lag(&own) { cause.is_fast() } else { is_lag(cause) };
        search.examinable.iter().copied().filter(is_new).filter(takes_place)
    };
    let own = set.causes.iter().copied().filter(|cause| cause.is_fast() || is_lag(cause));
    let pairs: Vec<(Cause, Cause)> = own.flat_map(|own| others(own).map(move |other| (own, other))).collect();
    let exchanged = pairs.into_par_iter().filter_map(|(own, other)| {
        let rival = search.with(&search.without(set, own, sizes)?, other, sizes)?;
        let is_untold = rival.shows()
            && rival.outlasts()
            && differ_less_than_misfit(set.score.mean(), rival.score.mean(), search.signals.noise);
        is_untold.then(|| rival.names())
    });
    exchanged.collect()
}
