//! Viscous force: the contraction follows the static curve with a lag.
//!
//! Beside a mass it is one equation of second order with that, and what damps it.

use model_core::ExtensionParameters;
use model_core::extension::Site;

use super::kind::{About, Kind, Law, Stage};
use super::needs::{Judge, Judged, Lack};
use crate::carrier::Carrier;
use crate::effect::{Driver, Effect, Form, Parameter};
use crate::fitted::{Doubt, Fitted, Parameters};
use crate::plan::part::Part;
use crate::signals::Signals;
use crate::simulated::Simulated;
use recording::numbers::root_mean_square;

/// The name of its parameter.
const TIME_CONSTANT: &str = "time_constant_s";
/// The shortest lag that shows: of less no recording's own timing is free. Unit: row.
const LEAST: f64 = 0.5;

/// The cause.
pub struct ViscousLag;

impl ViscousLag {
    fn time_constant_s(fitted: &Fitted<'_>) -> f64 {
        match fitted.form() {
            Form::Driven(_) => fitted.at_middle(0) * fitted.slope(),
            _ => fitted.weight_at_middle(0),
        }
    }
}

impl Kind for ViscousLag {
    fn about(&self) -> &'static About {
        &About {
            name: "viscous_lag",
            meaning: "A force against the speed makes the contraction follow its static curve late",
            law: Law::Viscosity,
            stage: Stage::Motion,
            alike_without: &[Lack::Speeds, Lack::LongHolds],
            taken_for: &["inertia", "rate_dependent_width", "transport_delay"],
            told_from: &[
                (
                    "rate_dependent_width",
                    "when the input stops, what lags comes after; a loop that was wide for its speed stays where it is",
                ),
                ("inertia", "after a jump a mass overshoots, a lag does not"),
                ("creep", "in a long hold a lag ends, creep goes on over decades of time"),
            ],
            parts: &[Part::Speeds, Part::Jumps],
            ..About::PLAIN
        }
    }

    fn needs(&self, judge: &Judge<'_>) -> Judged {
        judge.lag()
    }

    fn starts(&self, signals: &Signals) -> Vec<Effect> {
        let strengths = Parameter::strengths(signals, root_mean_square(&signals.rate), 0.0);
        vec![Effect::new(Form::Driven(Driver::Rate), strengths), Effect::new(Form::OutputLag, [])]
    }

    fn parameters(&self, fitted: &Fitted<'_>) -> Parameters {
        vec![(TIME_CONSTANT, Self::time_constant_s(fitted))]
    }

    fn doubt(&self, fitted: &Fitted<'_>, _longest_hold_s: f64) -> Option<Doubt> {
        let shows = Self::time_constant_s(fitted) >= LEAST * fitted.signals.step_s;
        (!shows).then_some(Doubt::Unseen)
    }

    fn extend(&self, carrier: &Carrier<'_>, all: &mut ExtensionParameters<f64>) {
        match carrier.fitted.form() {
            Form::Driven(_) => carrier.add_viscosity(all, Site::Pressure, carrier.through(0)),
            Form::OutputLag => carrier.add_viscosity(all, Site::Contraction, carrier.behind(0)),
            // The model has no third order: beside a mass its rate and acceleration have both.
            _ => {}
        }
    }

    /// The damping of a mass is the mass's.
    fn written(&self, model: &Simulated<'_>) -> Option<Parameters> {
        self.measured(model).filter(|_| model.extensions.inertia.is_none())
    }

    /// Beside a mass: the damping that the two share.
    fn measured(&self, model: &Simulated<'_>) -> Option<Parameters> {
        let all = model.extensions;
        let lag_s = model.late(&all.viscous_lag, all.sites.viscous_lag);
        let beside_mass = || all.inertia.as_ref().map(|_| 0.0);
        lag_s.or_else(beside_mass).map(|lag_s| vec![(TIME_CONSTANT, lag_s)])
    }
}
