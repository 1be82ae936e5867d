//! The control law as functions that are never inlined, so that what they cost can be counted in
//! the images.

use model_core::adaptation::Adapted;
use model_core::tracking::{Command, Prepared};
use model_core::{InputError, Mode, Surroundings, TrackingState};
use wire::{BoardTracking, PLAYS};

/// The first half of a sample of the controller, which is the inverse of the extended model.
/// What it is asked for, and the reference: mm.
///
/// # Errors
/// A value that is not finite; the state is then as it was.
#[inline(never)]
pub fn controller_prepare(
    tracking: &BoardTracking,
    state: &mut TrackingState<f32, PLAYS>,
    asked_and_reference_mm: (f32, f32),
    surroundings: &Surroundings<f32>,
) -> Result<Prepared<f32>, InputError> {
    tracking.prepare_asked(state, asked_and_reference_mm, surroundings)
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

/// What the inverse is asked for in the place of the reference, by what has been learnt of the
/// muscle. Unit: mm.
#[inline(never)]
pub fn controller_asked(tracking: &BoardTracking, adapted: &mut Adapted<f32>, reference_mm: f32) -> f32 {
    tracking.asked(adapted, reference_mm)
}

/// Learns from a tick.
#[inline(never)]
pub fn controller_learn(
    tracking: &BoardTracking,
    state: &TrackingState<f32, PLAYS>,
    prepared: &Prepared<f32>,
    is_trusted: bool,
    adapted: &mut Adapted<f32>,
) {
    tracking.learn(state, prepared, is_trusted, adapted);
}
