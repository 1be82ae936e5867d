//! The parameters of the extended model's effects, in the units that people measure in.
//!
//! An equivalent input becomes a change of contraction by the slope of the operator's loop, where it slides.

use model_core::ExtensionParameters;
use model_core::extension::profile::Profile;
use model_core::extension::{ProfileParameters, RateDependentThresholdsParameters, Site};

use super::Extension;
use crate::cause::Cause;
use crate::effect::{Driver, Rate};
use crate::physical::{self, Parameters};
use crate::turn::Loop;

/// The parameters of the muscle's effects: a model that runs free is not misled by the noise of measured rates, and its operator
/// takes up less of what the effects do. None where there is no loop to take them from.
pub fn parameters(model: &Extension) -> Option<Vec<(Cause, Parameters)>> {
    let turn = Loop::of_operator(&model.parameters)?;
    let ExtensionParameters {
        transport_delay,
        load,
        temperature,
        warm_up,
        viscous_lag,
        inertia,
        rate_dependent_thresholds,
        creep,
        drift,
        periodic_disturbance,
        sites,
        ..
    } = &model.extensions;
    let mut all = Vec::new();
    if let Some(delay) = transport_delay {
        all.push((Cause::TransportDelay, vec![("delay_s", delay.delay_s)]));
    }
    let mut add_moved = |cause, driver, lambda: f64, site, ProfileParameters { knots, values }: &_| {
        let change = |(&knot, value): (&f64, &f64)| -value * per_input(&turn, site, knot);
        let changes: Vec<f64> = knots.iter().zip(values).map(change).collect();
        all.push((cause, physical::moved(knots, cause, driver, lambda, &changes)));
    };
    if let Some(load) = load {
        add_moved(Cause::Load, Driver::Load, 0.0, sites.load, &load.offset);
    }
    if let Some(temperature) = temperature {
        add_moved(Cause::Temperature, Driver::Temperature, 0.0, sites.temperature, &temperature.offset);
    }
    if let Some(warm_up) = warm_up {
        add_moved(Cause::WarmUp, Driver::WarmUp, warm_up.travel.ln(), sites.warm_up, &warm_up.offset);
    }
    // At mid stroke.
    let late = |profile: &Option<ProfileParameters<f64>>, site| -> Option<f64> {
        let profile = profile.as_ref()?;
        let middle = middle(profile);
        Some(Profile::try_new(profile, "profile", "").ok()?.value(middle) * per_input(&turn, site, middle))
    };
    match (late(inertia, sites.inertia), late(viscous_lag, sites.viscous_lag)) {
        (Some(mass), damping) => {
            let damping = damping.unwrap_or(0.0);
            all.push((Cause::Inertia, physical::ringing(mass, damping)));
            // Of a viscous lag beside it: the damping that the two share.
            all.push((Cause::ViscousLag, vec![("time_constant_s", damping)]));
        }
        (None, Some(time_constant_s)) => {
            all.push((Cause::ViscousLag, vec![("time_constant_s", time_constant_s)]));
        }
        (None, None) => {}
    }
    if let Some(thresholds) = rate_dependent_thresholds {
        let RateDependentThresholdsParameters { exponent, gain, pressure, .. } = thresholds;
        let (gain, rate) = match pressure {
            Some(pressure) => (pressure.gain, Rate::Input),
            None => (Profile::try_new(gain, "profile", "").ok()?.value(middle(gain)), Rate::Contraction),
        };
        all.push((Cause::RateDependentWidth, physical::width(gain, *exponent, rate)));
    }
    if let Some(creep) = creep {
        all.push((Cause::Creep, physical::creep(&creep.fractions, &creep.time_constants_s)));
    }
    if let Some(drift) = drift {
        all.push((Cause::Drift, vec![("mm_per_s", drift.rate_per_s)]));
    }
    if let Some(tone) = periodic_disturbance {
        let parameters = vec![("frequency_hz", tone.frequency_hz), ("amplitude_mm", tone.amplitude)];
        all.push((Cause::PeriodicDisturbance, parameters));
    }
    Some(all)
}

/// What of an effect's strength shows in the contraction.
fn per_input(turn: &Loop, site: Site, at: f64) -> f64 {
    match site {
        Site::Pressure => turn.slope(at),
        Site::Contraction => 1.0,
    }
}

fn middle(profile: &ProfileParameters<f64>) -> f64 {
    let ends = profile.knots.first().zip(profile.knots.last());
    ends.map_or(0.0, |(first, last)| 0.5 * (first + last))
}
