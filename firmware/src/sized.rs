//! The inverse of the paper's model for a firmware that knows its model's kind and size when it is compiled, and does not
//! choose them at run time: what that saves is counted beside the board's ([`crate::law`]).

use model_core::cascade::{Cascade, InverseCascade};
use model_core::envelope::{Envelope, PiecewiseLinear, TanhEnvelope};
use model_core::paper::SIZE;
use model_core::{
    HysteresisState, InputError, InverseHysteresis, Invertible, MgpiParameters, ParameterError, paper,
};

use crate::law::{MEASURED_KNOTS, measured_knots};

/// The inverse with one kind of envelope.
pub type Inverse<E> = InverseCascade<f32, E, SIZE, SIZE>;
/// Its state.
pub type State = HysteresisState<f32, SIZE>;

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
    pub fn paper(piecewise: bool) -> Result<Self, ParameterError> {
        let model = paper::mgpi()?.convert()?;
        Ok(if piecewise {
            let (inverse, state) = at_rest(PiecewiseLinear::try_new(&measured_knots(&model)?)?, &model)?;
            Self::Piecewise(inverse, state)
        } else {
            let (inverse, state) = at_rest(TanhEnvelope::try_new(paper::ENVELOPE.convert())?, &model)?;
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
