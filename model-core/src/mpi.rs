//! Kuhnen's modified Prandtl-Ishlinskii model (MPI): linear plays, then dead zones on both sides
//! of 0.
//!
//! y = offset + Σ wⱼ S(u, dⱼ) with u = q x + Σ pᵢ zᵢ: the memoryless stage bends the classical
//! loop, so that it need not be symmetric. The thresholds d may have either sign; each side of 0 is
//! a chain of its own, and the weights of the inverse, equation (20), hold per side. Forward and
//! inverse are those of the [`crate::cascade`], without an envelope.

use crate::cascade::CascadeParameters;
use crate::dead_zone::DeadZoneParameters;
use crate::envelope::EnvelopeParameters;
use crate::play::PlayParameters;

/// The parameters of an MPI model. Thresholds of plays and dead zones: input unit; weights of the
/// dead zones: output unit per input unit; input: lower and upper end of the valid inputs, input
/// unit. The muscle comes from rest.
///
/// ```
/// use model_core::envelope::EnvelopeParameters;
/// use model_core::{Kind, ModelParameters, mpi, paper};
///
/// let muscle = paper::mgpi()?;
/// let linear = mpi::parameters(muscle.plays, muscle.dead_zones, (0.0, 6.0));
/// assert_eq!(linear.envelope, EnvelopeParameters::Identity);
/// assert_eq!(ModelParameters::Cascade(linear).kind(), Kind::Mpi);
/// # Ok::<(), Box<dyn core::error::Error>>(())
/// ```
pub fn parameters<T, const N: usize, const M: usize>(
    plays: PlayParameters<T, N>,
    dead_zones: DeadZoneParameters<T, M>,
    input: (T, T),
) -> CascadeParameters<T, N, M> {
    let envelope = EnvelopeParameters::Identity;
    CascadeParameters {
        envelope,
        plays,
        dead_zones,
        input_min: input.0,
        input_max: input.1,
        preconditioned: false,
    }
}
