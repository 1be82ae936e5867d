//! The inverse of the paper's model, and the control law around it, for a firmware that knows its
//! model's kind and size when it is compiled, and does not choose them at run time: what that saves
//! is counted beside the board's ([`firmware::law`]).

use model_core::cascade::InverseCascade;
use model_core::envelope::{PiecewiseLinear, TanhEnvelope};
use model_core::law::{Law, LawState};
use model_core::paper::SIZE;
use model_core::{HysteresisState, InputError, InverseHysteresis};

/// Knots of the piecewise-linear envelope.
const KNOTS: usize = 8;

/// The inverse with one kind of envelope.
type Inverse<E> = InverseCascade<f32, E, SIZE, SIZE>;
/// Its state.
type State = HysteresisState<f32, SIZE>;

/// One sample of the inverse with the paper's envelope. Reference: mm; result: bar.
///
/// # Errors
/// The reference is not finite; the state is then as it was.
#[inline(never)]
pub fn tanh_step(
    inverse: &Inverse<TanhEnvelope<f32>>,
    state: &mut State,
    reference_mm: f32,
) -> Result<f32, InputError> {
    inverse.step(state, reference_mm)
}

/// The same with a piecewise-linear envelope.
///
/// # Errors
/// The reference is not finite; the state is then as it was.
#[inline(never)]
pub fn piecewise_step(
    inverse: &Inverse<PiecewiseLinear<f32, KNOTS>>,
    state: &mut State,
    reference_mm: f32,
) -> Result<f32, InputError> {
    inverse.step(state, reference_mm)
}

/// One sample of the control law with the paper's envelope. Reference and contraction: mm; result:
/// bar.
///
/// # Errors
/// A value that is not finite; the state is then as it was.
#[inline(never)]
pub fn law_step(
    law: &Law<f32, Inverse<TanhEnvelope<f32>>>,
    state: &mut LawState<f32, SIZE>,
    reference_mm: f32,
    contraction_mm: f32,
) -> Result<f32, InputError> {
    law.step(state, reference_mm, contraction_mm)
}
