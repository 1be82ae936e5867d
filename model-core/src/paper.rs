//! The model that the paper identified: Tables 1 and 2.
//!
//! The input is in bar, the output in mm (the paper's contraction ratio times the 500 mm of its
//! muscle). Table 2 numbers its weights 1 to 10; they are j = 0 … 9 of equation (14), with dⱼ =
//! j/10 max(u): as j = 1 … 10 the weight w₀ of equation (20) would be 0. max(u) is taken over 0 to
//! 6 bar, the range of Fig. 8.

use crate::dead_zone::DeadZoneParameters;
use crate::envelope::{Envelope, EnvelopeParameters, TanhEnvelope, TanhParameters};
use crate::error::ParameterError;
use crate::list::List;
use crate::mgpi::MgpiParameters;
use crate::play::{PlayBank, PlayParameters};

/// Number of plays and of dead zones.
pub const SIZE: usize = 10;
/// Length of the paper's muscle, which turns a contraction ratio into a contraction. Unit: mm.
pub const MUSCLE_LENGTH_MM: f64 = 500.0;
/// The highest pressure of Fig. 8. Unit: bar.
pub const PRESSURE_MAX_BAR: f64 = 6.0;
/// Table 1: c0, c1 (1/bar), c2, c3.
pub const ENVELOPE: TanhParameters<f64> = TanhParameters { c0: 1.6867, c1: 0.3385, c2: -0.2319, c3: 0.3211 };
/// Table 1: q, ρ, τ, α.
pub const PLAYS: [f64; 4] = [0.2959, 0.1827, 5.4999, 0.08];
/// Table 2.
pub const WEIGHTS: [f64; SIZE] =
    [0.1207, 0.0246, 0.0405, 0.0694, 0.0357, -0.0238, -0.0070, -0.0401, -0.0223, 0.0625];

/// The raw parameters of the tabled model.
///
/// # Errors
/// None in practice: the tabled values are valid. The type is that of the steps that lead here.
///
/// ```
/// use model_core::{Hysteresis, Mgpi};
///
/// let muscle = Mgpi::try_new(&model_core::paper::mgpi()?)?;
/// let (rest, longest) = muscle.output_range();
/// assert!(longest - rest > 0.2 * model_core::paper::MUSCLE_LENGTH_MM); // it contracts by more than a fifth
/// # Ok::<(), Box<dyn core::error::Error>>(())
/// ```
pub fn mgpi() -> Result<MgpiParameters<f64, SIZE, SIZE>, ParameterError> {
    let [q, rho, tau, alpha] = PLAYS;
    let plays = PlayParameters::exponential(SIZE, q, rho, tau, alpha)?;
    let envelope = TanhEnvelope::try_new(ENVELOPE)?;
    let bank = PlayBank::try_new(&plays)?;
    let mut state = bank.rest_state(envelope.value(0.0));
    let u_max = bank.advance(&mut state, envelope.value(PRESSURE_MAX_BAR));
    let thresholds = List::from(core::array::from_fn(|j| j as f64 / SIZE as f64 * u_max));
    let weights = List::from(WEIGHTS.map(|weight| weight * MUSCLE_LENGTH_MM));
    Ok(MgpiParameters {
        envelope: EnvelopeParameters::Tanh(ENVELOPE),
        plays,
        dead_zones: DeadZoneParameters { thresholds, weights, offset: 0.0 },
        input_min: 0.0,
        input_max: PRESSURE_MAX_BAR,
        preconditioned: false,
    })
}
