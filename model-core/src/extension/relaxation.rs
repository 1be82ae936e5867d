//! First-order relaxation over a step of time, exactly.

use crate::real::Real;

/// 1 - exp(-dt/time_constant): the share of its way that a first-order lag goes. All of it after an
/// endless step.
///
/// In double precision, since a step is a small part of a long time constant; on the board this is
/// done once.
pub(super) fn share<T: Real>(dt: T, time_constant: T) -> T {
    T::from_f64(-libm::expm1(-dt.to_f64() / time_constant.to_f64()))
}

/// The mean of exp(-t/time_constant) over the step: what is left of a way that is gone evenly
/// during it. Nothing after an endless step.
pub(super) fn mean<T: Real>(dt: T, time_constant: T) -> T {
    let steps = dt.to_f64() / time_constant.to_f64();
    T::from_f64(-libm::expm1(-steps) / steps)
}
