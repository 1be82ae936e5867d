//! Extensions: what a muscle on a valve does beside hysteresis, each effect as a model and as its
//! compensation.
//!
//! # The chain
//! ```text
//! command ─▶ dead band ─▶ supply ─▶ lag ─▶ pressure ─▶ delay ─▶ creep ─▶ balance ─▶ u ─▶ operator ─▶ y₀
//!      y₀ ─▶ balance ─▶ creep ─▶ drift, tone ─▶ y
//! ```
//! All effects on the balance of forces are an equivalent input: pressure = u + what they take
//! (`balance`). Then the inverse is explicit, u = operator⁻¹(y₀) and add, and the model is one root
//! in u. The same effects may act behind the operator, on the contraction: y₀ = contraction + what
//! they take ([`site`]).
//!
//! | effect | where | file |
//! |---|---|---|
//! | dead band, supply, lag of the valve | before the pressure | [`valve_deadband`], [`supply_saturation`], [`valve_lag`] |
//! | dead time | of the pressure | [`transport_delay`] |
//! | load, temperature | either balance | [`schedule`] |
//! | warm-up | either balance | [`warm_up`] |
//! | viscosity, inertia | either balance | `viscous_lag`, `inertia` |
//! | width that depends on the rate | balance before the operator, or the operator's plays | [`rate_dependent_width`], [`rate_dependent_thresholds`] |
//! | creep | pressure or contraction | [`creep`] |
//! | drift, tone | output | [`drift`], [`periodic_disturbance`] |
//!
//! # Contract
//! [`ExtendedModel`] and [`ExtendedInverse`] are made of raw parameters that are checked once.
//! Without extensions they are the operator and its inverse, bit for bit.
//!
//! * The first sample finds the muscle standing still, the valve where it is, creep at its end:
//!   that is how recordings begin. Time, drift and tone count from it.
//! * Steps may be unequal in the model; the inverse has a fixed period, for which all exponentials
//!   are computed beforehand.
//! * Forward of inverse is exact up to rounding, but for a held dead band, thresholds by the rate
//!   of the pressure, and what limits cut off.
//!
//! # Limits
//! The inverse takes load and temperature as they are, not as they will be after the delay.

use crate::error::ParameterError;
use crate::real::Real;

mod balance;
pub mod creep;
mod derivative;
pub mod drift;
mod effects;
mod forward;
mod inertia;
mod inverse;
pub(crate) mod output;
pub mod periodic_disturbance;
pub(crate) mod preview;
pub mod profile;
pub mod rate_dependent_thresholds;
pub mod rate_dependent_width;
mod relaxation;
mod ring;
pub(crate) mod root;
pub mod schedule;
pub mod site;
mod sliding;
pub(crate) mod smoother;
mod sum;
pub mod supply_saturation;
mod term;
pub mod transport_delay;
mod valve;
pub mod valve_deadband;
pub mod valve_lag;
mod viscous_lag;
pub mod warm_up;

pub use creep::CreepParameters;
pub use drift::DriftParameters;
pub use forward::{ExtendedModel, ExtendedState, Output, Sample};
pub use inverse::{ExtendedInverse, ExtendedInverseState};
pub use periodic_disturbance::PeriodicDisturbanceParameters;
pub use profile::ProfileParameters;
pub use rate_dependent_thresholds::{PressureRateParameters, RateDependentThresholdsParameters};
pub use rate_dependent_width::RateDependentWidthParameters;
pub use schedule::ScheduleParameters;
pub use site::{Site, Sites};
pub use supply_saturation::SupplySaturationParameters;
pub use transport_delay::TransportDelayParameters;
pub use valve_deadband::{DeadbandForm, ValveDeadbandParameters};
pub use valve_lag::{ValveLag, ValveLagForm, ValveLagMemory, ValveLagParameters, ValveLagStep};
pub use warm_up::WarmUpParameters;

/// Raw parameters of the effects that a model is extended by, each by the name of its cause.
///
/// ```
/// use model_core::ExtensionParameters;
/// use model_core::extension::TransportDelayParameters;
///
/// let transport_delay = Some(TransportDelayParameters { delay_s: 0.02 });
/// let late = ExtensionParameters { transport_delay, ..Default::default() };
/// assert_eq!(late.preview_s(0.001), 0.02); // s: the reference has to be known so much ahead
/// ```
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(
    feature = "serde",
    derive(serde::Serialize, serde::Deserialize),
    serde(bound = "T: Real + serde::Serialize + serde::de::DeserializeOwned")
)]
#[allow(missing_docs, reason = "the fields are the effects of the module's table")]
pub struct ExtensionParameters<T> {
    pub valve_deadband: Option<ValveDeadbandParameters<T>>,
    pub supply_saturation: Option<SupplySaturationParameters<T>>,
    pub valve_lag: Option<ValveLagParameters<T>>,
    pub transport_delay: Option<TransportDelayParameters<T>>,
    pub load: Option<ScheduleParameters<T>>,
    pub temperature: Option<ScheduleParameters<T>>,
    pub warm_up: Option<WarmUpParameters<T>>,
    /// Nowhere below 0. Unit: input unit s/output unit; behind the hysteresis s.
    pub viscous_lag: Option<ProfileParameters<T>>,
    /// Nowhere below 0. Unit: input unit s²/output unit; behind the hysteresis s².
    pub inertia: Option<ProfileParameters<T>>,
    pub rate_dependent_width: Option<RateDependentWidthParameters<T>>,
    /// The same cause in the thresholds.
    pub rate_dependent_thresholds: Option<RateDependentThresholdsParameters<T>>,
    pub creep: Option<CreepParameters<T>>,
    pub drift: Option<DriftParameters<T>>,
    pub periodic_disturbance: Option<PeriodicDisturbanceParameters<T>>,
    /// Where they act.
    pub sites: Sites,
}

impl<T> Default for ExtensionParameters<T> {
    /// No effects.
    fn default() -> Self {
        Self {
            valve_deadband: None,
            supply_saturation: None,
            valve_lag: None,
            transport_delay: None,
            load: None,
            temperature: None,
            warm_up: None,
            viscous_lag: None,
            inertia: None,
            rate_dependent_width: None,
            rate_dependent_thresholds: None,
            creep: None,
            drift: None,
            periodic_disturbance: None,
            sites: Sites::default(),
        }
    }
}

impl<T: Real> ExtensionParameters<T> {
    /// Those of the muscle alone, from pressure to contraction.
    #[must_use]
    pub fn without_valve(&self) -> Self {
        Self { valve_deadband: None, supply_saturation: None, valve_lag: None, ..self.clone() }
    }

    /// Without the drift and the tone that are left to feedback.
    #[must_use]
    pub fn compensated(&self) -> Self {
        Self {
            drift: self.drift.filter(|drift| drift.compensated),
            periodic_disturbance: self.periodic_disturbance.filter(|tone| tone.compensated),
            ..self.clone()
        }
    }

    /// How far ahead of time a controller at this period has to be given its reference: by the
    /// delay, and where there is a mass by the lag of what smooths the reference for it
    /// ([`crate::tracking`]). Both: s.
    pub fn preview_s(&self, period_s: T) -> T {
        let delay_s = self.transport_delay.map_or(T::ZERO, |delay| delay.delay_s);
        if self.has_mass() { delay_s + smoother::lag_s(period_s) } else { delay_s }
    }

    /// Whether the reference's second derivative is asked for.
    pub(crate) fn has_mass(&self) -> bool {
        self.inertia.is_some()
    }

    /// The same parameters in another number type, for instance that of the board.
    ///
    /// # Errors
    /// None in practice: the capacities are the same.
    pub fn convert<U: Real>(&self) -> Result<ExtensionParameters<U>, ParameterError> {
        Ok(ExtensionParameters {
            valve_deadband: self.valve_deadband.map(|valve| valve.convert()),
            supply_saturation: self.supply_saturation.map(|supply| supply.convert()),
            valve_lag: self.valve_lag.map(|lag| lag.convert()),
            transport_delay: self.transport_delay.map(|delay| delay.convert()),
            load: each(&self.load, ScheduleParameters::convert)?,
            temperature: each(&self.temperature, ScheduleParameters::convert)?,
            warm_up: each(&self.warm_up, WarmUpParameters::convert)?,
            viscous_lag: each(&self.viscous_lag, ProfileParameters::convert)?,
            inertia: each(&self.inertia, ProfileParameters::convert)?,
            rate_dependent_width: each(&self.rate_dependent_width, RateDependentWidthParameters::convert)?,
            rate_dependent_thresholds: each(
                &self.rate_dependent_thresholds,
                RateDependentThresholdsParameters::convert,
            )?,
            creep: each(&self.creep, CreepParameters::convert)?,
            drift: self.drift.map(|drift| drift.convert()),
            periodic_disturbance: self.periodic_disturbance.map(|tone| tone.convert()),
            sites: self.sites,
        })
    }
}

/// What is measured of a muscle's surroundings; what is not is taken to be at its reference.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Surroundings<T> {
    /// The load. Unit: N.
    pub load: Option<T>,
    /// The temperature. Unit: °C.
    pub temperature: Option<T>,
}

impl<T: Real> Surroundings<T> {
    /// Whether there is no infinity and no NaN.
    pub(crate) fn is_finite(&self) -> bool {
        self.load.is_none_or(T::is_finite) && self.temperature.is_none_or(T::is_finite)
    }
}

/// What becomes of the parameters of an effect, if it is there.
fn each<P, Q>(
    parameters: &Option<P>,
    become_of: impl Fn(&P) -> Result<Q, ParameterError>,
) -> Result<Option<Q>, ParameterError> {
    parameters.as_ref().map(become_of).transpose()
}
