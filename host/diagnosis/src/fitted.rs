//! A cause's effect in a set as it was fitted: what the cause reads its parameters from.
//!
//! An equivalent input becomes a change of contraction by the slope of the fitted loop, where it slides: at mid stroke, or where the
//! effect's tents stand.

use std::cell::OnceCell;

use super::basis::Basis;
use super::effect::{Effect, Form};
use super::fit::Fit;
use super::regulator;
use super::series;
use super::signals::{Signals, TENTS, hats};
use super::turn::Loop;
use super::valve::Valve;

/// A parameter's name, unit included, and its value.
pub type Parameters = Vec<(&'static str, f64)>;

/// The parameter of a name, if there is one.
pub fn value(parameters: &[(&'static str, f64)], wanted: &str) -> Option<f64> {
    parameters.iter().find(|(name, _)| *name == wanted).map(|(_, value)| *value)
}

/// What speaks against a cause in a set that it was fitted in.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Doubt {
    /// The motion that it names does not show: it stands for something else that comes late, or slowly.
    Unseen,
    /// What it names is not in the recording.
    Absent,
    /// It does not show by itself at the time that it names, only in what it makes of all that comes before and after.
    Faint,
    /// It is over long before the longest hold ends: the tail of a faster effect.
    Over,
    /// It takes strokes away with travel instead of bringing them.
    Fading,
}

/// A fitted set; its loop is made once, where somebody asks for it.
pub struct FittedSet<'a> {
    signals: &'a Signals,
    basis: &'a Basis,
    fit: &'a Fit,
    turn: OnceCell<Loop>,
}

impl<'a> FittedSet<'a> {
    /// Of a fit.
    pub fn new(signals: &'a Signals, basis: &'a Basis, fit: &'a Fit) -> Self {
        Self { signals, basis, fit, turn: OnceCell::new() }
    }

    /// The effect at a place of the fit.
    pub fn effect(&self, place: usize) -> Fitted<'_> {
        Fitted { weights: series::weights(self.fit, self.signals, place), ..self.as_fitted(place) }
    }

    /// The same with the weights as they were fitted, of a lag before a mass those of the polynomial that they are together.
    pub fn as_fitted(&self, place: usize) -> Fitted<'_> {
        let weights = self.fit.output_weights(self.signals, place).to_vec();
        Fitted { set: self, signals: self.signals, effect: &self.fit.effects[place], weights }
    }
}

/// An effect of a fitted set.
pub struct Fitted<'a> {
    set: &'a FittedSet<'a>,
    /// The recording.
    pub signals: &'a Signals,
    /// The effect.
    pub effect: &'a Effect,
    /// The weights of its columns on the output; of a lag before a mass each its own.
    pub weights: Vec<f64>,
}

impl Fitted<'_> {
    /// What it does.
    pub fn form(&self) -> Form {
        self.effect.form
    }

    /// The regulator before it, where the input is the command.
    pub fn regulator(&self) -> Option<Valve> {
        regulator::of(&self.set.fit.effects)
    }

    /// What the set leaves, a value a scored row. Output unit.
    pub fn residual(&self) -> &[f64] {
        &self.set.fit.residual
    }

    /// A parameter of it; 0 where it has not so many.
    pub fn parameter(&self, place: usize) -> f64 {
        self.effect.parameters.get(place).map_or(0.0, |parameter| parameter.value)
    }

    /// A weight of it; 0 where it has not so many.
    pub fn weight(&self, place: usize) -> f64 {
        self.weights.get(place).copied().unwrap_or(0.0)
    }

    /// The strength at mid stroke, of the parameters from the `first` on, one a tent.
    pub fn at_middle(&self, first: usize) -> f64 {
        self.in_middle(|tent| self.parameter(first + tent))
    }

    /// The same of weights.
    pub fn weight_at_middle(&self, first: usize) -> f64 {
        self.in_middle(|tent| self.weight(first + tent))
    }

    /// The slope of the loop at mid stroke. Unit: output unit/input unit.
    pub fn slope(&self) -> f64 {
        self.turn().slope(self.middle())
    }

    /// Half the width of the loop at mid stroke. Input unit.
    pub fn half_width(&self) -> f64 {
        self.turn().half_width(self.middle())
    }

    /// The change of the output at the tents, per unit of what drives it.
    pub fn changes(&self) -> [f64; TENTS] {
        std::array::from_fn(|tent| match self.form() {
            Form::Added(_) => self.weight(tent),
            _ => {
                let first = self.effect.parameters.len() - TENTS;
                -self.parameter(first + tent) * self.turn().slope(self.signals.knots[tent])
            }
        })
    }

    /// The loop of the set.
    pub fn turn(&self) -> &Loop {
        self.set.turn.get_or_init(|| Loop::of(self.set.signals, self.set.basis, self.set.fit))
    }

    fn middle(&self) -> f64 {
        0.5 * (self.signals.knots[0] + self.signals.knots[TENTS - 1])
    }

    fn in_middle(&self, strength: impl Fn(usize) -> f64) -> f64 {
        let hats = hats(&self.signals.knots, self.middle());
        hats.iter().enumerate().map(|(tent, hat)| hat * strength(tent)).sum()
    }
}
