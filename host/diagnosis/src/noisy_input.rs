//! Noise of the measured input, which a model takes for movement.
//!
//! Plays rectify it: the longer the input rests, the farther its noise has pushed them, which looks like creep; and what it pushes
//! through looks like a viscous lag that is missing. So where it is the larger part of what a perfect model would be off by, the
//! operators are driven by the input smoothed. What is written is judged on the input as measured: that is what will drive it.

use std::borrow::Cow;

use super::Columns;
use crate::smoothing::{Smoothed, smoothed};
use recording::noise;
use recording::numbers::quantiles;

/// The input is smoothed where its noise, passed on by the mean slope, is so many times that of the output: then four fifths of the
/// squared error of a perfect model come from it.
const TIMES: f64 = 2.0;
/// The share of samples that lie beyond either end of what the mean slope is taken over.
const ENDS: f64 = 0.02;

/// How an input was smoothed. Unit: that of the input.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Smoothing {
    /// Standard deviation of its noise, as measured.
    pub noise: f64,
    /// What is left of it.
    pub left: f64,
}

impl Columns {
    /// The columns with the input smoothed, where its noise would pass for movement. Noise below the sensor's step is none.
    pub fn with_smooth_input(mut self) -> Self {
        let floor = noise::floor(&self.time_s, &self.input);
        let ends = |values: &[f64]| {
            let (low, high) = quantiles(values, ENDS);
            high - low
        };
        let passed_on = floor.deviation * ends(&self.output) / ends(&self.input).max(f64::MIN_POSITIVE);
        if floor.deviation > floor.quantum && passed_on > TIMES * self.noise_floor().deviation {
            let Smoothed { values, error } = smoothed(&self.input, floor.deviation);
            self.measured_input = Some(std::mem::replace(&mut self.input, values));
            self.smoothing = Some(Smoothing { noise: floor.deviation, left: error });
        }
        self
    }

    /// The columns with the input as it was measured.
    pub fn as_measured(&self) -> Cow<'_, Self> {
        match &self.measured_input {
            None => Cow::Borrowed(self),
            Some(input) => Cow::Owned(Self {
                input: input.clone(),
                measured_input: None,
                smoothing: None,
                ..self.clone()
            }),
        }
    }

    /// The noise of the input. Input unit.
    pub(super) fn input_noise(&self) -> f64 {
        let measured = || noise::floor(&self.time_s, &self.input).deviation;
        self.smoothing.map_or_else(measured, |smoothing| smoothing.left)
    }
}
