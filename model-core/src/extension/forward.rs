//! The extended model, from command (or pressure) to contraction.
//!
//! # The root
//! The operator's input u is the root of F(u) = u + what the effects take at (u, operator(u)) -
//! pressure. Where the operator stands F is known without a step of it; from there the root lies in
//! the direction of F's sign, and F rises at least as fast as u where no effect falls with the
//! contraction faster than the operator rises. The search tries steps on a copy of the operator's
//! state, usually two or three, to [`TOLERANCE`] of the input range.
//!
//! Where thresholds depend on the rate ([`super::rate_dependent_thresholds`]) they are known with y
//! alone, and so is, by the same balance, u: the root is then that of G(y) = y - operator(u) at
//! these thresholds, to [`TOLERANCE`] of the output range. G rises at least as fast as y for the
//! same reason, and since a wider bank moves less. Thresholds by the rate of the pressure are known
//! before, and the root is that of F.
//!
//! # Limits
//! A pressure beyond the input range by more than its span counts as one that is not, as in the
//! family. A profile that falls so steeply that there are several roots (a muscle that snaps
//! through) is answered by one of them.

use crate::cascade::Cascade;
use crate::envelope::AnyEnvelope;
use crate::error::{InputError, ParameterError, finite_input};
use crate::hysteresis::{Hysteresis, HysteresisState};
use crate::model::{Model, ModelParameters};
use crate::real::Real;

use super::balance::Balance;
use super::effects::{Effects, EffectsMemory, EffectsStep};
use super::rate_dependent_thresholds::RateDependentThresholds;
use super::root::{Point, root};
use super::transport_delay::{DelayLine, TransportDelayParameters};
use super::{ExtensionParameters, Surroundings, each};

/// How exactly the root is found: this share of the input range, as far as the number type allows.
pub const TOLERANCE: f64 = 1e-11;
/// And to this share of that where a width before the operator depends on the rate as well: it
/// rises without bound where a move begins.
const NEARER: f64 = 1e-3;
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
///
/// ```
/// use model_core::extension::{ExtendedModel, ExtensionParameters, Sample, Surroundings, ValveLagParameters};
/// use model_core::ModelParameters;
///
/// let muscle = ModelParameters::Cascade(model_core::paper::mgpi()?);
/// let valve_lag = Some(ValveLagParameters::new(0.1));
/// let model = ExtendedModel::try_new(&muscle, &ExtensionParameters { valve_lag, ..Default::default() })?;
/// let mut state = model.rest_state();
/// let sample = |input, dt_s| Sample { input, surroundings: Surroundings::default(), dt_s };
/// model.step(&mut state, &sample(0.0, 0.1))?;
/// let pressure: f64 = model.step(&mut state, &sample(1.0, 0.1))?.pressure;
/// assert!(pressure > 0.0 && pressure < 1.0); // bar: the valve is still on its way
/// # Ok::<(), Box<dyn core::error::Error>>(())
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct ExtendedModel<T, const N: usize, const M: usize> {
    model: Model<T, N, M>,
    effects: Effects<T>,
    /// Unit: s.
    delay_s: Option<T>,
    /// Of the root. Input unit.
    tolerance: T,
    /// Of those of an output. Output unit.
    output_tolerance: T,
}

/// What an extended model remembers.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(
    feature = "serde",
    derive(serde::Serialize, serde::Deserialize),
    serde(bound = "T: Real + serde::Serialize + serde::de::DeserializeOwned")
)]
pub struct ExtendedState<T, const N: usize> {
    operator: HysteresisState<T, N>,
    /// Where steps are tried.
    trial: HysteresisState<T, N>,
    effects: EffectsMemory<T>,
    line: DelayLine<T>,
    /// The slope of F or G that the last search found, which the next one begins with.
    slope: T,
    /// How far the output moved then, where thresholds depend on the rate: from there the next one
    /// begins. Output unit.
    moved: T,
    /// The pressure whose rate widens thresholds, as it was seen last. Input unit.
    seen: T,
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

    /// The same, its roots found to this share of the input range and of the output range instead
    /// of 1e-11, as far as the number type allows: for a search that runs many models, of each of
    /// which little is asked. Rates are differences of what is found: an answer is off by about as
    /// many times more as a lag has steps of time, for a mass by the square of that.
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

    /// The state before the first sample, of a muscle that came from rest to the lower end of the
    /// input range.
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
            moved: T::ZERO,
            seen: u,
            times: None,
            step: self.effects.first(),
            has_begun: false,
        }
    }

    /// One sample.
    ///
    /// # Errors
    /// A value that is not finite, a time step that is not finite or shorter than `SHORTEST_STEP_S`
    /// (1 ns), or more samples within the delay than it can hold; the state is then as it was.
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
        let pressure = self.model.input_range().extrapolated(pressure);
        let wider = match (&self.effects.thresholds, &self.model) {
            (Some(thresholds), Model::Cascade(cascade)) => match times(thresholds, state, pressure) {
                Some(times) => Some((cascade, times)),
                None => return self.operate_wider(state, (thresholds, cascade), pressure, surroundings),
            },
            _ => None,
        };
        let output_at = |operator: &mut HysteresisState<T, N>, u| match wider {
            Some((cascade, times)) => cascade.step_wider(operator, cascade.enveloped(u), times),
            // Its input is finite.
            None => self.model.step(operator, u).unwrap_or(T::ZERO),
        };
        let ExtendedState { operator, trial, effects, slope, step, .. } = state;
        let (Some(balance), Some(step)) = (&self.effects.balance, &step.balance) else {
            effects.y0 = output_at(operator, pressure);
            return;
        };
        let (u0, y0) = (effects.u, effects.y0);
        let present = balance.at(step, &effects.balance, surroundings);
        let mut over = |u| {
            trial.copy_from(operator);
            effects.y0 = output_at(trial, u);
            u + present.value((u, u - u0), (effects.y0, effects.y0 - y0)) - pressure
        };
        // Where nothing moves the operator stands where it stood, unless its thresholds change.
        let f = match wider {
            Some(_) => over(u0),
            None => u0 + present.value((u0, T::ZERO), (y0, T::ZERO)) - pressure,
        };
        let moves = f.abs() > self.tolerance;
        if moves {
            (effects.u, *slope) = root(Point { u: u0, f }, *slope, self.tolerance, over);
        }
        if moves || wider.is_some() {
            operator.copy_from(trial);
        }
        effects.balance = present.remembered((effects.u, effects.u - u0), effects.y0 - y0);
    }

    /// The same where thresholds depend on the rate of the contraction.
    fn operate_wider(
        &self,
        state: &mut ExtendedState<T, N>,
        (thresholds, cascade): (&RateDependentThresholds<T>, &Cascade<T, AnyEnvelope<T>, N, M>),
        pressure: T,
        surroundings: &Surroundings<T>,
    ) {
        let ExtendedState { operator, trial, effects, slope, moved: last, step, .. } = state;
        let Some(sliding) = &step.thresholds else { return };
        let EffectsMemory { balance: memory, u, y0: y, rate, .. } = effects;
        let (u0, y0) = (*u, *y);
        let balance = self.effects.balance.as_ref().zip(step.balance.as_ref());
        let present = balance.map(|(balance, step)| balance.at(step, memory, surroundings));
        let is_wider_before = self.effects.balance.as_ref().is_some_and(Balance::widens);
        let nearer = if is_wider_before { T::from_f64(NEARER) } else { T::ONE };
        let tolerance = self.output_tolerance * nearer;
        let thresholds = thresholds.at(sliding, *rate, cascade.held_back(operator));
        let rest = |moved| match &present {
            Some(present) => present.rest(pressure, u0, moved, self.tolerance),
            None => pressure,
        };
        let mut over = |y| {
            let moved = (y, y - y0);
            *u = rest(moved);
            trial.copy_from(operator);
            y - cascade.step_wider(trial, cascade.enveloped(*u), thresholds.times(moved))
        };
        *y = y0 + *last;
        let f = over(*y);
        if f.abs() > tolerance {
            // Where G rises steeply the operator is as far from y as G from 0.
            let tolerance = tolerance / slope.at_least(T::ONE);
            (*y, *slope) = root(Point { u: *y, f }, *slope, tolerance, over);
        }
        operator.copy_from(trial);
        *last = *y - y0;
        *rate = thresholds.rate(*last);
        if let Some(remembered) = present.map(|present| present.remembered((*u, *u - u0), *last)) {
            effects.balance = remembered;
        }
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

/// By how much thresholds are wider at a pressure, whose rate is then known; None where it does not
/// count for them.
fn times<T: Real, const N: usize>(
    thresholds: &RateDependentThresholds<T>,
    state: &mut ExtendedState<T, N>,
    pressure: T,
) -> Option<T> {
    let step = state.step.thresholds.as_ref()?;
    let (rate, seen, times) = thresholds.at_pressure(step, (state.effects.rate, state.seen), pressure)?;
    (state.effects.rate, state.seen) = (rate, seen);
    Some(times)
}

/// A time step that time passes in.
fn later<T: Real>(dt_s: T) -> Result<T, InputError> {
    if finite_input(dt_s)? >= T::from_f64(SHORTEST_STEP_S) { Ok(dt_s) } else { Err(InputError::NotLater) }
}
