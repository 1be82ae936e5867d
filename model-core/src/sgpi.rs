//! The symmetric generalized Prandtl-Ishlinskii model (SGPI): one envelope, plays and a gain.
//!
//! y = offset + gain (q γ(x) + Σ pᵢ zᵢ), equation (6) with γ_r = γ_l = γ. The envelope lets the
//! loop saturate; over γ(x) it is as symmetric as that of the classical model. Forward and inverse
//! are those of the [`crate::cascade`], with a single dead zone.

use crate::cascade::CascadeParameters;
use crate::dead_zone::DeadZoneParameters;
use crate::envelope::EnvelopeParameters;
use crate::error::ParameterError;
use crate::play::PlayParameters;
use crate::real::Real;

/// The parameters of an SGPI model. Thresholds of the plays: unit 1; gain and offset: output unit;
/// input: lower and upper end of the valid inputs, input unit. The muscle comes from rest.
///
/// # Errors
/// The capacity `M` is 0.
///
/// ```
/// use model_core::envelope::EnvelopeParameters::Tanh;
/// use model_core::{Kind, ModelParameters, paper, sgpi};
///
/// let plays = paper::mgpi()?.plays;
/// let symmetric = sgpi::parameters::<f64, 10, 1>(Tanh(paper::ENVELOPE), plays, 50.0, 0.0, (0.0, 6.0))?;
/// assert_eq!(ModelParameters::Cascade(symmetric).kind(), Kind::Sgpi);
/// # Ok::<(), Box<dyn core::error::Error>>(())
/// ```
pub fn parameters<T: Real, const N: usize, const M: usize>(
    envelope: EnvelopeParameters<T>,
    plays: PlayParameters<T, N>,
    gain: T,
    offset: T,
    input: (T, T),
) -> Result<CascadeParameters<T, N, M>, ParameterError> {
    let dead_zones = DeadZoneParameters::line(gain, offset)?;
    Ok(CascadeParameters {
        envelope,
        plays,
        dead_zones,
        input_min: input.0,
        input_max: input.1,
        preconditioned: false,
    })
}
