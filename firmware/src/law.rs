//! The control law as functions that are never inlined, so that what they cost can be counted in
//! the images.

use model_core::tracking::{Command, Prepared};
use model_core::{InputError, Mode, Surroundings, TrackingState};
use wire::{BoardTracking, PLAYS};

/// The first half of a sample of the controller, which is the inverse of the extended model.
/// Reference: mm.
///
/// # Errors
/// A value that is not finite; the state is then as it was.
#[inline(never)]
pub fn controller_prepare(
    tracking: &BoardTracking,
    state: &mut TrackingState<f32, PLAYS>,
    reference_mm: f32,
    surroundings: &Surroundings<f32>,
) -> Result<Prepared<f32>, InputError> {
    tracking.prepare(state, reference_mm, surroundings)
}

/// The second half: PID, slew and limits. Contraction: mm.
///
/// # Errors
/// The contraction is not finite; the last command is then as it was.
#[inline(never)]
pub fn controller_act(
    tracking: &BoardTracking,
    state: &mut TrackingState<f32, PLAYS>,
    mode: Mode,
    prepared: Prepared<f32>,
    contraction_mm: f32,
) -> Result<Command<f32>, InputError> {
    tracking.act(state, mode, prepared, contraction_mm)
}
