//! Mass and viscosity: in the balance of forces one equation of second order, by which a mass rings or is damped.

use std::f64::consts::PI;

use super::basis::Basis;
use super::causes::{Cause, Law};
use super::effect::{Driver, Form};
use super::fit::Fit;
use super::fitted::{Parameters, value};
use super::physical::parameters;
use super::signals::Signals;

/// From this damping ratio on a mass overshoots by less than a tenth.
pub const DAMPED: f64 = 0.6;
/// Below this one by more than a sixth.
pub const RINGS: f64 = 0.5;
/// The name of a mass's damping ratio.
pub const DAMPING_RATIO: &str = "damping_ratio";

/// The damping ratio and the natural frequency (Hz) of a mass, by its parameters.
pub fn damping(mass: &Parameters) -> Option<(f64, f64)> {
    value(mass, DAMPING_RATIO).zip(value(mass, "natural_frequency_hz"))
}

/// The damping ratio of the mass, if there is one, by all that damps it.
pub fn damping_ratio(signals: &Signals, basis: &Basis, causes: &[Cause], fit: &Fit) -> Option<f64> {
    if causes.iter().all(|cause| cause.law() != Law::Mass) {
        return None;
    }
    let all = parameters(signals, basis, causes, fit);
    let of = |law| all.iter().find(|(cause, _)| cause.law() == law).map(|(_, parameters)| parameters);
    let (own, frequency_hz) = damping(of(Law::Mass)?)?;
    let lag = of(Law::Viscosity).filter(|_| has_mass_and_viscosity_in_balance(fit));
    let lag_s = lag.and_then(|parameters| parameters.first()).map_or(0.0, |(_, lag_s)| *lag_s);
    Some(damped(own, frequency_hz, lag_s))
}

/// Whether there are a mass and a viscous force beside it, both in the balance: one equation of second order.
pub fn has_mass_and_viscosity_in_balance(fit: &Fit) -> bool {
    let has = |form: Form| fit.effects.iter().any(|effect| effect.form == form);
    has(Form::Inertia) && has(Form::Driven(Driver::Rate))
}

/// The damping ratio of a mass with a viscous force beside it, of this time constant alone.
pub fn damped(own: f64, natural_frequency_hz: f64, lag_s: f64) -> f64 {
    own + PI * natural_frequency_hz * lag_s
}
