//! From the search's coordinates and linear coefficients to the raw parameters of a model.

use model_core::agpi::AgpiParameters;
use model_core::dead_zone::DeadZoneParameters;
use model_core::egpi::EgpiParameters;
use model_core::envelope::EnvelopeParameters;
use model_core::memoryless::MemorylessParameters;
use model_core::play::PlayParameters;
use model_core::{Kind, ParameterError, cpi, mgpi::MgpiParameters, mpi, sgpi};

use super::inner::Inner;
use super::plays::Plays;
use super::projection::{Grid, Linear};
use super::row::Span;
use super::structure::Structure;
use super::{DEAD_ZONES, Density, HostParameters, PLAYS, Weights};

/// The raw parameters, and the density that those of the plays come from.
///
/// # Errors
/// The numbers of operators are above the capacity.
pub fn parameters(
    structure: &Structure,
    inner: &Inner,
    grid: &Grid,
    linear: &Linear,
    span: Span,
) -> Result<(HostParameters, Density), ParameterError> {
    let (rising, falling) = inner.envelope.raw(span);
    // Without an envelope the inner coordinate is the input itself, not its share of the span.
    let scale = if rising == EnvelopeParameters::Identity { span.1 } else { 1.0 };
    let (density, plays) = density(structure, &inner.plays, scale)?;
    let (gain, offset) = (linear.slopes[0] / scale, linear.offset - linear.slopes[0] * grid.origin);
    let input = (span.0, span.0 + span.1);
    let parameters = match structure.kind {
        Kind::Cpi => HostParameters::Cascade(cpi::parameters(plays, gain, offset, input)?),
        Kind::Sgpi => HostParameters::Cascade(sgpi::parameters(rising, plays, gain, offset, input)?),
        Kind::Mpi => HostParameters::Cascade(mpi::parameters(plays, dead_zones(grid, linear, scale), input)),
        Kind::Mgpi => HostParameters::Cascade(MgpiParameters {
            envelope: rising,
            plays,
            dead_zones: dead_zones(grid, linear, scale),
            input_min: input.0,
            input_max: input.1,
            preconditioned: false,
        }),
        Kind::Agpi => HostParameters::Agpi(asymmetric((rising, falling), plays, (gain, offset), input)),
        Kind::Egpi => {
            let mut rises = [0.0; 3];
            rises.copy_from_slice(&linear.rises);
            HostParameters::Egpi(EgpiParameters {
                agpi: asymmetric((rising, falling), plays, (gain, offset), input),
                memoryless: MemorylessParameters { rises },
            })
        }
    };
    Ok((parameters, density))
}

/// The raw parameters of the plays and what they come from; `scale` is the inner coordinate of 1.
fn density(
    structure: &Structure,
    plays: &Plays,
    scale: f64,
) -> Result<(Density, PlayParameters<f64, PLAYS>), ParameterError> {
    let alpha = plays.alpha * scale;
    match structure.weights {
        Weights::Exponential => {
            let (rho, beta) = plays.rho_and_beta();
            let (tau, count) = (beta / alpha, structure.plays);
            let parameters = PlayParameters::exponential(count, plays.q, rho, tau, alpha)?;
            Ok((Density::Exponential { rho, tau, alpha }, parameters))
        }
        Weights::Free => {
            let parameters = PlayParameters {
                q: plays.q,
                thresholds: plays.thresholds.iter().map(|r| r * scale).collect(),
                weights: plays.weights.iter().copied().collect(),
            };
            Ok((Density::Free { alpha }, parameters))
        }
    }
}

fn asymmetric(
    (rising, falling): (EnvelopeParameters<f64>, EnvelopeParameters<f64>),
    plays: PlayParameters<f64, PLAYS>,
    (gain, offset): (f64, f64),
    (input_min, input_max): (f64, f64),
) -> AgpiParameters<f64, PLAYS> {
    AgpiParameters { rising, falling, plays, gain, offset, input_min, input_max, preconditioned: false }
}

/// The segments as dead zones: one of threshold 0, whose weight is the slope there, and one at each
/// knot, whose weight is the change of the slope, seen from 0.
fn dead_zones(grid: &Grid, linear: &Linear, scale: f64) -> DeadZoneParameters<f64, DEAD_ZONES> {
    let Grid { count, origin, width } = *grid;
    let home = (((-origin / width).max(0.0)) as usize).min(count - 1);
    let mut zones: Vec<(f64, f64)> = vec![(0.0, linear.slopes[home])];
    for (j, slopes) in linear.slopes.windows(2).enumerate() {
        let change = slopes[1] - slopes[0];
        zones.push((origin + (j + 1) as f64 * width, if j < home { -change } else { change }));
    }
    zones.sort_by(|(one, _), (other, _)| one.total_cmp(other));
    let passed: f64 = linear.slopes[..home].iter().sum::<f64>() * width;
    let way = -origin - home as f64 * width;
    DeadZoneParameters {
        thresholds: zones.iter().map(|(threshold, _)| threshold * scale).collect(),
        weights: zones.iter().map(|(_, weight)| weight / scale).collect(),
        offset: linear.offset + passed + linear.slopes[home] * way,
    }
}
