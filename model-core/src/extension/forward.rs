//! The extended model, from command (or pressure) to contraction.
//!
//! # The root
//! The operator's input u is the root of F(u) = u + what the effects take at (u, operator(u)) - pressure. Where the operator
//! stands F is known without a step of it; from there the root lies in the direction of F's sign, and F rises at
//! least as fast as u where no effect falls with the contraction faster than the operator rises. The search tries steps
//! on a copy of the operator's state, usually two or three, to [`TOLERANCE`] of the input range. Where thresholds depend on the
//! rate each of these is a search in turn, for the thresholds ([`super::rate_dependent_thresholds`]).
//!
//! # Limits
//! A pressure beyond the input range by more than its span counts as one that is not, as in the family. A profile that
//! falls so steeply that there are several roots (a muscle that snaps through) is answered by one of them.

use crate::error::{InputError, ParameterError, finite_input};
use crate::hysteresis::{Hysteresis, HysteresisState};
use crate::model::{Model, ModelParameters};
use crate::real::Real;

use super::effects::{Effects, EffectsMemory, EffectsStep};
use super::rate_dependent_thresholds::PresentThresholds;
use super::root::{Point, root};
use super::transport_delay::{DelayLine, TransportDelayParameters};
use super::{ExtensionParameters, Surroundings, each};

/// How exactly the root is found: this share of the input range, as far as the number type allows.
pub const TOLERANCE: f64 = 1e-11;
/// The same of the factor that thresholds are wider by.
const WIDTH_TOLERANCE: f64 = 1e-9;
/// The shortest time between samples. Unit: s.
pub const SHORTEST_STEP_S: f64 = 1e-9;

/// What a model is given.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sample<T> {
    /// The command; for a model without a valve the pressure. Input unit.
    pub input: T,
    /// Load and temperature.
    pub surroundings: Surroundings<T>,
    /// Time since the sample before; that of the first one is not looked at. Unit: s.
    pub dt_s: T,
}

/// What a model answers.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Output<T> {
    /// The pressure behind the valve, before the delay. Input unit.
    pub pressure: T,
    /// Output unit.
    pub contraction: T,
}

/// A validated extended model of at most `N` plays and `M` dead zones.
#[derive(Clone, Debug, PartialEq)]
pub struct ExtendedModel<T, const N: usize, const M: usize> {
    model: Model<T, N, M>,
    effects: Effects<T>,
    /// Unit: s.
    delay_s: Option<T>,
    /// Of the root. Input unit.
    tolerance: T,
    /// Of that behind the operator. Output unit.
    output_tolerance: T,
}

/// What an extended model remembers.
#[derive(Clone, Debug, PartialEq)]
pub struct ExtendedState<T, const N: usize> {
    operator: HysteresisState<T, N>,
    /// Where steps are tried.
    trial: HysteresisState<T, N>,
    effects: EffectsMemory<T>,
    line: DelayLine<T>,
    /// The slope of F that the last search found, where the next one begins with.
    slope: T,
    /// Where they depend on the rate: how wide the thresholds were, and the slope there of the search for that.
    width: (T, T),
    /// The step of time that `step` is of, and the one before; none before the second sample.
    times: Option<(T, T)>,
    step: EffectsStep<T>,
    has_begun: bool,
}

impl<T: Real, const N: usize, const M: usize> ExtendedModel<T, N, M> {
    /// # Errors
    /// The first parameter that no model can be made of.
    pub fn try_new(
        parameters: &ModelParameters<T, N, M>,
        extensions: &ExtensionParameters<T>,
    ) -> Result<Self, ParameterError> {
        let model = Model::try_new(parameters)?;
        let extended = Self {
            effects: Effects::try_new(extensions, &model)?,
            delay_s: each(&extensions.transport_delay, TransportDelayParameters::checked)?,
            tolerance: T::ZERO,
            output_tolerance: T::ZERO,
            model,
        };
        Ok(extended.with_tolerance(T::from_f64(TOLERANCE)))
    }

    /// The same, its roots found to this share of the input range and of the output range instead of 1e-11, as far as the number
    /// type allows: for a search that runs many models, of each of which little is asked. Rates are differences of what is found: an
    /// answer is off by about as many times more as a lag has steps of time, for a mass by the square of that.
    pub fn with_tolerance(self, tolerance: T) -> Self {
        let tolerance = tolerance.at_least(T::from_f64(4.0) * T::EPSILON);
        let range = self.model.input_range();
        let (lowest, highest) = self.model.output_range();
        Self {
            tolerance: tolerance * (range.max() - range.min()),
            output_tolerance: tolerance * (highest - lowest),
            ..self
        }
    }

    /// The operator.
    pub fn operator(&self) -> &Model<T, N, M> {
        &self.model
    }

    /// The state before the first sample, of a muscle that came from rest to the lower end of the input range.
    pub fn rest_state(&self) -> ExtendedState<T, N> {
        let operator = self.model.rest_state();
        let u = self.model.input_range().min();
        // The ends of a range are finite: the step is not refused.
        let y0 = self.model.step(&mut operator.clone(), u).unwrap_or(T::ZERO);
        ExtendedState {
            trial: operator.clone(),
            operator,
            effects: self.effects.resting(u, y0, T::ZERO),
            line: DelayLine::new(),
            slope: T::ONE,
            width: (T::ONE, T::ONE),
            times: None,
            step: self.effects.first(),
            has_begun: false,
        }
    }

    /// One sample.
    ///
    /// # Errors
    /// A value that is not finite, a time step that is not finite or shorter than `SHORTEST_STEP_S` (1 ns), or more samples within
    /// the delay than it can hold; the state is then as it was.
    pub fn step(&self, state: &mut ExtendedState<T, N>, sample: &Sample<T>) -> Result<Output<T>, InputError> {
        let Sample { input, surroundings, dt_s } = *sample;
        let input = finite_input(input)?;
        if !surroundings.is_finite() {
            return Err(InputError::NotFinite);
        }
        let dt_s = if state.has_begun { later(dt_s)? } else { T::ZERO };
        if let Some(delay_s) = self.delay_s {
            state.line.make_room(delay_s, dt_s)?;
        }
        self.pass_time(state, dt_s);

        let pressure = match &self.effects.valve {
            Some(valve) => valve.pressure(&state.step.valve, &mut state.effects.valve, input),
            None => input,
        };
        let felt = match self.delay_s {
            Some(delay_s) => state.line.step(delay_s, dt_s, pressure),
            None => pressure,
        };
        let crept = self.creep(state, felt);
        self.operate(state, crept, &surroundings);
        Ok(Output { pressure, contraction: self.output(state, &surroundings) })
    }

    /// Makes the coefficients those of a step of `dt_s`, unless they are.
    fn pass_time(&self, state: &mut ExtendedState<T, N>, dt_s: T) {
        if state.has_begun {
            let times = (dt_s, state.times.map_or(dt_s, |(last_s, _)| last_s));
            if state.times != Some(times) {
                state.step = self.effects.step(times.0, times.1);
                state.times = Some(times);
            }
        }
        state.has_begun = true;
    }

    /// The pressure that the muscle follows at once.
    fn creep(&self, state: &mut ExtendedState<T, N>, felt: T) -> T {
        let EffectsMemory { creep: memory, felt: last, .. } = &mut state.effects;
        let Some(creep) = &state.step.creep else { return felt };
        let moved = felt - *last;
        let crept = creep.output(memory, felt, moved);
        creep.keep(memory, moved);
        *last = felt;
        crept
    }

    /// Drives the operator with a pressure.
    fn operate(&self, state: &mut ExtendedState<T, N>, pressure: T, surroundings: &Surroundings<T>) {
        let ExtendedState { operator, trial, effects, slope, width, step, .. } = state;
        let widening = match (&self.effects.thresholds, &step.thresholds, &self.model) {
            (Some(thresholds), Some(step), Model::Cascade(cascade)) => {
                Some((thresholds.at(step, effects.rate, cascade.held_back(operator)), cascade))
            }
            _ => None,
        };
        let (u0, y0) = (effects.u, effects.y0);
        if widening.is_none() && self.effects.balance.is_none() {
            effects.y0 = self.output_at(operator, pressure);
            return;
        }
        // Every try begins where the last sample has ended: what it answers does not depend on the tries before.
        let start = *width;
        let mut answer = |u| match &widening {
            Some((present, cascade)) => {
                let v = cascade.enveloped(u);
                *width = widened(present, start, y0, |times| cascade.output_wider(operator, v, times));
                trial.copy_from(operator);
                cascade.step_wider(trial, v, width.0)
            }
            None => {
                trial.copy_from(operator);
                self.output_at(trial, u)
            }
        };
        if let (Some(balance), Some(step)) = (&self.effects.balance, &step.balance) {
            let pressure = self.model.input_range().extrapolated(pressure);
            let present = balance.at(step, &effects.balance, surroundings);
            let mut over = |u| {
                effects.y0 = answer(u);
                u + present.value((u, u - u0), (effects.y0, effects.y0 - y0)) - pressure
            };
            // Where thresholds are as they were the operator stands where it stood.
            let stands = widening.is_none();
            let f =
                if stands { u0 + present.value((u0, T::ZERO), (y0, T::ZERO)) - pressure } else { over(u0) };
            let is_found = f.abs() <= self.tolerance;
            if !is_found {
                (effects.u, *slope) = root(Point { u: u0, f }, *slope, self.tolerance, over);
            }
            if !(is_found && stands) {
                operator.copy_from(trial);
            }
            effects.balance = present.remembered((effects.u, effects.u - u0), effects.y0 - y0);
        } else {
            effects.y0 = answer(pressure);
            operator.copy_from(trial);
        }
        if let Some((present, _)) = &widening {
            effects.rate = present.rate(effects.y0 - y0);
        }
    }

    /// A step of the operator, whose input is finite.
    fn output_at(&self, operator: &mut HysteresisState<T, N>, u: T) -> T {
        self.model.step(operator, u).unwrap_or(T::ZERO)
    }

    /// The contraction where the operator's output is.
    fn output(&self, state: &mut ExtendedState<T, N>, surroundings: &Surroundings<T>) -> T {
        let EffectsMemory { output: memory, y0, .. } = &mut state.effects;
        match (&self.effects.output, &state.step.output, memory) {
            (Some(output), Some(step), Some(memory)) => {
                let tolerance = self.output_tolerance;
                let contraction = output.contraction(step, memory, *y0, surroundings, tolerance);
                contraction + output.zero(step, memory)
            }
            _ => *y0,
        }
    }
}

/// How wide the thresholds of an operator are, at `y0` before, that are as wide as its `answer` says, and the slope there of the
/// search for that, which begins with such a pair.
fn widened<T: Real>(
    present: &PresentThresholds<'_, T>,
    (start, slope): (T, T),
    y0: T,
    answer: impl Fn(T) -> T,
) -> (T, T) {
    let over = |times| {
        let y = answer(times);
        times - present.times((y, y - y0))
    };
    let tolerance = T::from_f64(WIDTH_TOLERANCE).at_least(T::from_f64(4.0) * T::EPSILON);
    let f = over(start);
    if f.abs() <= tolerance {
        return (start, slope);
    }
    root(Point { u: start, f }, slope, tolerance, over)
}

/// A time step that time passes in.
fn later<T: Real>(dt_s: T) -> Result<T, InputError> {
    if finite_input(dt_s)? >= T::from_f64(SHORTEST_STEP_S) { Ok(dt_s) } else { Err(InputError::NotLater) }
}
