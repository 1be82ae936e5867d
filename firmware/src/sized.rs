//! The inverse of the paper's model, and the control law around it, for a firmware that knows its model's kind and size when
//! it is compiled, and does not choose them at run time: what that saves is counted beside the board's ([`crate::law`]).

use model_core::cascade::{Cascade, InverseCascade};
use model_core::envelope::{Envelope, PiecewiseLinear, TanhEnvelope};
use model_core::law::{Law, LawParameters, LawState};
use model_core::paper::SIZE;
use model_core::pid::PidParameters;
use model_core::{
    HysteresisState, InputError, InverseHysteresis, Invertible, MgpiParameters, ParameterError, paper,
};

use crate::law::{MEASURED_KNOTS, MEASURED_PERIOD_S, MEASURED_SLEW_BAR_PER_S, measured_knots};

/// The inverse with one kind of envelope.
pub type Inverse<E> = InverseCascade<f32, E, SIZE, SIZE>;
/// Its state.
pub type State = HysteresisState<f32, SIZE>;

/// The control law with the paper's envelope.
pub type SizedLaw = Law<f32, Inverse<TanhEnvelope<f32>>>;
/// Its state.
pub type SizedLawState = LawState<f32, SIZE>;

/// The inverse with one of the envelopes that are measured, and its state.
#[derive(Clone, Debug, PartialEq)]
// One at a time is measured, and there is no heap.
#[allow(clippy::large_enum_variant)]
pub enum SizedInverse {
    /// The paper's.
    Tanh(Inverse<TanhEnvelope<f32>>, State),
    /// A piecewise-linear one.
    Piecewise(Inverse<PiecewiseLinear<f32, MEASURED_KNOTS>>, State),
}

impl SizedInverse {
    /// The paper's model with its envelope, or with a piecewise-linear one, at rest.
    ///
    /// # Errors
    /// None in practice, see [`paper::mgpi`].
    // Inlined it would add its temporaries to the caller's stack for good.
    #[inline(never)]
    pub fn paper(piecewise: bool) -> Result<Self, ParameterError> {
        let model = paper::mgpi()?.convert()?;
        Ok(if piecewise {
            let (inverse, state) = at_rest(PiecewiseLinear::try_new(&measured_knots(&model)?)?, &model)?;
            Self::Piecewise(inverse, state)
        } else {
            let (inverse, state) = at_rest(paper_envelope()?, &model)?;
            Self::Tanh(inverse, state)
        })
    }

    /// One sample. Reference: mm; result: bar.
    ///
    /// # Errors
    /// The reference is not finite; the state is then as it was.
    pub fn step(&mut self, reference_mm: f32) -> Result<f32, InputError> {
        match self {
            Self::Tanh(inverse, state) => tanh_step(inverse, state, reference_mm),
            Self::Piecewise(inverse, state) => piecewise_step(inverse, state, reference_mm),
        }
    }
}

/// The control law of the paper's model and gains on a proportional valve, at the board's tick, for a muscle at rest.
///
/// # Errors
/// None in practice, see [`paper::mgpi`].
// Inlined it would add its temporaries to the caller's stack for good.
#[inline(never)]
pub fn paper_law() -> Result<(SizedLaw, SizedLawState), ParameterError> {
    let model = paper::mgpi()?.convert()?;
    let parameters = LawParameters {
        pid: PidParameters::paper(),
        command_min: model.input_min,
        command_max: model.input_max,
        slew_bar_per_s: MEASURED_SLEW_BAR_PER_S,
        period_s: MEASURED_PERIOD_S,
    };
    let (inverse, _) = at_rest(paper_envelope()?, &model)?;
    let law = Law::try_new(inverse, &parameters)?;
    let state = law.rest_state(0.0);
    Ok((law, state))
}

fn paper_envelope() -> Result<TanhEnvelope<f32>, ParameterError> {
    TanhEnvelope::try_new(paper::ENVELOPE.convert())
}

fn at_rest<E: Envelope<f32> + Clone>(
    envelope: E,
    model: &MgpiParameters<f32, SIZE, SIZE>,
) -> Result<(Inverse<E>, State), ParameterError> {
    let inverse = Cascade::with_envelope(envelope, model)?.inverse()?;
    let state = inverse.rest_state();
    Ok((inverse, state))
}

/// [`SizedInverse::step`] with the paper's envelope.
#[inline(never)]
fn tanh_step(
    inverse: &Inverse<TanhEnvelope<f32>>,
    state: &mut State,
    reference_mm: f32,
) -> Result<f32, InputError> {
    inverse.step(state, reference_mm)
}

/// [`SizedInverse::step`] with a piecewise-linear envelope.
#[inline(never)]
fn piecewise_step(
    inverse: &Inverse<PiecewiseLinear<f32, MEASURED_KNOTS>>,
    state: &mut State,
    reference_mm: f32,
) -> Result<f32, InputError> {
    inverse.step(state, reference_mm)
}

/// One sample of the control law. Reference and contraction: mm; result: bar.
///
/// # Errors
/// A value that is not finite; the state is then as it was.
#[inline(never)]
pub fn law_step(
    law: &SizedLaw,
    state: &mut SizedLawState,
    reference_mm: f32,
    contraction_mm: f32,
) -> Result<f32, InputError> {
    law.step(state, reference_mm, contraction_mm)
}
