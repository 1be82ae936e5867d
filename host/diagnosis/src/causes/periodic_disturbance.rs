//! A tone that has nothing to do with the input.

use model_core::ExtensionParameters;
use model_core::extension::PeriodicDisturbanceParameters;

use super::kind::{About, Fits, Kind, Stage};
use super::needs::{Judge, Judged, ROUNDING};
use crate::anatomy::excitation::Excitation;
use crate::anatomy::spectrum::LEAST_PERIODS;
use crate::carrier::Carrier;
use crate::effect::{Effect, Form, Parameter};
use crate::fitted::{Fitted, Parameters};
use crate::plan::part::Part;
use crate::signals::Signals;
use crate::simulated::Simulated;
use recording::numbers::apart;

/// The shortest recording in which a tone is told from anything else. Unit: s.
const SHORTEST_S: f64 = 10.0;
/// Tones to try.
const TONES: usize = 2;

/// The cause.
pub struct PeriodicDisturbance;

/// A tone of this frequency. Unit: Hz.
fn tone(frequency_hz: f64, signals: &Signals) -> Effect {
    let width_hz = 1.0 / signals.duration_s();
    let low_hz = (frequency_hz - 2.0 * width_hz).max(LEAST_PERIODS * width_hz);
    let high_hz = frequency_hz + 2.0 * width_hz;
    Effect::new(Form::Tone, [Parameter::new(frequency_hz, low_hz, high_hz, 1e-3 * width_hz)])
}

/// `amplitude`: output unit.
fn named(frequency_hz: f64, amplitude: f64) -> Parameters {
    vec![("frequency_hz", frequency_hz), ("amplitude_mm", amplitude)]
}

impl Kind for PeriodicDisturbance {
    fn about(&self) -> &'static About {
        &About {
            name: "periodic_disturbance",
            meaning: "There is a tone that has nothing to do with the input",
            stage: Stage::Output,
            fits: Fits::Excited,
            parts: &[Part::Ramps, Part::LongHolds],
            ..About::PLAIN
        }
    }

    fn needs(&self, judge: &Judge<'_>) -> Judged {
        let Excitation { duration_s, step_s, .. } = judge.excitation;
        // The last row lasts as long as the others.
        let lasts_s = duration_s + step_s;
        if lasts_s < SHORTEST_S * (1.0 - ROUNDING) {
            return Err(format!(
                "{} s are too short, {SHORTEST_S} s are needed",
                apart(lasts_s, SHORTEST_S, 1)
            ));
        }
        Ok(format!("frequencies from {:.3} to {:.1} Hz", 4.0 / duration_s, 0.5 / step_s))
    }

    /// From the peaks of the residual's spectrum.
    fn starts_beside(&self, signals: &Signals, left: &[f64]) -> Vec<Effect> {
        signals.tones(left, TONES).into_iter().map(|frequency_hz| tone(frequency_hz, signals)).collect()
    }

    fn parameters(&self, fitted: &Fitted<'_>) -> Parameters {
        named(fitted.parameter(0), fitted.weight(0).hypot(fitted.weight(1)))
    }

    fn extend(&self, carrier: &Carrier<'_>, all: &mut ExtensionParameters<f64>) {
        let [sine, cosine] = [0, 1].map(|i| carrier.fitted.weight(i));
        all.periodic_disturbance = Some(PeriodicDisturbanceParameters {
            amplitude: sine.hypot(cosine),
            frequency_hz: carrier.fitted.parameter(0),
            phase_rad: cosine.atan2(sine),
            compensated: false,
        });
    }

    fn written(&self, model: &Simulated<'_>) -> Option<Parameters> {
        model.extensions.periodic_disturbance.map(|tone| named(tone.frequency_hz, tone.amplitude))
    }
}
