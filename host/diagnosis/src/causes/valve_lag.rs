//! The pressure follows the command late.
//!
//! Any regulator has one: up to [`ORDINARY_LAG_S`] it is not named.

use model_core::ExtensionParameters;
use model_core::extension::ValveLagForm;

use super::kind::{About, Fits, Kind, RECORD_PRESSURE, Stage};
use super::needs::{Judge, Judged, Lack, ValveView};
use crate::carrier::Carrier;
use crate::effect::Effect;
use crate::fitted::{Fitted, Parameters};
use crate::plan::part::Part;
use crate::regulator::{self, LEAST_LAG, so_late};
use crate::second_order::DAMPING_RATIO;
use crate::signals::Signals;
use crate::simulated::Simulated;
use crate::valve::{ORDINARY_LAG_S, ValvePart};

/// The name of its parameter.
const TIME_CONSTANT: &str = "time_constant_s";
/// Where the search begins: choices, a factor of two apart, which is near enough for the fit to find the rest. Unit: s.
const BEGIN_S: [f64; 3] = [0.1, 0.2, 0.4];
/// The longest lag that is looked for. Unit: s.
const LONGEST_S: f64 = 10.0;

/// The cause.
pub struct ValveLag;

impl Kind for ValveLag {
    fn about(&self) -> &'static About {
        &About {
            name: "valve_lag",
            meaning: "The pressure follows the command late",
            stage: Stage::Valve,
            fits: Fits::Command,
            alike_without: &[Lack::Speeds],
            taken_for: &["transport_delay", "viscous_lag"],
            in_valve: Some((ValvePart::Lag, TIME_CONSTANT)),
            told_from: &[(
                "viscous_lag",
                "record the pressure too: it follows the command late, or it does not",
            )],
            parts: &[Part::Speeds, Part::Jumps],
            note: Some(RECORD_PRESSURE),
            ..About::PLAIN
        }
    }

    fn needs(&self, judge: &Judge<'_>) -> Judged {
        let valve = judge.valve_seen()?;
        let seen = match judge.valve {
            ValveView::Beside(excitation) => Judge { excitation, ..*judge }.lag()?,
            ValveView::Unseen | ValveView::InChain => judge.lag()?,
        };
        Ok(format!("{valve}; {seen}"))
    }

    fn starts(&self, signals: &Signals) -> Vec<Effect> {
        let low_s = ORDINARY_LAG_S.max(LEAST_LAG * signals.step_s);
        let bounds_s = (low_s, (signals.duration_s() / 3.0).clamp(low_s, LONGEST_S.max(low_s)));
        let regulators = |command| BEGIN_S.map(|late_s| so_late(command, late_s, bounds_s));
        signals.command.into_iter().flat_map(regulators).flatten().collect()
    }

    fn parameters(&self, fitted: &Fitted<'_>) -> Parameters {
        let valve = regulator::valve(fitted.effect);
        vec![(TIME_CONSTANT, valve.map_or(0.0, |valve| valve.longer_lag_s()))]
    }

    fn extend(&self, carrier: &Carrier<'_>, all: &mut ExtensionParameters<f64>) {
        all.valve_lag = regulator::valve(carrier.fitted.effect).map(|valve| valve.lag());
    }

    fn written(&self, model: &Simulated<'_>) -> Option<Parameters> {
        model.extensions.valve_lag.map(|lag| {
            let form = match lag.form {
                ValveLagForm::FirstOrder => Vec::new(),
                ValveLagForm::SecondOrder { damping_ratio } => vec![(DAMPING_RATIO, damping_ratio)],
                ValveLagForm::Orifice { supply, .. } => vec![("absolute_supply_bar", supply)],
            };
            [(TIME_CONSTANT, lag.time_constant_s)].into_iter().chain(form).collect()
        })
    }
}
