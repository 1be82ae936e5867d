//! The classical Prandtl-Ishlinskii model (CPI): linear plays and a gain.
//!
//! y = offset + gain (q x + Σ pᵢ zᵢ), the plays driven by the input itself. Its loops are convex
//! and symmetric about their centre; that of a muscle is neither, which is what the rest of the
//! family is for. Forward and inverse are those of the [`crate::cascade`], without an envelope and
//! with a single dead zone.

use crate::cascade::CascadeParameters;
use crate::dead_zone::DeadZoneParameters;
use crate::envelope::EnvelopeParameters;
use crate::error::ParameterError;
use crate::play::PlayParameters;
use crate::real::Real;

/// The parameters of a CPI model. Thresholds of the plays: input unit; gain: output unit per input
/// unit; offset: output unit; input: lower and upper end of the valid inputs, input unit. The
/// muscle comes from rest.
///
/// # Errors
/// The capacity `M` is 0.
///
/// ```
/// use model_core::play::PlayParameters;
/// use model_core::{Kind, ModelParameters, cpi};
///
/// let plays = PlayParameters::<f64, 4>::exponential(4, 0.3, 0.2, 1.0, 0.5)?;
/// let classical = cpi::parameters::<f64, 4, 1>(plays, 20.0, 0.0, (0.0, 6.0))?;
/// assert_eq!(ModelParameters::Cascade(classical).kind(), Kind::Cpi);
/// # Ok::<(), Box<dyn core::error::Error>>(())
/// ```
pub fn parameters<T: Real, const N: usize, const M: usize>(
    plays: PlayParameters<T, N>,
    gain: T,
    offset: T,
    input: (T, T),
) -> Result<CascadeParameters<T, N, M>, ParameterError> {
    Ok(CascadeParameters {
        envelope: EnvelopeParameters::Identity,
        plays,
        dead_zones: DeadZoneParameters::line(gain, offset)?,
        input_min: input.0,
        input_max: input.1,
        preconditioned: false,
    })
}
