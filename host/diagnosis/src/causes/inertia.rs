//! Mass: overshoot and ringing.
//!
//! It has the viscosity in it that damps it: what is damped so far that it does not overshoot comes to two causes.

use model_core::ExtensionParameters;
use model_core::extension::{ProfileParameters, Site};

use super::kind::{About, Kind, Law, RECORD_FAST, Stage};
use super::needs::{Judge, Judged, ROUNDING};
use crate::anatomy::excitation::Excitation;
use crate::carrier::Carrier;
use crate::effect::{Effect, Form, Parameter};
use crate::fitted::{Doubt, Fitted, Parameters, value};
use crate::plan::part::Part;
use crate::signals::{Signals, TENTS};
use crate::simulated::Simulated;
use recording::numbers::{apart, legible, root_mean_square};

/// A fast swing goes over so many spans of the input in a second, that is over one in 2.5 s; what a mass does is not seen in slower ones.
/// A choice; no error level is calibrated for it. Unit: 1/s.
const FAST_SPANS: f64 = 0.4;
/// The longest sample time with which ringing is seen: four samples in a period of 5 Hz. A choice; no error level is calibrated for it.
/// Unit: s.
const RINGING_STEP_S: f64 = 0.05;

/// The cause.
pub struct Inertia;

/// Natural frequency and damping of y + damping y' + mass y''.
fn ringing(mass: f64, damping: f64) -> Parameters {
    let natural_per_s = mass.max(1e-12).sqrt().recip();
    vec![
        ("natural_frequency_hz", natural_per_s / std::f64::consts::TAU),
        ("damping_ratio", 0.5 * damping * natural_per_s),
    ]
}

impl Kind for Inertia {
    fn about(&self) -> &'static About {
        &About {
            name: "inertia",
            meaning: "A mass overshoots and rings",
            law: Law::Mass,
            stage: Stage::Motion,
            // Than the viscous lag.
            containment: 0.05,
            taken_for: &["viscous_lag", "transport_delay"],
            parts: &[Part::Speeds, Part::Jumps],
            note: Some(RECORD_FAST),
            ..About::PLAIN
        }
    }

    fn needs(&self, judge: &Judge<'_>) -> Judged {
        let Excitation { fastest, jumps, input_span, step_s, .. } = judge.excitation;
        let unit = judge.unit;
        // Differences of times are rounded.
        if *step_s > RINGING_STEP_S * (1.0 + ROUNDING) {
            let (rate_hz, least_hz) = (1.0 / step_s, 1.0 / RINGING_STEP_S);
            return Err(format!(
                "{} rows a second are too few for ringing, at least {least_hz:.0} are needed",
                apart(rate_hz, least_hz, 0)
            ));
        }
        let needed = FAST_SPANS * input_span;
        if *fastest < needed {
            return Err(format!(
                "the fastest swing has {} {unit}/s, and {} {unit}/s is needed to excite a mass",
                legible(*fastest, 2),
                legible(needed, 2)
            ));
        }
        Ok(format!("swings of up to {} {unit}/s, {jumps} jumps that end in a hold", legible(*fastest, 2)))
    }

    fn starts(&self, signals: &Signals) -> Vec<Effect> {
        let masses = Parameter::strengths(signals, root_mean_square(&signals.acceleration), 0.0);
        let viscosities = Parameter::strengths(signals, root_mean_square(&signals.rate), 0.0);
        let both = masses.into_iter().chain(viscosities);
        vec![Effect::new(Form::Inertia, both), Effect::new(Form::OutputInertia, [])]
    }

    fn parameters(&self, fitted: &Fitted<'_>) -> Parameters {
        match fitted.form() {
            Form::Inertia => {
                let slope = fitted.slope();
                ringing(fitted.at_middle(0) * slope, fitted.at_middle(TENTS) * slope)
            }
            _ => ringing(fitted.weight_at_middle(0), fitted.weight_at_middle(TENTS)),
        }
    }

    /// A mass swings: damped beyond that it is two lags.
    fn doubt(&self, fitted: &Fitted<'_>, _longest_hold_s: f64) -> Option<Doubt> {
        let swings = value(&self.parameters(fitted), "damping_ratio").is_some_and(|ratio| ratio < 1.0);
        (!swings).then_some(Doubt::Unseen)
    }

    fn extend(&self, carrier: &Carrier<'_>, all: &mut ExtensionParameters<f64>) {
        let (mass, viscosity, site) = match carrier.fitted.form() {
            Form::Inertia => {
                // By how much more input a change takes where the muscle is.
                let stiffer = |mut profile: ProfileParameters<f64>| {
                    let knots = profile.knots.iter().zip(&mut profile.values);
                    knots.for_each(|(&y, value)| *value *= carrier.fitted.signals.stiffer(y));
                    profile
                };
                (stiffer(carrier.through(0)), stiffer(carrier.through(TENTS)), Site::Pressure)
            }
            _ => (carrier.behind(0), carrier.behind(TENTS), Site::Contraction),
        };
        all.inertia = Some(mass);
        all.sites.inertia = site;
        carrier.add_viscosity(all, site, viscosity);
    }

    fn written(&self, model: &Simulated<'_>) -> Option<Parameters> {
        let all = model.extensions;
        let mass = model.late(&all.inertia, all.sites.inertia)?;
        Some(ringing(mass, model.late(&all.viscous_lag, all.sites.viscous_lag).unwrap_or(0.0)))
    }
}
