//! The inverse of the extended model: from a wanted contraction to the command, at a fixed period.
//!
//! ```text
//! wanted ─▶ drift⁻¹, tone⁻¹, creep⁻¹ ─▶ + what the effects take ─▶ y₀ ─▶ operator⁻¹ ─▶ u
//!      u ─▶ + what the effects take ─▶ creep⁻¹ ─▶ pressure ─▶ valve⁻¹ ─▶ command
//! ```
//!
//! Each step is explicit. What the inverse remembers is what can be reached: the operator's end
//! where the wanted contraction is beyond it, the pressure of a valve that got the limited command,
//! the creep of a limited pressure.
//!
//! # Delay
//! The answer acts a delay later. So the wanted contraction is that of the present plus the delay,
//! and drift and tone are taken off as they will be then.
//!
//! # Limits
//! The operator's inverse remembers the pressure that was wanted. A peak that the supply has cut is
//! so remembered too high, until it is wiped out.

use crate::error::{Check, InputError, ParameterError, finite_input};
use crate::hysteresis::{Hysteresis, HysteresisState, InverseHysteresis, Invertible};
use crate::model::{InverseModel, Model, ModelParameters};
use crate::range::Range;
use crate::real::Real;

use super::effects::{Effects, EffectsMemory, EffectsStep};
use super::transport_delay::TransportDelayParameters;
use super::{ExtensionParameters, Surroundings, each};

/// A validated inverse of an extended model of at most `N` plays and `M` dead zones.
///
/// ```
/// use model_core::{ExtendedInverse, ExtensionParameters, Hysteresis, Mgpi, ModelParameters, Surroundings};
///
/// let parameters = model_core::paper::mgpi()?;
/// let muscle = Mgpi::try_new(&parameters)?;
/// let (parameters, none) = (ModelParameters::Cascade(parameters), ExtensionParameters::default());
/// let inverse = ExtendedInverse::try_new(&parameters, &none, 0.001, (0.0, 6.0))?;
/// let (mut back, mut plant) = (inverse.rest_state(), muscle.rest_state());
/// for wanted in [20.0, 60.0, 35.0] {
///     let pressure = inverse.step(&mut back, wanted, &Surroundings::default())?;
///     assert!((muscle.step(&mut plant, pressure)? - wanted).abs() < 1e-9); // mm
/// }
/// # Ok::<(), Box<dyn core::error::Error>>(())
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct ExtendedInverse<T, const N: usize, const M: usize> {
    operator: InverseModel<T, N, M>,
    compensation: Option<Compensation<T>>,
    /// Of the operator's input.
    input_range: Range<T>,
    /// The operator's outputs at rest and at the upper end of its input range.
    output_range: (T, T),
    /// How long after its command the contraction comes. Unit: s.
    delay_s: T,
    limits: Range<T>,
}

/// What is done beside the operator's inverse.
#[derive(Clone, Debug, PartialEq)]
struct Compensation<T> {
    effects: Effects<T>,
    first: EffectsStep<T>,
    step: EffectsStep<T>,
}

/// What the inverse of an extended model remembers.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(
    feature = "serde",
    derive(serde::Serialize, serde::Deserialize),
    serde(bound = "T: Real + serde::Serialize + serde::de::DeserializeOwned")
)]
pub struct ExtendedInverseState<T, const N: usize> {
    /// That of the operator's inverse; where thresholds depend on the rate that of the operator
    /// itself.
    operator: HysteresisState<T, N>,
    /// None where nothing is compensated.
    compensation: Option<CompensationState<T>>,
}

#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(
    feature = "serde",
    derive(serde::Serialize, serde::Deserialize),
    serde(bound = "T: Real + serde::Serialize + serde::de::DeserializeOwned")
)]
struct CompensationState<T> {
    effects: EffectsMemory<T>,
    has_begun: bool,
}

impl<T: Real, const N: usize, const M: usize> ExtendedInverse<T, N, M> {
    /// `period_s`: time from sample to sample, s, above 0. `limits`: the commands that there are,
    /// input unit; only a compensated valve and creep of the pressure are held to them here.
    ///
    /// # Errors
    /// The first parameter that no inverse can be made of; a supply that is not above the lowest
    /// command.
    // Not inlined, for the sake of a board's stack.
    #[inline(never)]
    pub fn try_new(
        parameters: &ModelParameters<T, N, M>,
        extensions: &ExtensionParameters<T>,
        period_s: T,
        limits: (T, T),
    ) -> Result<Self, ParameterError> {
        let period_s = Check::new("period_s", "s").above(period_s, T::ZERO)?;
        let model = Model::try_new(parameters)?;
        let effects = Effects::try_new(&extensions.compensated(), &model)?;
        let delay_s = each(&extensions.transport_delay, TransportDelayParameters::checked)?;
        let highest = effects.valve.as_ref().map_or(limits.1, |valve| valve.supplied(limits.1));
        let limits = Range::try_new(limits.0, highest, "command range", "bar")?;
        let compensation =
            Compensation { first: effects.first(), step: effects.step(period_s, period_s), effects };
        Ok(Self {
            operator: model.inverse()?,
            compensation: (!compensation.effects.is_empty()).then_some(compensation),
            input_range: *model.input_range(),
            output_range: model.output_range(),
            delay_s: delay_s.unwrap_or(T::ZERO),
            limits,
        })
    }

    /// The operator's inverse.
    pub fn operator(&self) -> &InverseModel<T, N, M> {
        &self.operator
    }

    /// The operator's outputs at rest and, from there, at the upper end of its input range. Output
    /// unit.
    pub fn output_range(&self) -> (T, T) {
        self.output_range
    }

    /// The commands that act: those given, as far as the supply reaches. Input unit.
    pub fn limits(&self) -> &Range<T> {
        &self.limits
    }

    /// Where the operator stands: its input and output. `answer`: of the last sample, which is the
    /// input where nothing is compensated.
    pub(crate) fn stands(&self, state: &ExtendedInverseState<T, N>, answer: T) -> (T, T) {
        match &state.compensation {
            Some(CompensationState { effects, .. }) => (effects.u, effects.y0),
            None => (answer, self.operator.last_output(&state.operator)),
        }
    }

    /// The inputs that the operator's model is for.
    pub(crate) fn input_range(&self) -> &Range<T> {
        &self.input_range
    }

    /// The state before the first sample, of a muscle at rest.
    pub fn rest_state(&self) -> ExtendedInverseState<T, N> {
        let (u, (y0, _)) = (self.input_range.min(), self.output_range);
        let compensation = self.compensation.as_ref().map(|Compensation { effects, .. }| CompensationState {
            effects: effects.resting(u, y0, self.delay_s),
            has_begun: false,
        });
        let widens = self.compensation.as_ref().is_some_and(|all| all.effects.thresholds.is_some());
        let operator = match &self.operator {
            InverseModel::Cascade(cascade) if widens => cascade.forward().rest_state(),
            operator => operator.rest_state(),
        };
        ExtendedInverseState { operator, compensation }
    }

    /// One sample: the command that brings the contraction, a delay later, to `wanted`, or as near
    /// as the limits allow.
    ///
    /// # Errors
    /// A value that is not finite; the state is then as it was.
    #[inline(always)]
    pub fn step(
        &self,
        state: &mut ExtendedInverseState<T, N>,
        wanted: T,
        surroundings: &Surroundings<T>,
    ) -> Result<T, InputError> {
        match (&self.compensation, &mut state.compensation) {
            (Some(compensation), Some(memory)) => {
                self.compensated(compensation, &mut state.operator, memory, wanted, surroundings)
            }
            _ => self.operator.step(&mut state.operator, wanted),
        }
    }

    /// Not inlined, to avoid register spills where nothing is compensated.
    #[inline(never)]
    fn compensated(
        &self,
        compensation: &Compensation<T>,
        operator: &mut HysteresisState<T, N>,
        state: &mut CompensationState<T>,
        wanted: T,
        surroundings: &Surroundings<T>,
    ) -> Result<T, InputError> {
        let wanted = finite_input(wanted)?;
        if !surroundings.is_finite() {
            return Err(InputError::NotFinite);
        }
        let Compensation { effects, first, step, .. } = compensation;
        let step = if state.has_begun { step } else { first };
        state.has_begun = true;
        let EffectsMemory { valve, creep, felt, balance, rate, output, u: last_u, y0: last_y0 } =
            &mut state.effects;

        let mut operate = |y0: T| -> Result<(T, T), InputError> {
            if let (Some(thresholds), Some(step), InverseModel::Cascade(cascade)) =
                (&effects.thresholds, &step.thresholds, &self.operator)
            {
                let present = thresholds.at(step, *rate, cascade.forward().held_back(operator));
                let (u, reached) = cascade.reach_wider(operator, y0, present.times((y0, y0 - *last_y0)));
                *rate = present.rate(reached - *last_y0);
                return Ok((u, reached));
            }
            let u = self.operator.step(operator, y0)?;
            let is_end = u <= self.input_range.min() || u >= self.input_range.max();
            Ok((u, if is_end { self.operator.last_output(operator) } else { y0 }))
        };
        let (u, y0) = match (&effects.output, &step.output, output) {
            (Some(effects), Some(step), Some(memory)) => {
                let zero = effects.zero(step, memory);
                let aim = effects.aim(step, memory, wanted - zero, surroundings);
                let (u, y0) = operate(aim.y0)?;
                let last = memory.balanced();
                let (y1, balance) = aim.reached(last, y0);
                step.keep(memory, y1, y1 - last, balance);
                (u, y0)
            }
            _ => operate(wanted)?,
        };
        let (pushed, moved) = (u - *last_u, y0 - *last_y0);
        (*last_u, *last_y0) = (u, y0);

        let mut pressure = u;
        if let (Some(effects), Some(step)) = (&effects.balance, &step.balance) {
            let present = effects.at(step, balance, surroundings);
            pressure += present.value((u, pushed), (y0, moved));
            *balance = present.remembered((u, pushed), moved);
        }
        if let Some(step) = &step.creep {
            let wanted = *felt + step.moved(creep, *felt, pressure);
            pressure = self.limits.limit(wanted);
            step.keep(creep, pressure - *felt);
            *felt = pressure;
        }
        Ok(match &effects.valve {
            Some(effects) => effects.command(&step.valve, valve, pressure, &self.limits),
            None => pressure,
        })
    }
}
